// `mss validate beam`: measured tables are read, scenes are those of the measurement, and what goes wrong is
// said.
#include "experiments/studies/beam/beam.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/base/error.hpp"
#include "experiments/fit/observations.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "integrators/analysis/modes.hpp"
#include "reference/beam/beam.hpp"
#include "tests/experiments/stop_after.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::beam {
namespace {

BeamConfig small_beam(std::vector<std::string> settings = {}) {
  BeamConfig config = beam_config({.quick = true});
  config.cells = config.ringing_cells = {3};
  config.ringing.resize(1);
  config.fit_cells = 0;
  config.settings = std::move(settings);
  return config;
}

TEST(Beam, MeasuredRunsAreRead) {
  EXPECT_EQ(reference::beam_value(reference::measured_beam(), "52 g b", "drop_2_mm"), 16.311);
  EXPECT_EQ(reference::beam_value(reference::comsol_beam(), "none", "drop_1_mm"), 6.75);
  EXPECT_TRUE(std::isnan(reference::beam_value(reference::comsol_beam(), "none", "drop_0_mm")));
  EXPECT_TRUE(reference::beam_turns("7 g a").empty());
  ASSERT_EQ(reference::beam_markers().size(), 3U);
  for (const BeamLoad& load : beam_loads())
    for (const char* run : {" a", " b"}) {
      const auto turns = reference::beam_turns(load.name + run);
      ASSERT_EQ(turns.size(), 12U);
      for (std::size_t n = 0; n < turns.size(); ++n) {
        EXPECT_EQ(turns[n].height > 0, n % 2 == 1) << load.name << run << n;
        if (n > 0) {
          EXPECT_GT(turns[n].time, turns[n - 1].time);
        }
        if (n > 1) {
          EXPECT_LT(std::abs(turns[n].height), std::abs(turns[n - 2].height));
        }
      }
    }
}

/// What `mss fit` reads of two of them is what was measured.
TEST(Beam, RunsToFitAreWhatWasMeasured) {
  const fit::Observations data =
      fit::read_observations_text(reference::beam_runs_to_fit_text(), fit::source_of("any"), {});
  ASSERT_EQ(data.observations.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const fit::Observation& o = data.observations[i];
    const std::string run = i < 3 ? "none a" : "102 g a";
    const RingDown ring = measured_ring_down(run);
    const double measured[]{-1e-3 * reference::beam_value(reference::measured_beam(), run, "drop_1_mm"),
                            ring.frequency, ring.swing_damping_ratio};
    EXPECT_NEAR(o.measured.at(0) / measured[i % 3], 1, 1e-4) << o.name;
    EXPECT_EQ(*o.point, reference::beam_markers()[1].point);
  }
}

// As coarse as that nothing is learnt of silicone, but from start to end.
TEST(Beam, FitsAMaterialAndPredictsWithIt) {
  BeamConfig config = small_beam();
  config.fit_cells = 3;
  Progress progress;
  const BeamTables tables = measure_beam(config, progress);
  EXPECT_EQ(tables.fits.size(), 6U);
  for (const std::string& status : tables.fits.distinct("status"))
    EXPECT_TRUE(status == "ok" || status == "hardly determined by the data") << status;
  const std::vector<std::string> materials{"as published", "fitted, one Maxwell branch",
                                           "fitted, Kelvin-Voigt"};
  EXPECT_EQ(tables.drops.distinct("material"), materials);
  ASSERT_EQ(tables.ring_down.distinct("material"), materials);
  const auto off = [&](const std::string& material) {
    const Table row = tables.ring_down.where("material", material);
    EXPECT_EQ(row.text(0, "status"), "ok");
    return std::abs(row.number(0, "swing_damping_ratio") - row.number(0, "swing_damping_ratio_a"));
  };
  EXPECT_LT(off(materials[1]), 0.006);
  EXPECT_GT(off(materials[2]), 2 * off(materials[1]));
}

TEST(Beam, MeasuredFrequenciesAndDampingAreTheRuns) {
  const auto near = [](const std::string& run, double frequency, double ratio) {
    const RingDown found = measured_ring_down(run);
    EXPECT_EQ(found.status, "ok") << run;
    EXPECT_NEAR(found.frequency / frequency, 1, 4e-3) << run;
    EXPECT_NEAR(found.peak_damping_ratio, ratio, 1e-3) << run;
  };
  near("none a", 7.72, 0.0509);
  near("none b", 7.75, 0.0532);
  near("52 g a", 4.33, 0.0560);
  near("52 g b", 4.31, 0.0511);
  near("102 g a", 3.36, 0.0646);
  near("102 g b", 3.36, 0.0681);
}

TEST(Beam, ScenesWeighWhatWasHungOn) {
  const double grams[] = {0, 52.016, 102.030};
  for (std::size_t i = 0; i < 3; ++i) {
    const Scene scene = beam_scene(small_beam(), {}, beam_loads()[i], 6);
    const Body body(scene.body);
    double mass = 0;
    for (const std::ptrdiff_t site : body.sites()) mass += body.mass(site);
    EXPECT_NEAR(mass, 1070 * 0.1 * 0.03 * 0.03 + 1e-3 * grams[i], 1e-12);
    EXPECT_EQ(scene.environment.gravity[2], -9.80709);
    if (i > 0) {
      EXPECT_NEAR(1e-3 * grams[i] * 9.80709, i == 1 ? 0.51012 : 1.00062, 2e-5);
    }
  }
}

TEST(Beam, SinksAsCommercialElementsDo) {
  for (const BeamLoad& load : beam_loads()) {
    const double comsol = 1e-3 * reference::beam_value(reference::comsol_beam(), load.name, "drop_1_mm");
    double off[2];
    for (const int n : {3, 6}) {
      const BeamRest rest = beam_at_rest(beam_scene(small_beam(), {}, load, n));
      ASSERT_EQ(rest.status, Status::ok) << load.name;
      ASSERT_EQ(rest.drops.size(), 3U);
      EXPECT_GT(rest.drops[0], rest.drops[1]);  // the end leans forward: its top sinks more
      EXPECT_GT(rest.drops[1], rest.drops[2]);
      off[n / 3 - 1] = std::abs(rest.drops[1] / comsol - 1);
    }
    EXPECT_LT(off[1], 0.05) << load.name;
    EXPECT_LT(off[1], off[0] / 2) << load.name;
  }
}

// About rest, of the slowest mode: the swing is larger, and its frequency hardly another.
TEST(Beam, RingsAtTheFrequencyOfItsSlowestMode) {
  const BeamConfig config = small_beam();
  Progress progress;
  const BeamTables tables = measure_beam(config, progress);
  ASSERT_EQ(tables.ring_down.size(), 1U);
  ASSERT_EQ(tables.ring_down.text(0, "status"), "ok");
  const Scene scene = beam_scene(config, {}, beam_loads()[0], 3);
  const Body body(scene.body);
  SceneRun<double> run(scene, body);
  Work work;
  const Modes modes = slowest_modes(run.system(), run.state(), 2, work);
  ASSERT_EQ(modes.status, Status::ok);
  const double frequency = modes.modes[0].omega / (2 * std::numbers::pi);
  EXPECT_NEAR(tables.ring_down.number(0, "frequency") / frequency, 1, 0.02);
  // Kelvin-Voigt, in shear: zeta = eta omega / (2 mu); bending of a solid that keeps its volume damps the
  // same.
  const double mu = scene.body.shear_modulus();
  EXPECT_NEAR(tables.ring_down.number(0, "swing_damping_ratio"),
              scene.body.damping.viscosity * modes.modes[0].omega / (2 * mu), 2e-3);
}

TEST(Beam, SettingsAreTheScenes) {
  const BeamRest soft = beam_at_rest(beam_scene(small_beam(), {}, beam_loads()[0], 3)),
                 stiff = beam_at_rest(
                     beam_scene(small_beam(), {"twice", {"material.young=527648"}}, beam_loads()[0], 3));
  EXPECT_NEAR(soft.drops[1] / stiff.drops[1], 2, 0.05);
  EXPECT_THROW(beam_scene(small_beam({"material.yong=1"}), {}, beam_loads()[0], 3), InputError);
  EXPECT_THROW(beam_config({.cells = {3, 4}}), InputError);
}

TEST(Beam, TakesStepsLongerThanItsSamples) {
  Progress progress;
  const BeamTables tables =
      measure_beam(small_beam({"solve.integrator=tr_bdf2/lbfgs:5", "solve.dt=0.0025"}), progress);
  ASSERT_EQ(tables.ring_down.size(), 1U);
  EXPECT_EQ(tables.ring_down.text(0, "status"), "ok");
  EXPECT_NEAR(tables.ring_down.number(0, "frequency"), 7.9, 0.1);
}

TEST(Beam, FailuresAreRows) {
  Progress progress;
  BeamConfig config = small_beam({"solve.dt=0.002"});
  config.cells.clear();
  const BeamTables exploded = measure_beam(config, progress);
  EXPECT_EQ(exploded.ring_down.text(0, "status"), "non_finite");
  EXPECT_TRUE(std::isnan(exploded.ring_down.number(0, "frequency")));
  EXPECT_EQ(exploded.turns.text(11, "status"), "non_finite");
  EXPECT_EQ(exploded.motion.size(), 0U);
  config.settings = {"solve.duration=0.3"};
  const BeamTables brief = measure_beam(config, progress);
  EXPECT_EQ(brief.ring_down.text(0, "status"), "it turns less often than was measured");
  EXPECT_EQ(brief.turns.text(0, "status"), "ok");
  EXPECT_EQ(brief.turns.text(11, "status"), "it turns less often than was measured");
  config.settings = {"environment.gravity=[0, 0, 0]"};
  EXPECT_EQ(measure_beam(config, progress).ring_down.text(0, "status"), "it does not move");
}

TEST(Beam, KeepsWhatIsFinishedWhenStopped) {
  StopAfter progress(2);
  const BeamTables tables = measure_beam(small_beam(), progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  EXPECT_EQ(tables.drops.size() % 3, 0U);
  EXPECT_EQ(tables.ring_down.size(), 0U);
}

TEST(Beam, DrawsFromItsFiles) {
  Progress progress;
  const std::vector<NamedTable> tables = beam_files(measure_beam(small_beam(), progress));
  expect_same_drawings(find_experiment("beam"), tables);
  const Drawings drawings = draw_beam(tables);
  ASSERT_EQ(drawings.charts.size(), 4U);
  EXPECT_EQ(drawings.charts[0].name, "beam");
  EXPECT_EQ(drawings.charts[3].name, "beam_motion_none");
  for (const NamedChart& chart : drawings.charts) EXPECT_TRUE(has_points(chart.chart)) << chart.name;
}

}  // namespace
}  // namespace mss::studies::beam
