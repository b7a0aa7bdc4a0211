// Calibrated springs have the material they are calibrated for, and `mss validate` measures it.
#include "experiments/studies/validate/validate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/springs/spring_system.hpp"
#include "integrators/statics/linear_response.hpp"
#include "reference/calculix/calculix.hpp"
#include "reference/closed_forms.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::validate {
namespace {

/// E and nu of a cube of n^3 cells, from uniaxial tension along x.
ElasticConstants measured(const SpringConstants& springs, int n, double h) {
  const Body body({.voxels = VoxelGrid::box(n, n, n), .cell_size = h, .density = 1, .springs = springs});
  const double edge = n * h, force = 1e6;
  const auto face = [&](int axis) {
    Hold hold{.box = {{0, 0, 0}, {edge, edge, edge}}, .axes = {axis == 0, axis == 1, axis == 2}};
    hold.box.upper[axis] = 0;
    return hold;
  };
  const Box end{{edge, 0, 0}, {edge, edge, edge}};
  SpringSystem<double> system(
      body, {.holds = {face(0), face(1), face(2)}, .loads = {{.box = end, .force = {force, 0, 0}}}});
  Work work;
  const LinearResponse response = linear_response(system, {}, work);
  EXPECT_EQ(response.status, Status::ok);
  const std::ptrdiff_t corner = body.select({edge, edge, edge}, {edge, edge, edge}).front();
  const Vec3 moved = response.displacement.at(corner);
  return {.young = force / (edge * moved[0]), .poisson = -moved[1] / moved[0]};
}

TEST(Calibration, UniaxialTestsReturnTheMaterial) {
  for (const double poisson : {0.0, 0.1, 0.25, 0.3, 0.4, 0.45, 0.49})
    for (const double share : {0.25, 0.5, 1.0})
      for (const int n : {1, 2, 5}) {
        const double h = 0.2;
        const ElasticConstants given{.young = 1e5, .poisson = poisson};
        const ElasticConstants found = measured(calibrate(given, h, share), n, h);
        EXPECT_NEAR(found.young / given.young, 1, 1e-8) << poisson << " " << share << " " << n;
        EXPECT_NEAR(found.poisson, poisson, 1e-8) << poisson << " " << share << " " << n;
      }
}

TEST(Calibration, TheThesissConstantsAreWhatTheSpecificationSays) {
  const SpringConstants springs{.edge = 100, .face = 100, .body = 300, .volume = 0};
  const ElasticConstants found = measured(springs, 5, 0.2);
  EXPECT_NEAR(found.young, 1416.67, 0.01);
  EXPECT_NEAR(found.poisson, 0.4167, 1e-4);
  EXPECT_NEAR(cubic_stiffness(springs, 0.2).zener_ratio(), 5, 1e-12);
}

/// Rows of some cases, each solved once.
Table solved(const std::vector<std::string>& cases, std::vector<int> cells) {
  ValidationConfig config = validation_config({.cells = std::move(cells)});
  std::erase_if(config.cases, [&](const ValidationCase& c) {
    return std::find(cases.begin(), cases.end(), c.name) == cases.end();
  });
  config.repetitions = 1;
  config.refinement.clear();
  Progress progress;
  ValidationTables tables = measure_validation(config, progress);
  EXPECT_EQ(tables.status, Status::ok);
  for (std::size_t r = 0; r < tables.rows.size(); ++r) EXPECT_EQ(tables.rows.text(r, "status"), "ok");
  return tables.rows;
}

double number(const Table& rows, const std::string& column, const std::string& name, const std::string& model,
              int cells) {
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "case") == name && rows.text(r, "model") == model && rows.number(r, "cells") == cells)
      return rows.number(r, column);
  ADD_FAILURE() << "no row of " << name << ", " << model << ", " << cells;
  return 0;
}

// The specification's 2.632e-3 is the deflection by quadratic elements at four cells across; from eight on it
// is 2.638e-3 to 2.640e-3, because the clamp's edge is singular. Ratios and order are therefore tested as the
// specification gives them, and the experiment itself takes the finest mesh.
TEST(Validate, MeetsTheSpecificationsCantilevers) {
  constexpr double specified = 2.632e-3;
  const Table rows = solved({"cantilever", "cantilever_45"}, {1, 2, 4, 8});
  const auto ratio = [&](const std::string& model, int cells) {
    return number(rows, "value", "cantilever", model, cells) / specified;
  };
  EXPECT_NEAR(ratio("springs, t = 1", 1), 0.5545, 1e-4);
  EXPECT_NEAR(ratio("springs, t = 1", 2), 0.8124, 1e-4);
  EXPECT_NEAR(ratio("springs, t = 1", 4), 0.9417, 1e-4);
  EXPECT_NEAR(ratio("springs, t = 1", 8), 0.9853, 1e-4);
  EXPECT_NEAR(ratio("springs, t = 0.5", 1), 0.4733, 1e-4);
  EXPECT_NEAR(ratio("springs, t = 0.5", 2), 0.7671, 1e-4);
  EXPECT_NEAR(ratio("springs, t = 0.5", 4), 0.9269, 1e-4);
  EXPECT_NEAR(ratio("springs, t = 0.5", 8), 0.9814, 1e-4);
  EXPECT_NEAR(ratio("elements, linear", 4), 0.9612, 1e-4);
  for (const char* model : {"springs, t = 0.25", "springs, t = 0.5", "springs, t = 1"})
    EXPECT_NEAR(std::log2((1 - ratio(model, 4)) / (1 - ratio(model, 8))), 2, 0.1) << model;
  EXPECT_GT(number(rows, "error", "cantilever", "thesis's springs", 8), 0.05);  // refining does not help
  // Nearly incompressible, full integration locks and the lattice does not.
  const double converged = number(rows, "reference", "cantilever_45", "springs, t = 1", 4);
  EXPECT_NEAR(number(rows, "value", "cantilever_45", "elements, linear", 4) / 2.562e-3, 0.9029, 1e-4);
  EXPECT_NEAR(number(rows, "value", "cantilever_45", "springs, t = 1", 4) / 2.562e-3, 0.9500, 5e-4);
  EXPECT_NEAR(converged, 2.59e-3, 0.01e-3);
  for (const int cells : {1, 2, 4, 8})
    for (const char* model : {"springs, t = 0.25", "springs, t = 0.5", "springs, t = 1"})
      EXPECT_LT(number(rows, "error", "cantilever_45", model, cells),
                number(rows, "error", "cantilever_45", "elements, linear", cells))
          << model << " " << cells;
}

TEST(Validate, FrequenciesAreCalculixs) {
  const Table rows = solved({"vibration_bending", "vibration_torsion", "vibration_bending_2"}, {8});
  for (const char* name : {"vibration_bending", "vibration_torsion", "vibration_bending_2"})
    EXPECT_LT(number(rows, "error", name, "springs, t = 1", 8), 0.015) << name;
}

// With the thesis's springs the torsional mode follows the second bending mode: only its shape identifies it.
TEST(Validate, IdentifiesVibrationsByTheirShape) {
  const Table rows = solved({"vibration_torsion", "vibration_bending_2"}, {4});
  const auto frequency = [&](const char* name, const char* model) {
    return number(rows, "value", name, model, 4);
  };
  EXPECT_GT(frequency("vibration_torsion", "thesis's springs"),
            1.1 * frequency("vibration_bending_2", "thesis's springs"));
  EXPECT_LT(frequency("vibration_torsion", "springs, t = 1"),
            0.9 * frequency("vibration_bending_2", "springs, t = 1"));
}

TEST(Validate, OrdersAreTwoWhereTheSolutionIsSmooth) {
  const Table rows = solved({"torsion", "hanging"}, {4, 8});
  for (const char* name : {"torsion", "hanging"})
    for (const char* model : {"springs, t = 0.25", "springs, t = 0.5", "springs, t = 1", "elements, linear"})
      EXPECT_NEAR(std::log2(number(rows, "error", name, model, 4) / number(rows, "error", name, model, 8)), 2,
                  0.1)
          << name << ", " << model;
}

// A viscosity is the material's: vibrations of a cube decay alike in cells of any size, as Kelvin and Voigt
// say of the cube within one percent, and of the chain that a lattice makes of it nearly exactly.
TEST(Validate, ViscousVibrationsDecayAlikeInAllCells) {
  const Table rows = solved({"decay_shear", "decay_longitudinal"}, {4, 8});
  const double mu = 1e5 / 2.6, c11 = 3.5 * mu, eta = 100;  // nu = 0.3
  struct Wave {
    const char* name;
    double viscosity, stiffness;
  };
  for (const Wave& wave : {Wave{"decay_shear", eta, mu}, Wave{"decay_longitudinal", 3 * eta, c11}})
    for (const int n : {4, 8}) {
      const auto decrement = [&](double frequency) {
        return reference::logarithmic_decrement(wave.viscosity, wave.stiffness, frequency);
      };
      const double bar = decrement(reference::bar_frequency(wave.stiffness, 1000, 1, 1)),
                   chain = decrement(reference::chain_frequency(wave.stiffness, 1000, 1, n, 1));
      for (const char* model :
           {"springs, t = 0.25", "springs, t = 0.5", "springs, t = 1", "elements, linear"}) {
        const double value = number(rows, "value", wave.name, model, n);
        EXPECT_NEAR(value / bar, 1, 0.01) << wave.name << ", " << model << ", " << n;
        EXPECT_NEAR(value / chain, 1, 5e-5) << wave.name << ", " << model << ", " << n;
      }
    }
}

TEST(Validate, IsExactForUniformStress) {
  const Table rows = solved({"stretch_100", "stretch_110", "stretch_111", "shear"}, {1, 2});
  for (const char* name : {"stretch_100", "stretch_110", "stretch_111", "shear"})
    for (const char* model : {"springs, t = 1", "elements, linear"})
      EXPECT_LT(number(rows, "error", name, model, 2), 1e-10) << name << ", " << model;
  // Body diagonals load a free surface by no uniform traction.
  EXPECT_LT(number(rows, "error", "stretch_100", "springs, t = 0.5", 2), 1e-10);
  EXPECT_GT(number(rows, "error", "shear", "springs, t = 0.5", 2), 1e-3);
}

// Our trilinear elements against those of CalculiX, whose files have seven digits.
TEST(Validate, ElementsAreCalculixs) {
  const Table rows = solved({"cantilever", "cantilever_45", "large_twist", "large_compression"}, {1, 2, 4});
  int compared = 0;
  for (const reference::CalculixRow& row : reference::calculix_rows()) {
    if (row.element != "C3D8") continue;
    const bool small = row.study == "cantilever";
    if (!small && row.poisson != 0.3) continue;
    const std::string name =
        small ? (row.poisson == 0.3 ? "cantilever" : "cantilever_45") : "large_" + row.study;
    const char* model = small ? "elements, linear" : "elements, St. V.-Kirchhoff";
    EXPECT_NEAR(number(rows, "value", name, model, row.cells) / row.value, 1, 1e-6)
        << name << " " << row.cells;
    ++compared;
  }
  EXPECT_EQ(compared, 3 + 3 + 2 + 2);
}

// E grows as the cells per edge where spring constants are kept, and does not where the material is.
TEST(Validate, RefiningTheThesissCubeChangesItsMaterial) {
  ValidationConfig config = validation_config({.cells = {1}});
  std::erase_if(config.cases, [](const ValidationCase& c) { return c.name != "stretch_100"; });
  config.refinement = {1, 2, 5};
  config.repetitions = 1;
  Progress progress;
  const Table table = measure_validation(config, progress).refinement;
  ASSERT_EQ(table.size(), 3U * 4);
  for (std::size_t r = 0; r < table.size(); ++r) {
    if (table.text(r, "sharing") != "weighted") {
      // Springs of the surface have their full stiffness; at five cells both cubes are the same.
      if (table.number(r, "cells") == 5) {
        EXPECT_NEAR(table.number(r, "young"), 1725.76, 0.01);
      }
      continue;
    }
    const double n = table.text(r, "constant") == "k" ? table.number(r, "cells") : 5;
    EXPECT_NEAR(table.number(r, "young"), n / 5 * 1416.67, 0.01);
  }
}

// Beam theory neglects that a clamp prevents lateral contraction: its deflection is 1.6 percent larger.
TEST(Validate, ReferencesAgreeWithEachOther) {
  const reference::SquareBar bar{.young = 1e5, .poisson = 0.3, .width = 1, .length = 4};
  const auto [deflection, uncertainty] = reference::calculix_value("cantilever", 0.3, "deflection");
  EXPECT_NEAR(reference::cantilever_deflection(bar, 1) / deflection, 1.0155, 0.001);
  EXPECT_NEAR(uncertainty, 5.4e-4, 1e-4);
  EXPECT_NEAR(reference::torsion_stiffness(bar), 1e5 / 2.6 * 0.140577 / 4, 1e-2);
}

TEST(Validate, DrawsFromItsFiles) {
  ValidationConfig config = validation_config({.cells = {1, 2}});
  std::erase_if(config.cases, [](const ValidationCase& c) {
    return c.name != "torsion" && c.name != "large_compression" && c.name != "shear";
  });
  config.repetitions = 1;
  config.refinement = {1, 2};
  Progress progress;
  const std::vector<NamedTable> tables = validation_files(config, measure_validation(config, progress));
  expect_same_drawings(find_experiment("validate"), tables);
  const std::vector<NamedChart> charts = draw_validation(tables).charts;
  ASSERT_EQ(charts.size(), 6U);
  const std::vector<std::string> names{
      "validate",           "validate_torsion_cells", "validate_torsion_seconds", "validate_large_strain",
      "validate_estimates", "validate_refinement"};
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(charts[i].name, names[i]);
  // All charted cases at the resolution that they share; shear is not charted.
  EXPECT_EQ(charts[0].chart.y.names, (std::vector<std::string>{"torsion", "large compression"}));
  EXPECT_NE(charts[0].chart.subtitle.find("2 cells across"), std::string::npos);
}

// The cells of a bar of springs between smooth plates all deform alike, while that is stable.
TEST(Validate, SpringsHaveTheStressOfTheirCellsLawAtLargeStrain) {
  ValidationConfig config = validation_config({});
  config.strains = {-0.4, -0.1, 0.4};
  Progress progress;
  Table strains = empty_strains();
  EXPECT_TRUE(measure_large_strain(config, progress, strains));
  ASSERT_EQ(strains.size(), 6U * 3);  // four of nu = 0.3, two of less than 1/4
  for (std::size_t r = 0; r < strains.size(); ++r) {
    const bool gives_way = strains.number(r, "poisson") < 0.25 && strains.number(r, "strain") > 0;
    const bool unstable =
        strains.text(r, "springs") == "springs, t = 0.25" && strains.number(r, "strain") == -0.4;
    EXPECT_EQ(strains.text(r, "status"), gives_way  ? "no state of uniform strain"
                                         : unstable ? "lattice unstable"
                                                    : "ok")
        << strains.text(r, "springs") << strains.number(r, "strain");
    if (gives_way) continue;
    EXPECT_NEAR(strains.number(r, "difference"), 0, 1e-9) << r;
    EXPECT_NEAR(strains.number(r, "lateral_stretch"), strains.number(r, "cauchy_born_lateral_stretch"), 1e-9);
  }
}

TEST(Validate, EstimatesAreComparedWithTheReferences) {
  ValidationConfig config = validation_config({.cells = {4}});
  Progress progress;
  Table estimates = empty_estimates();
  ASSERT_TRUE(measure_estimates(config, progress, estimates));
  EXPECT_EQ(estimates.size(), 8U * 3);  // static, of small deformations; calibrated springs
  EXPECT_NEAR(number(estimates, "effectivity", "cantilever", "springs, t = 1", 4), 0.84, 0.01);
  EXPECT_NEAR(number(estimates, "effectivity", "cantilever", "springs, t = 0.5", 4), 0.88, 0.01);
  EXPECT_NEAR(number(estimates, "effectivity", "torsion", "springs, t = 0.5", 4), 0.67, 0.01);
  for (std::size_t r = 0; r < estimates.size(); ++r) {
    const double value = estimates.number(r, "value") + estimates.number(r, "estimate");
    const double reference = estimates.number(r, "value") / (1 + estimates.number(r, "error"));
    EXPECT_NEAR(value / reference - 1, estimates.number(r, "corrected_error"), 1e-9);
    if (estimates.text(r, "case") == "torsion") {
      EXPECT_EQ(estimates.text(r, "doubts"),
                estimates.text(r, "model") == "springs, t = 0.25" ? "far" : "none");
    }
  }
}

TEST(Validate, KeepsFinishedRowsWhenStopped) {
  struct Stopper final : Progress {
    bool stopped() const override { return ++calls > 7; }
    mutable int calls = 0;
  } progress;
  ValidationConfig config = validation_config({.cells = {1, 2}});
  config.repetitions = 1;
  const ValidationTables tables = measure_validation(config, progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  EXPECT_EQ(tables.rows.size(), 6U);  // one of each model for small deformations
}

}  // namespace
}  // namespace mss::studies::validate
