// `mss refine`: corrected values are better than raw ones where they claim to be.
#include "experiments/studies/refine/refine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "experiments/studies/refine/answers.hpp"
#include "experiments/studies/refine/maps.hpp"
#include "reference/calculix/calculix.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::refine {
namespace {

const EstimateTables& tables() {
  static const EstimateTables computed = [] {
    RefineConfig config = refine_config({});
    config.cells = {2, 4, 8};
    Progress progress;
    return measure_estimates(config, progress);
  }();
  return computed;
}

TEST(Refine, TheBeamsLimitIsThatOfFiniteElements) {
  const Table beam = tables().reference.where("problem", "beam");
  EXPECT_NEAR(beam.number(0, "reference") / reference::calculix_value("cantilever", 0.3, "deflection").value,
              1, 3e-4);
  EXPECT_LT(beam.number(0, "uncertainty"), 1e-4);
}

/// Corrected over raw error, signs included.
std::vector<double> ratios(const std::string& problem, double face_share) {
  const Table rows = tables().rows.where("problem", problem).where("face_share", face_share);
  std::vector<double> all;
  for (std::size_t r = 0; r < rows.size(); ++r)
    all.push_back(rows.number(r, "corrected_error") / rows.number(r, "raw_error"));
  EXPECT_EQ(all.size(), 3);
  return all;
}

TEST(Refine, CorrectedABeamErrsAFifthAndABracketHalfAsMuch) {
  for (const double face_share : {0.5, 1.0}) {
    for (const double ratio : ratios("beam", face_share)) EXPECT_LT(std::abs(ratio), 0.2) << face_share;
    for (const double ratio : ratios("bracket", face_share)) EXPECT_LT(std::abs(ratio), 0.5) << face_share;
  }
  EXPECT_NEAR(ratios("beam", 0.5)[1], 0.110, 0.005);
  EXPECT_NEAR(ratios("bracket", 0.5)[1], 0.228, 0.005);
}

TEST(Refine, DoubtsTheFarGoalOnlyWhereItIsNoBetter) {
  const Table& rows = tables().rows;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const bool far = rows.text(r, "doubts").find("far") != std::string::npos;
    EXPECT_EQ(far, rows.text(r, "problem") == "far goal") << r;
    EXPECT_NEAR(rows.number(r, "effectivity"), far ? 0 : 0.75, far ? 0.4 : 0.15) << r;
  }
}

/// Of a load on a patch.
const MapTables& maps() {
  static const MapTables computed = [] {
    MapConfig config = map_config({});
    config.problems = {map_problems().front()};
    config.uniform_cells = {2, 4, 8, 12, 16, 20, 24};
    config.reference_coarsening = 2;
    config.most_particles = 5000;
    config.sample_seconds = 1e-4;
    Progress progress;
    return measure_maps(config, progress);
  }();
  return computed;
}

TEST(Refine, SmallerCellsUnderALoadSaveParticlesAndLayersAtTheSurfaceDoNot) {
  const auto gain = [](const char* map, double error) {
    const Table rows = maps().gains.where("map", map).where("error", error).where("quantity", "particles");
    EXPECT_EQ(rows.size(), 1);
    return rows.number(0, "gain");
  };
  EXPECT_GT(gain("by hand", 0.1), 3);
  EXPECT_GT(gain("by hand", 0.05), 4.5);
  EXPECT_GT(gain("estimated", 0.05), 3);
  EXPECT_LT(gain("surface layers", 0.1), 1);
}

TEST(Refine, TractionIsWholeAndInTheMiddleOfItsBox) {
  const BodyConfig config{.voxels = VoxelGrid::box(3, 3, 3), .cell_size = 1.0 / 3};
  RefinementMap map;
  map.split(1, {2, 2, 5});
  const RefinedBody body(config, map);
  const Box patch{{0.2, 0.3, 1}, {0.7, 0.5, 1}};
  Field<double> force = traction(body.levels(), patch, Vec3(0, 0, -1));
  body.scatter_to_masters(force);
  double sum = 0;
  Vec3 middle = Vec3::Zero();
  for (const auto& [of, first] : body.levels())
    for (const std::ptrdiff_t site : of.sites()) {
      sum -= force.at(first + site)[2];
      middle -= force.at(first + site)[2] * of.rest_position(site);
    }
  EXPECT_NEAR(sum, 1, 1e-14);
  EXPECT_LT((middle - Vec3(0.45, 0.4, 1)).norm(), 1e-14);
}

TEST(Refine, GainsAreTakenWhereErrorsStayBelow) {
  Table rows({{"problem"},
              {"map"},
              {"error"},
              {"particles"},
              {"answer_seconds"},
              {"period_seconds"},
              {"local_period_seconds"}});
  const auto add = [&](Map map, double error, double cost) {
    rows.add({std::string("a"), to_string(map), error, cost, cost, cost, cost});
  };
  for (const double error : {0.4, 0.2, 0.05, 0.02}) add(Map::uniform, error, 16 / error);
  add(Map::estimated, 0.4, 10);
  add(Map::estimated, 0.001, 11);  // by chance
  add(Map::estimated, 0.2, 20);
  add(Map::estimated, 0.05, 80);
  const Table gains = gains_of(rows).where("map", to_string(Map::estimated)).where("quantity", "particles");
  EXPECT_NEAR(gains.number(0, "gain"), 4, 1e-12);
  EXPECT_EQ(gains.text(0, "status"), "ok");
  EXPECT_EQ(gains.text(2, "status"), "error not passed");  // 2 percent
}

// Betti: what is looked at moves under the load as the patch does under a force on what is looked at.
TEST(Refine, AFarGoalIsSeenThroughItsDualSolution) {
  const std::vector<MapProblem> problems = map_problems();
  const auto far = std::find_if(problems.begin(), problems.end(),
                                [](const MapProblem& problem) { return problem.looked_at.has_value(); });
  ASSERT_NE(far, problems.end());
  const BodyConfig config = in_cells(far->shape, 2, {.young = 1e5, .poisson = 0.3}, 0.5);
  Solid solid(config, split_near(config, far->distance, 1), far->shape.environment);
  ASSERT_EQ(solid.body.levels().size(), 2U);
  const Answer found = answer(solid, *far);
  ASSERT_EQ(found.status, Status::ok);
  Field<double> load = traction(solid.body.levels(), far->patch, far->direction);
  solid.body.scatter_to_masters(load);
  double by_dual = 0;
  for (const std::ptrdiff_t site : solid.system->particles())
    by_dual += load.at(site).dot(found.dual->at(site));
  EXPECT_NEAR(by_dual / found.value, 1, 1e-6);
}

TEST(Refine, DrawsFromTables) {
  const std::vector<NamedTable> files{
      {"refine", tables().rows}, {"refine_reference", tables().reference}, {"refine_maps", maps().rows}};
  const Drawings drawings = find_experiment("refine").draw(files);
  expect_same_drawings(find_experiment("refine"), files);
  ASSERT_EQ(drawings.charts.size(), 3 + 3);
  EXPECT_EQ(drawings.charts[0].name, "refine");
  EXPECT_EQ(drawings.charts[2].name, "refine_far_goal");
  for (std::size_t c = 0; c < 3; ++c) {
    ASSERT_EQ(drawings.charts[c].chart.series.size(), 6);
    for (const ChartSeries& series : drawings.charts[c].chart.series) EXPECT_EQ(series.points.size(), 3);
  }
  EXPECT_EQ(drawings.charts[3].name, "refine_maps_patch_of_a_quarter_particles");
  EXPECT_EQ(drawings.charts[3].chart.series.size(), 5);
}

}  // namespace
}  // namespace mss::studies::refine
