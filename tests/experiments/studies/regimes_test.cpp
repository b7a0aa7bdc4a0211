// `mss regimes`: who is cheapest, ties, predicted boundaries, finer grids where the kind changes.
#include "experiments/studies/regimes/regimes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "integrators/integrator.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::regimes {
namespace {

/// A run of a motion that stays within bounds.
struct Planted {
  std::string method;
  double seconds, error;
  bool untuned = false;
  std::string bounds = within_bounds;
};

/// Motions at one point.
Table planted(const std::vector<Planted>& runs, double young = 1e6, double uncertainty = 0) {
  Table table({{"scene"},
               {"cells"},
               {"damping_ratio"},
               {"young"},
               {"what"},
               {"method"},
               {"setting"},
               {"untuned"},
               {"steps_or_tolerance"},
               {"seconds"},
               {"q1"},
               {"q3"},
               {"error"},
               {"bounds"},
               {"uncertainty"},
               {"status"}});
  for (const Planted& run : runs)
    table.add({std::string("held_box"), 4, 0.05, young, std::string("motion"), run.method, std::string(),
               run.untuned ? 1 : 0, 1.0, run.seconds, 0.99 * run.seconds, 1.01 * run.seconds, run.error,
               run.bounds, uncertainty, std::string("ok")});
  return table;
}

/// Points to which runs belong.
Table planted_points() {
  return Table({{"scene"},
                {"cells"},
                {"damping_ratio"},
                {"young"},
                {"explicit_step_seconds"},
                {"safe_dt"},
                {"frames"},
                {"status"}});
}
std::vector<Cell> point_row(double young, double step_seconds, double safe_dt) {
  return {std::string("held_box"), 4, 0.05, young, step_seconds, safe_dt, 1, std::string("ok")};
}

Table at(const Table& cheapest, const char* demand) { return cheapest.where("demand", demand); }

TEST(Regimes, TheCheapestMeetsTheDemandAndTheNextIsOfAnotherKind) {
  const Table cheapest = cheapest_methods(planted({{"verlet", 3, 1e-4},
                                                   {"damped_verlet", 3.05, 1e-4},
                                                   {"backward_euler/lbfgs:5", 1, 0.05},
                                                   {"xpbd", 0.95, 0.3}}));
  EXPECT_EQ(at(cheapest, "stable").text(0, "method"), "xpbd");
  EXPECT_EQ(at(cheapest, "stable").number(0, "tie"), 1);  // with quasi-Newton steps
  EXPECT_EQ(at(cheapest, "motion_10").text(0, "method"), "backward_euler/lbfgs:5");
  EXPECT_EQ(at(cheapest, "motion_10").number(0, "tie"), 0);
  EXPECT_DOUBLE_EQ(at(cheapest, "motion_10").number(0, "factor"), 3);
  EXPECT_EQ(at(cheapest, "motion_1").text(0, "method"), "verlet");
  EXPECT_EQ(at(cheapest, "motion_1").text(0, "status"), "no other kind met it in time");
  EXPECT_EQ(at(cheapest, "rest_1").text(0, "status"), "no reference");
  EXPECT_DOUBLE_EQ(at(cheapest, "stable").number(0, "error"), 0.3);
  EXPECT_DOUBLE_EQ(at(cheapest, "motion_10").number(0, "q3"), 1.01);
  EXPECT_DOUBLE_EQ(at(cheapest, "motion_10").number(0, "runner_up_q1"), 0.99 * 3);
  const Table nothing = cheapest_methods(planted({{"xpbd", 1, 0.3}}));
  EXPECT_EQ(at(nothing, "motion_10").text(0, "status"), "nothing that was tried met it");
}

/// An error of any size is stable, and what leaves its bounds is not, however small its error.
TEST(Regimes, StableIsNotAnError) {
  const Table cheapest = cheapest_methods(
      planted({{"verlet", 3, 2.5}, {"xpbd", 1, 0.05, false, "energy"}, {"vbd:5", 2, 0.04, false, "folded"}}));
  EXPECT_EQ(at(cheapest, "stable").text(0, "method"), "verlet");
  EXPECT_DOUBLE_EQ(at(cheapest, "stable").number(0, "error"), 2.5);
  EXPECT_EQ(at(cheapest, "motion_10").text(0, "status"), "nothing that was tried met it");
}

/// What the reference does not know cannot be asked for.
TEST(Regimes, DemandsEndWhereTheReferenceIsUncertain) {
  const Table cheapest =
      cheapest_methods(planted({{"verlet", 3, 1e-5}, {"xpbd", 1, 0.05}}, 1e6, 1.01 * 0.01 / certainty));
  EXPECT_EQ(at(cheapest, "motion_10").text(0, "method"), "xpbd");
  EXPECT_EQ(at(cheapest, "motion_1").text(0, "status"), "the reference is not that certain");
  EXPECT_EQ(at(cheapest, "stable").text(0, "method"), "xpbd");
}

/// Every family has a row, with what its settings of before would have cost.
TEST(Regimes, TuningIsShownBesideWhatWasBefore) {
  const Table families = tuned_families(planted({{"verlet", 3, 1e-4},
                                                 {"vbd:20", 2, 0.05, true},
                                                 {"vbd:5", 0.5, 0.06},
                                                 {"xpbd:2", 0.7, 0.05},
                                                 {"xpbd:1", 0.6, 0.5, true}}));
  const Table ten = families.where("demand", "motion_10"), vbd = ten.where("family", "vbd"),
              xpbd = ten.where("family", "xpbd");
  EXPECT_EQ(ten.size(), 2U);  // explicit methods are not tuned
  EXPECT_EQ(vbd.text(0, "tuned"), "vbd:5, 1 a frame");
  EXPECT_EQ(vbd.text(0, "untuned"), "vbd:20, 1 a frame");
  EXPECT_DOUBLE_EQ(vbd.number(0, "gain"), 4);
  EXPECT_EQ(xpbd.text(0, "status"), "met by what is tuned alone");
  EXPECT_EQ(families.where("demand", "motion_1").where("family", "xpbd").text(0, "status"),
            "not met in time");
  const Table stable = families.where("demand", "stable").where("family", "xpbd");
  EXPECT_DOUBLE_EQ(stable.number(0, "gain"), 1);
}

/// One rule for all: every family that iterates has the same numbers of iterations, every linear solver with
/// a tolerance the same tolerances, and what each was given before is among what is tried.
TEST(Regimes, FamiliesAreTunedAlike) {
  std::vector<std::string> tuned_from;
  for (const RegimeFamily& family : regime_families()) {
    std::vector<int> iterations;
    std::vector<double> tolerances;
    for (const Effort& effort : family.efforts) {
      if (effort.iterations > 0) iterations.push_back(effort.iterations);
      if (effort.tolerance > 0) tolerances.push_back(effort.tolerance);
    }
    const bool iterates =
        find_integrator(family.method).iterates || family.method.find('/') != std::string::npos;
    EXPECT_EQ(iterations.size(), iterates ? tried_iterations.size() : 0U) << family.method;
    EXPECT_TRUE(std::equal(iterations.begin(), iterations.end(), tried_iterations.begin()));
    if (tolerances.size() > 1) {
      EXPECT_TRUE(std::equal(tolerances.begin(), tolerances.end(), tried_tolerances.begin()));
    }
    if (family.untuned < 0) continue;
    EXPECT_LT(std::size_t(family.untuned), family.efforts.size());
    tuned_from.push_back(family.method);
  }
  EXPECT_EQ(tuned_from,
            (std::vector<std::string>{"backward_euler_linear", "backward_euler/lbfgs", "tr_bdf2/lbfgs",
                                      "generalized_alpha/lbfgs", "xpbd", "vbd"}));
}

TEST(Regimes, KindsAreThoseOfTheFacts) {
  EXPECT_EQ(kind_of("verlet"), Kind::explicit_steps);
  EXPECT_EQ(kind_of("dynamic_relaxation"), Kind::explicit_steps);
  EXPECT_EQ(kind_of("backward_euler_linear"), Kind::linear_systems);
  EXPECT_EQ(kind_of("static"), Kind::linear_systems);
  EXPECT_EQ(kind_of("static/lbfgs"), Kind::quasi_newton);
  EXPECT_EQ(kind_of("tr_bdf2/lbfgs:4"), Kind::second_order);
  EXPECT_EQ(kind_of("xpbd:10"), Kind::projections);
  EXPECT_EQ(kind_of("vbd:5"), Kind::descents);
  EXPECT_EQ(kind_labels().size(), std::size_t(Kind::none) + 1);
}

/// A frame of steps of 1 ms that take 1 ms costs 1/60 s at E = 1e6, and at 4e6, where steps are half as long,
/// 2/60 s: what the other method's frame costs.
TEST(Regimes, TheBoundaryIsWhereFramesCostTheSame) {
  Table points = planted_points();
  points.add(point_row(1e6, 1e-3, 1e-3));
  points.add(point_row(4e6, 1e-3, 5e-4));
  const Table soft = planted({{"verlet", 1, 1e-4}, {"xpbd", 2 * frame, 0.3}}),
              stiff = planted({{"verlet", 4, 1e-4}, {"xpbd", 2 * frame, 0.3}}, 4e6);
  Table runs = soft;
  for (const auto& row : stiff.rows()) runs.add(row);
  const Table found = boundaries(points, runs, cheapest_methods(runs));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found.number(0, "predicted"), 4e6, 1);  // twice the steps
  EXPECT_NE(found.text(0, "status"), "ok");           // xpbd is the cheapest at both
}

TEST(Regimes, TheMeasuredBoundaryIsTheFirstChange) {
  Table points = planted_points();
  Table runs = planted({}, 1e6);
  const auto add = [&](double young, double explicit_seconds) {
    points.add(point_row(young, explicit_seconds * 1e-3 / frame, 1e-3));
    const Table more = planted({{"verlet", explicit_seconds, 1e-4}, {"xpbd", 2.0, 0.3}}, young);
    for (const auto& row : more.rows()) runs.add(row);
  };
  add(1e6, 1);
  add(1e7, 4);
  add(1e8, 1.9);  // noise
  add(1e9, 40);
  const Table found = boundaries(points, runs, cheapest_methods(runs));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.text(0, "status"), "ok");
  EXPECT_NEAR(found.number(0, "measured"), std::sqrt(1e13), 1);
  EXPECT_NEAR(found.number(0, "predicted"), std::sqrt(1e13), 1);  // halfway between a half and twice the cost
}

/// Of a point where only one method was tried.
Json only(const char* method) {
  return {{"explicit_step", 1e-6},
          {"explicit_dt", 1e-3},
          {"frames", 10},
          {"uncertainty", 1e-6},
          {"motion_status", "ok"},
          {"rest_status", "none was sought"},
          {"motion", Json::array({{{"method", method},
                                   {"setting", ""},
                                   {"untuned", 0},
                                   {"steps", 1},
                                   {"seconds", 1.0},
                                   {"q1", 1.0},
                                   {"q3", 1.0},
                                   {"error", 0.5},
                                   {"energy", 0.9},
                                   {"displacement", 1.0},
                                   {"bounds", within_bounds},
                                   {"status", "ok"}}})},
          {"rest", Json::array()}};
}

/// How many points a row between 1e4 and 1e10 Pa has if these methods are the cheapest at its ends.
std::size_t points_between(const char* soft, const char* stiff) {
  const RegimesConfig config{.grids = {{"held_box", 2, {0.5}, {1e4, 1e10}, 1}}};
  Journal journal;
  journal.add(RegimePoint{"held_box", 2, 0.5, 1e4}.name(), only(soft));
  journal.add(RegimePoint{"held_box", 2, 0.5, 1e7}.name(), only(stiff));
  journal.add(RegimePoint{"held_box", 2, 0.5, 1e10}.name(), only(stiff));
  Progress progress;
  return measure_regimes(config, 1, journal, progress).points.size();
}

TEST(Regimes, TheGridIsFinerWhereTheKindChanges) {
  EXPECT_EQ(points_between("verlet", "xpbd"), 3U);
  EXPECT_EQ(points_between("verlet", "damped_verlet"), 2U);
}

/// Explicit frames cost as the square root of the modulus, others a constant; measured to a tenth, on a grid
/// of quarter decades.
TEST(Regimes, PredictedAndMeasuredBoundariesAgreeWithinTheGrid) {
  constexpr double step_seconds = 1e-6, other_frame = 1.3e-4;
  for (const double noise : {0.9, 1.0, 1.1}) {
    Table points = planted_points();
    Table runs = planted({}, 1e6);
    for (int i = 0; i <= 20; ++i) {
      const double young = 1e4 * std::pow(10, i / 4.0), steps = 5 * std::sqrt(young / 1e4);
      points.add(point_row(young, step_seconds, frame / steps));
      const Table more =
          planted({{"verlet", noise * steps * step_seconds, 1e-4}, {"xpbd", other_frame, 0.3}}, young);
      for (const auto& row : more.rows()) runs.add(row);
    }
    const Table found = boundaries(points, runs, cheapest_methods(runs));
    ASSERT_EQ(found.size(), 1U);
    const double exact = 1e4 * std::pow(other_frame / step_seconds / 5, 2);
    EXPECT_NEAR(found.number(0, "predicted") / exact, 1, 1e-9);
    EXPECT_GT(worst_factor(found), 1);
    EXPECT_LT(worst_factor(found), std::pow(10, 1 / 8.0) / 0.81);  // half a cell of the grid, and the noise
  }
}

TEST(Regimes, TheWorstFactorCountsBothWays) {
  Table rows({{"factor"}, {"status"}});
  rows.add({1.2, std::string("ok")});
  rows.add({0.4, std::string("ok")});
  rows.add({std::nan(""), std::string("no change")});
  EXPECT_DOUBLE_EQ(worst_factor(rows), 2.5);
  EXPECT_TRUE(std::isnan(worst_factor(rows.where("status", "no change"))));
}

/// Of fewer cells: at rest after a second, explicit methods and backward Euler store the energy that statics
/// say. Methods of second order that iterate a few times do not come to rest with a step a frame.
TEST(Regimes, TheLoadedCubeComesToTheSameRest) {
  RegimesConfig config;
  config.repetitions = 1;
  config.loaded = {.cells = 4, .moduli = {1e9}};
  Table loaded = empty_loaded();
  add_loaded(config.loaded, 1e9, compute_loaded(1e9, config), loaded);
  const HeldCube cube({.young = 1e9, .poisson = 0.3}, 4, 0.5, 1,
                      {{.box = {{1, 0, 0}, {1, 1, 1}}, .force = Vec3(0, 0, -1e5)}});
  State<double> rest = cube.start;
  Work work;
  ASSERT_EQ(find_integrator("static").make<double>({})->advance(cube.system, rest, 0, work), Status::ok);
  const double stored = cube.system.stored_energy(rest.x).elastic + cube.system.stored_energy(rest.x).volume;
  ASSERT_GE(loaded.size(), 7U);
  for (std::size_t r = 0; r < loaded.size(); ++r) {
    const std::string& method = loaded.text(r, "method");
    if (loaded.text(r, "kind") == "implicit" && method.rfind("backward_euler", 0) != 0) continue;
    EXPECT_EQ(loaded.text(r, "status"), "ok") << method;
    EXPECT_NEAR(loaded.number(r, "stored") / stored, 1, 1e-8) << method;
    EXPECT_LT(loaded.number(r, "kinetic"), 1e-12 * stored) << method;
    EXPECT_LT(loaded.number(r, "energy_difference"), 1e-8) << method;
    if (loaded.text(r, "kind") == "implicit") {
      EXPECT_GT(loaded.number(r, "motion_difference"), 1e-4) << method;
    }
  }
}

/// Explicit steps cost as the square root of the modulus: 1 s at 1e8 Pa, 10 s at 1e10; the others 2 s.
TEST(Regimes, LoadedCubesCrossWhereTimesAreEqual) {
  Table loaded({{"young"}, {"method"}, {"kind"}, {"seconds"}, {"energy_difference"}, {"status"}});
  for (const double young : {1e8, 1e9, 1e10}) {
    loaded.add({young, "verlet", "explicit", std::sqrt(young / 1e8), 1e6 / young, "ok"});
    loaded.add({young, "semi_implicit_euler", "explicit", 1.5 * std::sqrt(young / 1e8), 1e6 / young, "ok"});
    loaded.add({young, "a", "implicit", 2.0, 1e6 / young, "ok"});
    loaded.add({young, "b", "implicit", 0.5, 1e6 / young, "ok"});
    loaded.add({young, "c", "implicit", 50.0, 1e6 / young, "ok"});
    loaded.add({young, "d", "implicit", 0.1, 1e6 / young, "newton_stalled"});
  }
  const Table crossings = loaded_crossings(loaded);
  ASSERT_EQ(crossings.size(), 4U);
  EXPECT_NEAR(crossings.number(0, "young"), 4e8, 1);
  EXPECT_EQ(crossings.text(0, "status"), "ok");
  EXPECT_DOUBLE_EQ(crossings.number(0, "largest_energy_difference"), 1e-3);  // at 1e9
  EXPECT_EQ(crossings.text(1, "status"), "costs less at every modulus tried");
  EXPECT_EQ(crossings.text(2, "status"), "costs more at every modulus tried");
  EXPECT_EQ(crossings.text(3, "status"), "no run finished");
}

/// A limit of time ends what cannot end in it, an equilibrium too, and no more is said of it than that.
TEST(Regimes, RunsAreStoppedWhenTheyTakeTooLong) {
  RegimesConfig config;
  config.frames = 3;
  config.repetitions = 1;
  config.most_seconds = 1e-9;
  const Json result = compute_point({"held_box", 2, 0.5, 1e6}, config);
  for (const char* what : {"motion", "rest"}) {
    EXPECT_EQ(result[std::string(what) + "_status"], "ok");
    ASSERT_FALSE(result[what].empty());
    for (const Json& run : result[what]) {
      EXPECT_EQ(run["status"], too_slow) << run["method"];
      EXPECT_TRUE(std::isnan(run["error"].get<double>())) << run["method"];
    }
  }
  config.most_reference_seconds = 1e-9;
  const Json without = compute_point({"held_box", 2, 0.5, 1e6}, config);
  EXPECT_EQ(without["motion_status"], "the reference of the motion would take too long");
  EXPECT_EQ(without["rest_status"], "the reference of the rest takes too long");
}

/// A ball that is asked too early has not touched the ground: then there is nothing to compare with.
TEST(Regimes, AScenesTaskIsChecked) {
  RegimesConfig config;
  config.frames = 1;
  config.repetitions = 1;
  EXPECT_EQ(compute_point({"spin", 2, 0.5, 1e5}, config)["motion_status"], "ok");
  const Json early = compute_point({"ball", 3, 0.5, 1e5}, config);
  EXPECT_EQ(early["motion_status"], "the body has not touched the ground");
  EXPECT_TRUE(early["motion"].empty());
  EXPECT_EQ(early["rest_status"], "nothing holds it");
}

TEST(Regimes, MeasuresAndDrawsFromItsFiles) {
  RegimesConfig config{.grids = {{"held_box", 2, {0.5}, {1e4, 1e10}}, {"spin", 2, {0.5}, {1e5}}},
                       .frames = 3,
                       .repetitions = 1,
                       .most_seconds = 3600,  // no run is stopped, however busy the machine
                       .most_reference_seconds = 3600,
                       .loaded = {.cells = 2, .frames = 3, .moduli = {1e8, 1e9}}};
  Journal journal;
  Progress progress;
  RegimesTables tables = measure_regimes(config, 1, journal, progress);
  EXPECT_EQ(tables.status, Status::ok);
  EXPECT_EQ(tables.points.size(), 3U);
  EXPECT_EQ(tables.cheapest.size(), 3 * demands().size() - 1);  // what spins is not asked where it rests
  EXPECT_EQ(tables.loaded.distinct_numbers("young").size(), 2U);
  for (std::size_t r = 0; r < tables.runs.size(); ++r)
    EXPECT_TRUE(tables.runs.text(r, "status") != "ok" || tables.runs.number(r, "error") >= 0);
  const std::vector<NamedTable> files = regimes_files(std::move(tables));
  expect_same_drawings(find_experiment("regimes"), files);
  const Drawings drawn = draw_regimes(files);
  ASSERT_EQ(drawn.maps.size(), 2U);
  bool certain = true;  // of every motion that is asked for
  const Table& cheapest = find_table(files, "regimes");
  for (std::size_t r = 0; r < cheapest.size(); ++r) certain &= cheapest.text(r, "status") != uncertain;
  EXPECT_EQ(drawn.maps[0].chart.blank_label.empty(), certain);
  EXPECT_EQ(drawn.maps[0].chart.panels.size(), 2 * (demands().size() - 1));
  EXPECT_EQ(drawn.maps[0].chart.columns, int(demands().size() - 1));
  EXPECT_EQ(drawn.maps[1].chart.panels.size(), 1U);  // of what is held
  ASSERT_EQ(drawn.charts.size(), 1U);
  EXPECT_EQ(drawn.charts[0].chart.series.size(),
            find_table(files, "regimes_loaded").distinct("method").size());
}

}  // namespace
}  // namespace mss::studies::regimes
