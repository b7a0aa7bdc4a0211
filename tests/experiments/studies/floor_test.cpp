// `mss validate contact`, a body on the floor: the study sees what is right and what is not, and every pair
// of method and scene is a row.
#include "experiments/studies/contact/floor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

#include "core/body/body.hpp"
#include "experiments/studies/contact/contact.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::contact {
namespace {

const FloorScene& scene_of(FloorTask task) {
  for (const FloorScene& scene : floor_scenes())
    if (scene.task == task) return scene;
  throw std::logic_error("no such scene");
}

const FloorStep& frames() { return floor_steps().front(); }
const FloorStep& safe() { return floor_steps().back(); }

Table row_of(FloorTask task, const std::string& method, double young, const FloorStep& step,
             const std::string& shape = "cube") {
  Table rows = empty_floor();
  add_floor_run({shape, scene_of(task), method, young, step}, rows);
  EXPECT_EQ(rows.size(), 1U);
  return rows;
}

std::string status_of(FloorTask task, const std::string& method, double young, const FloorStep& step) {
  return row_of(task, method, young, step).text(0, "status");
}

TEST(Floor, HoldsABlockAtRestByMethodsThatDo) {
  for (const char* method : {"backward_euler", "vbd:20"}) {
    const Table row = row_of(FloorTask::rest, method, 1e6, frames());
    EXPECT_EQ(row.text(0, "status"), "ok") << row.csv();
    EXPECT_LT(row.number(0, "error"), 1e-3);
    EXPECT_LE(row.number(0, "penetration"), 1e-12);
  }
  EXPECT_EQ(status_of(FloorTask::rest, "verlet", 1e6, safe()), "ok");
}

TEST(Floor, SeesThatOnePassIsTooFew) {
  const Table row = row_of(FloorTask::rest, "xpbd:1", 1e6, frames());
  EXPECT_EQ(row.text(0, "status"), "gains_energy");
  EXPECT_GT(row.number(0, "energy"), 1.05);
  EXPECT_EQ(status_of(FloorTask::loaded, "xpbd:20", 1e5, frames()), "off");
  EXPECT_GT(row_of(FloorTask::loaded, "xpbd:20", 1e5, frames()).number(0, "error"), 0.05);
}

TEST(Floor, MeasuresSlopesFallsAndGrooves) {
  const Table slide = row_of(FloorTask::slide, "backward_euler", 1e6, frames());
  EXPECT_EQ(slide.text(0, "status"), "ok") << slide.csv();
  const Table stick = row_of(FloorTask::stick, "vbd:1", 1e6, frames());
  EXPECT_NE(stick.text(0, "status"), "ok") << stick.csv();
  EXPECT_GT(stick.number(0, "error"), stick.number(0, "bound"));
  const Table drop = row_of(FloorTask::drop, "xpbd:20", 1e7, frames());
  EXPECT_EQ(drop.text(0, "status"), "gains_energy") << drop.csv();
  EXPECT_NEAR(drop.number(0, "error"), drop.number(0, "energy") - 1, 1e-12);
  EXPECT_EQ(status_of(FloorTask::groove, "backward_euler", 1e6, frames()), "ok");
  EXPECT_EQ(status_of(FloorTask::drop, "shape_matching", 1e6, frames()), "refused");
}

TEST(Floor, AMethodWithoutAStepIsARow) {
  const Table row = row_of(FloorTask::rest, "explicit_euler", 1e6, safe());
  EXPECT_EQ(row.text(0, "status"), "refused");
  EXPECT_NE(row.text(0, "reason").find("explicit_euler"), std::string::npos) << row.csv();
  EXPECT_TRUE(std::isnan(row.number(0, "error")));
}

TEST(Floor, CostsAreThoseOfTheSameStepWithoutContact) {
  const Table row = row_of(FloorTask::rest, "vbd:20", 1e5, frames());
  EXPECT_EQ(row.number(0, "evaluations"), 20);
  EXPECT_EQ(row.number(0, "free_evaluations"), 20);
  EXPECT_GT(row.number(0, "cost"), 0);
  const Table newton = row_of(FloorTask::stick, "backward_euler", 1e6, frames());
  EXPECT_GE(newton.number(0, "solves"), 1);
  EXPECT_LT(newton.number(0, "solves"), 1.5 * newton.number(0, "free_solves"));
}

TEST(Floor, BodiesStandInTheCorner) {
  for (const std::string& shape : floor_shapes()) {
    const Body body(floor_body(shape, 1e6));
    EXPECT_GT(body.cell_count(), 40U) << shape;
    Vec3 lowest = Vec3::Ones();
    for (const std::ptrdiff_t site : body.sites()) lowest = lowest.cwiseMin(body.rest_position(site));
    EXPECT_EQ(lowest, Vec3(Vec3::Zero())) << shape;
  }
  EXPECT_EQ(Body(floor_body("ragged", 1e6)).cell_count(), 64U - 13);
  EXPECT_FALSE(Body(floor_body("torus", 1e6)).config().is_full());
}

TEST(Floor, EveryRunIsARowAndIsDrawn) {
  ContactConfig config;
  config.laws.clear();
  config.floor = floor_config({.quick = true, .integrators = {"verlet", "vbd:1", "shape_matching"}});
  config.floor.youngs = {1e6};
  Journal journal;
  Progress progress;
  const ContactTables tables = measure_contact(config, 2, journal, progress);
  EXPECT_EQ(tables.floor.size(), 6U + 6 + 4);  // four scenes by shape matching
  EXPECT_EQ(tables.floor.size(), floor_runs(config.floor).size());
  const std::vector<NamedTable> files = contact_files(tables);
  expect_same_drawings(find_experiment("contact"), files);
  const Drawings drawings = draw_contact(files);
  ASSERT_EQ(drawings.maps.size(), 1U);
  const MapChart& map = drawings.maps[0].chart;
  EXPECT_EQ(map.panels.size(), floor_scenes().size());
  std::size_t cells = 0;
  for (const MapPanel& panel : map.panels) cells += panel.cells.size();
  EXPECT_EQ(cells, 6U + 6 + 4);
}

TEST(Floor, AllShapesAndStepsAreRunOfAllMethods) {
  const std::set<std::string> only_if_named{"explicit_euler", "energy_momentum", "pefrl", "srkn6", "srkn8"};
  for (const IntegratorInfo& method : integrators()) {
    if (method.stepping != Stepping::fixed) continue;
    ExperimentOptions options;
    if (only_if_named.contains(method.name)) options.integrators = {method.name};
    const std::vector<FloorRun> runs = floor_runs(floor_config(options));
    std::set<std::string> shapes, steps, scenes;
    for (const FloorRun& run : runs)
      if (find_integrator(run.integrator).name.starts_with(method.name)) {
        shapes.insert(run.shape);
        steps.insert(run.step.name);
        scenes.insert(run.scene.name);
      }
    EXPECT_EQ(shapes.size(), 3U) << method.name;
    EXPECT_EQ(steps.size(), method.limit ? 1U : 2U) << method.name;
    EXPECT_EQ(scenes.size(), method.has_modulus ? 6U : 4U) << method.name;
  }
  for (const FloorRun& run : floor_runs(floor_config({})))
    EXPECT_FALSE(only_if_named.contains(run.integrator)) << run.integrator;
}

}  // namespace
}  // namespace mss::studies::contact
