// `mss thesis`: mechanisms, directions and landings have the values that theory gives.
#include "experiments/studies/thesis/thesis.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/landing.hpp"
#include "tests/experiments/stop_after.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::thesis {
namespace {

ThesisConfig small_config() {
  ThesisConfig config = thesis_config({.quick = true});
  config.deformations = {{"sheared by 0.3", {0.3, 0, 0}, 0}};
  config.direction_cells = {2};
  config.volume_shares = {0, 1e-4, 1e-3};
  config.shape_cells = 2;
  config.twist_cells = {3};
  config.landing_cases = {{"Algorithm 2"}};
  config.landing_speeds = {10, 200};
  config.frame_cells = {};
  config.timing_repetitions = 2;
  return config;
}

// Of 3 x 3 x 3 cells edges form 48 straight chains of 3, 144 independent constraints of 192 unknowns: 42
// mechanisms. Of edges and body diagonals a cell has three; with the thesis's count of 3 x 3 x 3 cells,
// three are left too. Released edges have nothing that would turn them
// back.
TEST(Thesis, FewerSpringsLeaveMechanisms) {
  const Table rows = measure_unloading(small_config(), Progress());
  const std::map<std::string, double> mechanisms{
      {"full", 0}, {"one face diagonal", 0}, {"no face diagonals", 3}, {"edges alone", 42}};
  ASSERT_EQ(rows.size(), mechanisms.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    SCOPED_TRACE(rows.text(r, "springs"));
    EXPECT_EQ(rows.number(r, "mechanisms"), mechanisms.at(rows.text(r, "springs")));
    if (rows.text(r, "springs") == "edges alone") {
      EXPECT_GT(rows.number(r, "share"), 0.9);
      EXPECT_NEAR(rows.number(r, "stored"), 0, 1e-6);
    } else {
      EXPECT_NEAR(rows.number(r, "share"), 0, 1e-5);
    }
  }
}

// A cube differs from the infinite lattice by its surface alone, in proportion to 1 / n, and not at all along
// its edges if its springs are those of a cubic material.
TEST(Thesis, DirectionsFollowTheClosedForm) {
  ThesisConfig config = small_config();
  config.direction_cells = {4, 8};
  const Table rows = measure_directions(config, Progress());
  ASSERT_EQ(rows.size(), 72U);
  std::map<std::string, std::vector<double>> errors;
  std::map<std::string, double> young;  // of calibrated springs
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string name = rows.text(r, "material") + " " + rows.text(r, "springs") + " " +
                             rows.text(r, "modulus") + " " + rows.text(r, "direction");
    errors[name].push_back(rows.number(r, "measured") / rows.number(r, "closed_form") - 1);
    young[name] = rows.number(r, "closed_form");
  }
  int surfaces = 0;
  for (const auto& [name, error] : errors)
    if (std::abs(error[0]) > 1e-3) {
      EXPECT_NEAR(error[0] / error[1], 8, 1) << name;
      ++surfaces;
    }
  EXPECT_GT(surfaces, 20);
  for (const char* exact :
       {"thesis's full E [1 0 0]", "thesis's full G [1 1 0] in (1 -1 0)", "calibrated full E [1 0 0]"})
    EXPECT_NEAR(errors.at(exact)[1], 0, 1e-9) << exact;
  for (const char* direction : {"[1 0 0]", "[1 1 0]", "[1 -1 0]", "[1 1 1]", "[1 1 -1]"})
    EXPECT_NEAR(young.at(std::string("calibrated full E ") + direction), 1e4, 1e-4) << direction;
  EXPECT_GT(young.at("calibrated one face diagonal E [1 1 0]") /
                young.at("calibrated one face diagonal E [1 -1 0]"),
            2);
}

TEST(Thesis, TheLatticesStiffnessIsThatOfTheMaterialCard) {
  BodyConfig config{.cell_size = 0.25, .springs = thesis_springs};
  const CubicStiffness cubic = cubic_stiffness(config.springs, config.cell_size);
  Eigen::Matrix<double, 6, 6> expected = Eigen::Matrix<double, 6, 6>::Zero();
  expected.topLeftCorner<3, 3>().setConstant(cubic.c12);
  expected.diagonal() << cubic.c11, cubic.c11, cubic.c11, cubic.c44, cubic.c44, cubic.c44;
  EXPECT_LT((lattice_stiffness(Body(config)) - expected).norm(), 1e-12 * expected.norm());
}

// Springs four times as stiff are the same motion at twice the speed: the speeds from which a cube folds
// double. Both factors are powers of two, so that not even rounding differs.
TEST(Thesis, StifferSpringsFoldAtSpeedsInProportionToTheRoot) {
  ThesisConfig config = small_config();
  config.landing_cases = {{"Algorithm 2"}, {.name = "all springs x 4", .all = 4}};
  config.landing_speeds = {30, 60, 120};
  Progress progress;
  const Table rows = measure_landings(config, progress);
  const auto row = [&](const char* name, const char* landing, double speed) {
    Table found = rows.where("case", name).where("landing", landing).where("speed", speed);
    EXPECT_EQ(found.size(), 1U);
    return found;
  };
  bool folded = false;
  for (const char* landing : {"corner", "edge", "face"})
    for (const double speed : {30.0, 60.0}) {
      const Table soft = row("Algorithm 2", landing, speed),
                  stiff = row("all springs x 4", landing, 2 * speed);
      EXPECT_EQ(soft.number(0, "min_jacobian"), stiff.number(0, "min_jacobian")) << landing << speed;
      EXPECT_EQ(soft.text(0, "outcome"), stiff.text(0, "outcome")) << landing << speed;
      folded = folded || soft.text(0, "outcome") != "recovered";
    }
  EXPECT_TRUE(folded);
}

/// Of landings on one side, at one speed after the other.
Table landings_that_end(const std::vector<std::pair<const char*, double>>& outcomes) {
  Table rows({{"case"}, {"landing"}, {"speed", "m/s"}, {"min_jacobian"}, {"outcome"}, {"status"}});
  double speed = 0;
  for (const auto& [outcome, min_jacobian] : outcomes)
    rows.add({std::string("Algorithm 2"), std::string("corner"), speed += 10, min_jacobian,
              std::string(outcome), std::string("ok")});
  return rows;
}

// A cube that ends folded is folded whether it has come to rest or not.
TEST(Thesis, CubesThatStillMoveMayBeFolded) {
  StopAfter stopped(0);
  const ThesisConfig config = small_config();
  std::vector<NamedTable> tables{{"thesis_unloading", measure_unloading(config, stopped)},
                                 {"thesis_directions", measure_directions(config, stopped)},
                                 {"thesis_figure_5_1", measure_figure_5_1(stopped)},
                                 {"thesis_twist", measure_twists(config, stopped)},
                                 {"thesis_volume_time", measure_volume_time(config, stopped)},
                                 {"thesis_shape", measure_shape(config, stopped)},
                                 {"thesis_landing", measure_landings(config, stopped)},
                                 {"thesis_frames", measure_frames(config, stopped)}};
  const auto lowest = [&](const std::vector<std::pair<const char*, double>>& outcomes) {
    tables[6].table = landings_that_end(outcomes);
    const Table summary = summary_table(tables);
    return summary.number(summary.size() - 1, "value");
  };
  EXPECT_EQ(lowest({{"recovered", 1}, {"moving", 0.5}, {"moving", -1}, {"trapped", -1}}), 30);
  EXPECT_EQ(lowest({{"recovered", 1}, {"trapped", -1}, {"moving", -1}}), 20);
  EXPECT_TRUE(std::isnan(lowest({{"recovered", 1}, {"moving", 0.5}})));
}

// To first order a volume force changes shape and volume in proportion to k_vol.
TEST(Thesis, ShapeChangesInProportionToSmallVolumeForces) {
  const Table rows = measure_shape(small_config(), Progress());
  ASSERT_EQ(rows.size(), 9U);
  for (std::size_t r = 0; r < rows.size(); r += 3) {
    ASSERT_EQ(rows.text(r + 2, "status"), "ok");
    EXPECT_EQ(rows.number(r, "shape_change"), 0);
    for (const char* column : {"shape_change", "volume_corrected", "alpha"})
      EXPECT_NEAR(rows.number(r + 2, column) / rows.number(r + 1, column), 10, 0.05) << column;
  }
}

TEST(Thesis, TwistsFoldInFineCellsAndNotWithTheFoldGuard) {
  ThesisConfig config = small_config();
  config.twist_cells = {10};
  const Table rows = measure_twists(config, Progress());
  std::map<double, double> least{{0, 1}, {1, 1}};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    ASSERT_EQ(rows.text(r, "status"), "ok");
    if (rows.number(r, "angle") < 60.1)
      least[rows.number(r, "guarded")] =
          std::min(least[rows.number(r, "guarded")], rows.number(r, "min_jacobian"));
  }
  EXPECT_LT(least[0], -1);
  EXPECT_GT(least[1], 0.5);
}

TEST(Thesis, DrawsTheSameFromItsFiles) {
  for (const int reports : {3, 1000}) {  // interrupted, and not
    StopAfter progress(reports);
    const ThesisConfig config = small_config();
    std::vector<NamedTable> tables{{"thesis_unloading", measure_unloading(config, progress)},
                                   {"thesis_directions", measure_directions(config, progress)},
                                   {"thesis_figure_5_1", measure_figure_5_1(progress)},
                                   {"thesis_twist", measure_twists(config, progress)},
                                   {"thesis_volume_time", measure_volume_time(config, progress)},
                                   {"thesis_shape", measure_shape(config, progress)},
                                   {"thesis_landing", measure_landings(config, progress)},
                                   {"thesis_frames", measure_frames(config, progress)}};
    const Table summary = summary_table(tables);
    EXPECT_GT(summary.size(), 10U);
    tables.insert(tables.begin(), {"thesis", summary});
    expect_same_drawings(find_experiment("thesis"), tables);
  }
}

// A test that ran `mss view` of itself would start itself again.
TEST(Thesis, FramesNeedTheProgram) {
  ThesisConfig config = small_config();
  config.frame_cells = {3};
  const Table rows = measure_frames(config, Progress());
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows.text(0, "status"), "not run by mss");
}

}  // namespace
}  // namespace mss::studies::thesis
