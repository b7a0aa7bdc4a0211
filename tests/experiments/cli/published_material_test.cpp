// `mss material --like`: every row of reference/materials.csv is a material that a scene takes.
#include "experiments/cli/published_material.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <set>
#include <sstream>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"

namespace mss::cli {
namespace {

using reference::published_materials;
using reference::PublishedMaterial;

TEST(PublishedMaterials, AreTheRowsOfTheTable) {
  std::ifstream file(MSS_SOURCE_DIR "/reference/materials.csv");
  std::ostringstream text;
  text << file.rdbuf();
  const std::vector<PublishedMaterial> read = reference::read_materials(text.str());
  ASSERT_EQ(read.size(), published_materials().size());
  ASSERT_GE(read.size(), 15U);
  for (std::size_t i = 0; i < read.size(); ++i) EXPECT_EQ(read[i].name, published_materials()[i].name);
}

TEST(PublishedMaterials, HaveValuesThatAreAllowedAndASource) {
  std::set<std::string> names;
  for (const PublishedMaterial& m : published_materials()) {
    SCOPED_TRACE(m.name);
    EXPECT_TRUE(names.insert(m.name).second);
    EXPECT_TRUE(m.kind == "rubber" || m.kind == "foam" || m.kind == "gel" || m.kind == "tissue") << m.kind;
    EXPECT_TRUE(0 < m.young_low && m.young_low <= m.young && m.young <= m.young_high);
    EXPECT_LT(m.young_high, 1e7);
    EXPECT_TRUE(m.poisson > -1 && m.poisson < 0.5) << m.poisson;
    EXPECT_TRUE(m.density > 10 && m.density < 2000) << m.density;
    EXPECT_EQ(std::isnan(m.loss), std::isnan(m.loss_frequency));
    if (!std::isnan(m.loss)) {
      EXPECT_TRUE(m.loss > 0 && m.loss < 2) << m.loss;
      EXPECT_GT(m.loss_frequency, 0);
    }
    EXPECT_FALSE(m.measured.empty());
    EXPECT_FALSE(m.source.empty());
  }
}

// A Kelvin-Voigt solid's loss tangent is omega eta / mu.
TEST(PublishedMaterials, BlocksAreTablesOfAScene) {
  for (const PublishedMaterial& m : published_materials()) {
    SCOPED_TRACE(m.name);
    const Scene scene = parse_scene("[body]\ncells = [1, 1, 1]\ncell_size = 0.01\n" + material_block(m));
    ASSERT_TRUE(scene.body.elastic.has_value());
    EXPECT_NEAR(scene.body.elastic->young / m.young, 1, 1e-5);
    EXPECT_EQ(scene.body.elastic->poisson, std::min(m.poisson, largest_block_poisson));
    EXPECT_EQ(scene.body.density, m.density);
    if (std::isnan(m.loss)) {
      EXPECT_EQ(scene.body.damping.law, Damping::Law::none);
    } else {
      const double omega = 2 * std::numbers::pi * m.loss_frequency;
      EXPECT_NEAR(omega * scene.body.damping.viscosity / m.shear_modulus() / m.loss, 1, 6e-3);
    }
  }
}

TEST(PublishedMaterials, AreFoundByNamesAsPeopleWriteThem) {
  EXPECT_EQ(find_published_material("Dragon Skin 10").name, "dragon_skin_10");
  EXPECT_EQ(find_published_material("ecoflex-00-30").name, "ecoflex_00_30");
  const auto refusal = [](const std::string& name) -> std::string {
    try {
      find_published_material(name);
    } catch (const InputError& error) {
      return error.what();
    }
    return "found";
  };
  EXPECT_EQ(refusal("Sylgrad 184"),
            "material 'Sylgrad 184' is unknown; did you mean 'sylgard_184'? `mss material --like` shows all");
  EXPECT_NE(refusal("gelatin").find("give one of gelatin_3, gelatin_5, gelatin_7, gelatin_3_oil; "),
            std::string::npos);
  EXPECT_EQ(refusal("granite"), "material 'granite' is unknown; `mss material --like` shows all");
}

TEST(PublishedMaterials, RowsThatAreNoneAreNamed) {
  const std::string header = "name,...\n", cells = "x,gel,1,1,1,0.3,assumed,1000,,,slow,";
  EXPECT_EQ(reference::read_materials(header + cells + "\"paper, 2020\"\n").front().source, "paper, 2020");
  const auto refusal = [&](const std::string& row) -> std::string {
    try {
      reference::read_materials(header + row + "\n");
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "read";
  };
  EXPECT_EQ(refusal(cells + "paper, 2020"), "materials.csv:2 has 13 cells, not 12");
  EXPECT_EQ(refusal("x,gel,soft,1,1,0.3,assumed,1000,,,slow,paper"),
            "materials.csv:2 has text where a number belongs");
  EXPECT_EQ(refusal("x,gel,1 kPa,1,1,0.3,assumed,1000,,,slow,paper"),
            "materials.csv:2 has text where a number belongs");
}

}  // namespace
}  // namespace mss::cli
