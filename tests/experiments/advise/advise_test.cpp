// `mss advise`: scenes in other cells have the same material, errors are measured as documented, and advice
// keeps the error.
#include "experiments/advise/advise.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.hpp"
#include "experiments/advise/chart.hpp"
#include "experiments/advise/reference_levels.hpp"
#include "experiments/advise/report.hpp"
#include "experiments/advise/static_advice.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::advise {
namespace {

const double turn = 2 * std::numbers::pi;

SceneFamily family(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return {scene_file(name), overrides};
}

Candidate at_level(const SceneFamily& scenes, int level) {
  Candidate c = scenes.candidate(level);
  c.integrator = "damped_verlet";
  c.dt = 1e-4;
  return c;
}

TEST(SceneFamily, KeepsTheMaterialInOtherCells) {
  for (const char* name : {"cantilever", "fig5_2_throw", "voxel_creature"}) {
    const SceneFamily scenes = family(name);
    const BodyConfig coarse = scenes.scene(at_level(scenes, 1)).body,
                     fine = scenes.scene(at_level(scenes, 2)).body;
    EXPECT_DOUBLE_EQ(coarse.cell_size, 2 * fine.cell_size) << name;
    EXPECT_EQ(8 * coarse.voxels.count(), fine.voxels.count()) << name;
    EXPECT_NEAR(Body(coarse).total_mass(), Body(fine).total_mass(), 1e-12 * Body(fine).total_mass()) << name;
    const CubicStiffness a = cubic_stiffness(coarse.springs, coarse.cell_size),
                         b = cubic_stiffness(fine.springs, fine.cell_size);
    EXPECT_NEAR(a.c11, b.c11, 1e-12 * b.c11) << name;
    EXPECT_NEAR(a.c12, b.c12, 1e-12 * b.c11) << name;
    EXPECT_NEAR(a.c44, b.c44, 1e-12 * b.c11) << name;
    // Stress over rate of strain goes as a spring's damping over its length.
    const auto viscosity = [](const BodyConfig& body) {
      const double mass = body.density * std::pow(body.cell_size, 3);
      return body.damping.coefficient(body.springs.edge, mass, mass, body.cell_size, body.shear_modulus()) /
             body.cell_size;
    };
    EXPECT_NEAR(viscosity(coarse), viscosity(fine), 1e-12 * viscosity(fine)) << name;
  }
  const SceneFamily cantilever = family("cantilever");
  EXPECT_DOUBLE_EQ(cantilever.cell_size(4), cantilever.given().body.cell_size);
  EXPECT_DOUBLE_EQ(cantilever.cell_size(4), 0.25);
}

// A viscosity is the material's already.
TEST(SceneFamily, RescalesNoViscosity) {
  const SceneFamily scenes = family("free_cube", {"damping={ viscosity = 12.5 }"});
  for (const int level : {1, 6}) {
    EXPECT_EQ(scenes.scene(at_level(scenes, level)).body.damping.viscosity, 12.5);
    for (const std::string& setting : scenes.settings(at_level(scenes, level)))
      EXPECT_EQ(setting.find("damping"), std::string::npos) << setting;
  }
}

TEST(SceneFamily, LeavesOutWhatACandidateLeavesOut) {
  const SceneFamily scenes = family("free_cube");
  EXPECT_TRUE(scenes.is_calibrated());
  EXPECT_TRUE(scenes.has_volume_force());
  Candidate c = at_level(scenes, 2);
  c.face_share = 1;
  c.volume_force = false;
  c.precision = Precision::single;
  const Scene scene = scenes.scene(c);
  EXPECT_EQ(scene.body.springs.body, 0);
  EXPECT_EQ(scene.body.springs.volume, 0);
  EXPECT_EQ(scene.solve.precision, Precision::single);
  EXPECT_EQ(scene.solve.integrator, "damped_verlet");
  EXPECT_EQ(scene.solve.dt, 1e-4);
  EXPECT_FALSE(family("fig5_2_throw").is_calibrated());
}

/// Springs given to a box that is split are those of its parts.
TEST(SceneFamily, TakesSplitBoxes) {
  const char* springs = "material={density=1000, springs={edge=1000, face=500, body=250}}";
  const SceneFamily split = family("free_cube", {"body.cells=[2, 2, 2]", "body.refine=2", springs});
  Candidate same = split.candidate(level_of(split.given()));
  same.integrator = "verlet";
  const Scene scene = split.scene(same);
  EXPECT_EQ(scene.body.voxels.size(), split.given().body.voxels.size());
  EXPECT_EQ(scene.body.cell_size, split.given().body.cell_size);
  EXPECT_EQ(scene.body.springs.edge, 1000);
}

/// Penalties make the body stiffer, and a surface has vertices of its own.
TEST(SceneFamily, HasLawsOfContactThatLetStepsBeLong) {
  SceneFamily ball = family("mesh_sphere");
  ASSERT_EQ(ball.contacts().size(), 3U);
  EXPECT_EQ(ball.contacts()[2].name, "impulse on particles");
  Candidate penalty = at_level(ball, 4), impulse = penalty;
  impulse.contact = 2;
  EXPECT_EQ(ball.scene(penalty).environment.planes[0].contact, ContactLaw::penalty);
  EXPECT_EQ(ball.scene(impulse).environment.planes[0].contact, ContactLaw::impulse);
  EXPECT_EQ(ball.scene(impulse).environment.contact_surface, nullptr);
  EXPECT_GT(ball.bound(penalty).omega, 1.3 * ball.bound(impulse).omega);
  const std::vector<std::string> settings = ball.settings(impulse);
  EXPECT_EQ(settings[0], "plane.0.contact=impulse");
  EXPECT_EQ(settings[1], "body.contact_on=particles");
  EXPECT_EQ(family("cantilever").contacts().size(), 1U);
}

TEST(SceneFamily, RefusesWhatCannotBeComputedOtherwise) {
  EXPECT_THROW(family("cantilever", {"solve.integrator=static"}), InputError);
  EXPECT_THROW(family("cantilever", {"damping={ thesis = true }"}), InputError);
  EXPECT_THROW(family("cantilever", {"solve.duration=0"}), InputError);
}

/// One point that oscillates along x about 1, and a volume that oscillates with it.
Trajectory swing(double amplitude, double periods, int intervals = 128) {
  Trajectory out;
  for (int i = 0; i <= intervals; ++i) {
    const double phase = turn * periods * i / intervals;
    out.samples.push_back({.displacement = {Vec3(1 + amplitude * std::sin(phase), 0, 0)},
                           .volume_ratio = 1 + 0.01 * amplitude * std::sin(phase),
                           .energy = amplitude * std::sin(phase),
                           .exchanged = 5});
  }
  return out;
}

TEST(ErrorEstimator, MeasuresErrorsOverTheirScales) {
  const Trajectory truth = swing(0.5, 4), wide = swing(0.6, 4);
  EXPECT_NEAR(ErrorEstimator(ErrorOf::displacement, truth).error_of(wide), 0.1 / 1.5, 1e-12);
  EXPECT_NEAR(ErrorEstimator(ErrorOf::volume, truth).error_of(wide), 0.001, 1e-12);
  EXPECT_NEAR(ErrorEstimator(ErrorOf::energy, truth).error_of(wide), 0.1 / 5, 1e-12);
  EXPECT_NEAR(ErrorEstimator(ErrorOf::frequency, truth).error_of(wide), 0, 1e-12);
  EXPECT_NEAR(ErrorEstimator(ErrorOf::frequency, truth).error_of(swing(0.6, 4.2)), 0.05, 2e-3);
  EXPECT_TRUE(std::isnan(ErrorEstimator(ErrorOf::frequency, truth).error_of(swing(0.5, 0.6))));
  Trajectory half_sampled = wide;
  for (std::size_t i = 1; i < half_sampled.samples.size(); i += 2)
    half_sampled.samples[i].displacement.clear();
  EXPECT_NEAR(ErrorEstimator(ErrorOf::displacement, truth).error_of(half_sampled), 0.1 / 1.5, 1e-3);
}

// Of a cube that is stretched, turned and moved only the stretch is left.
TEST(Deformation, IsWhatARigidMotionLeaves) {
  std::vector<Vec3> rest, moved, turned_only;
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(2.5, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const Vec3 stretch(0.1, -0.03, 0), path(30, -7, 2);
  for (int c = 0; c < 27; ++c) {
    const int plane = c / 9, line = c / 3 % 3;
    const Vec3 x(c % 3 - 1, line - 1, plane - 1);
    rest.push_back(x + Vec3(4, 5, 6));
    moved.push_back(rotation * (x + stretch.cwiseProduct(x)) + path - rest.back());
    turned_only.push_back(rotation * x + path - rest.back());
  }
  const std::vector<Vec3> left = deformation(rest, moved), none = deformation(rest, turned_only);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    EXPECT_LT((left[i] - stretch.cwiseProduct(rest[i] - Vec3(4, 5, 6))).norm(), 1e-13);
    EXPECT_LT(none[i].norm(), 1e-13);
  }
}

TEST(Deformation, IsTheDefaultWhereBodiesFly) {
  EXPECT_EQ(default_error_of(family("free_cube").given()), ErrorOf::deformation);
  EXPECT_EQ(default_error_of(family("cantilever").given()), ErrorOf::displacement);
}

// The flight of a cube that falls on the ground is right with one cell, its deformation is not.
TEST(Deformation, TellsALatticeThatIsTooCoarse) {
  SceneFamily cube = family("fig5_2_throw", {"solve.duration=1"});
  const auto error_of_one_cell = [&](ErrorOf of) {
    const Sampling sampling = sampling_of(cube.given(), of);
    const auto run = [&](int level) {
      Candidate candidate = at_level(cube, level);
      candidate.dt = sampling.interval / 32;
      return sample_scene(cube.scene(candidate), sampling, [](const SampledRun&) { return true; });
    };
    return ErrorEstimator(of, run(6).trajectory).error_of(run(1).trajectory);
  };
  EXPECT_LT(error_of_one_cell(ErrorOf::displacement), 0.1);
  EXPECT_GT(error_of_one_cell(ErrorOf::deformation), 0.2);
}

TEST(Trajectories, TendToWhereSquaresVanish) {
  const double coarse = 0.2, factor = 1.5, fine = coarse / factor;
  const Trajectory limit = extrapolate(swing(0.5 + coarse * coarse, 4), swing(0.5 + fine * fine, 4), factor);
  EXPECT_LT(ErrorEstimator(ErrorOf::displacement, swing(0.5, 4)).error_of(limit), 1e-14);
  EXPECT_LT(ErrorEstimator(ErrorOf::energy, swing(0.5, 4)).error_of(limit), 1e-14);
}

/// Half a second are 30 frames with five samples each, ten seconds 600 of which every fourth is one.
TEST(Sampling, HasStepsThatDivideAFrame) {
  const Sampling brief = sampling_of(family("free_cube", {"solve.duration=0.5"}).given(), {});
  EXPECT_EQ(brief.count, 150);
  EXPECT_DOUBLE_EQ(brief.interval, frame / 5);
  EXPECT_NEAR(brief.duration(), 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(frame_step(1, brief), frame);
  EXPECT_DOUBLE_EQ(frame_step(0.3 * frame, brief), frame / 4);
  EXPECT_DOUBLE_EQ(frame_step(frame / 7, brief), frame / 7);
  EXPECT_EQ(steps_per_frame(frame_step(frame / 1001, brief)), 1005) << "some end at every sample";
  EXPECT_DOUBLE_EQ(step_between_samples(1, brief), brief.interval);
  EXPECT_DOUBLE_EQ(step_between_samples(frame / 7, brief), frame / 10);
  const Sampling extended = sampling_of(family("free_cube", {"solve.duration=10"}).given(), {});
  EXPECT_EQ(extended.count, 150);
  EXPECT_DOUBLE_EQ(extended.interval, 4 * frame);
  EXPECT_DOUBLE_EQ(frame_step(1, extended), frame);
  EXPECT_DOUBLE_EQ(step_between_samples(0.4 * frame, extended), frame / 3);
  const Sampling partial = sampling_of(family("free_cube", {"solve.duration=0.02"}).given(), {});
  EXPECT_LE(partial.duration(), 0.02);
  EXPECT_GT(partial.duration(), 0.99 * 0.02);
}

/// Whatever the clock says: forces on a particle and its steps, elements for more, vertices that planes
/// touch.
TEST(Sampling, CountsWork) {
  Effort effort{.seconds = 5, .particles = 100};
  EXPECT_EQ(by_work(effort), 0);
  effort.work.force_evaluations = 1000;
  const double forces = by_work(effort);
  EXPECT_DOUBLE_EQ(forces, 2e-8 * 1000 * 100);
  effort.of_elements = true;
  EXPECT_GT(by_work(effort), 5 * forces);
  effort.of_elements = false;
  effort.work.steps = 1000;
  const double steps = by_work(effort);
  effort.touched = 50;
  EXPECT_DOUBLE_EQ(by_work(effort) - steps, 2e-8 * 1000 * 50);
  effort.work.factorisations = 1;
  const double small = by_work(effort);
  effort.particles = 100000;
  EXPECT_GT(by_work(effort), 1e4 * small) << "factors grow faster than the body";
}

/// Evenly strided through a lattice of 17 points a row they would all lie on one of its faces.
TEST(Sampling, CoversTheBody) {
  const Sampling sampling = sampling_of(family("free_cube", {"body.cells=[16, 16, 16]"}).given(), {});
  ASSERT_EQ(sampling.points.size(), 300U);
  for (int axis = 0; axis < 3; ++axis) {
    double low = 1e9, high = -1e9, sum = 0;
    for (const Vec3& point : sampling.points) {
      low = std::min(low, point[axis]);
      high = std::max(high, point[axis]);
      sum += point[axis];
    }
    EXPECT_EQ(std::lround((high - low) / family("free_cube").given().body.cell_size), 16);
    EXPECT_NEAR((sum / 300 - low) / (high - low), 0.5, 0.1);
  }
}

/// A step over many intervals is charged between the samples at its ends, and nothing but stepping is.
TEST(Sampling, ChargesLongStepsWhereTheyEnd) {
  SceneFamily cube = family("free_cube", {"solve.duration=0.1"});
  const Sampling sampling = sampling_of(cube.given(), {});
  Candidate candidate = cube.candidate(2);
  candidate.integrator = "backward_euler";
  candidate.linear_solver = "cholmod";
  candidate.dt = frame;
  const SampledRun run = sample_scene(
      cube.scene(candidate), sampling, [](const SampledRun&) { return true; },
      [](const Effort& effort) { return double(effort.work.steps); });
  EXPECT_EQ(run.status, Status::ok);
  EXPECT_EQ(run.seconds, std::vector<double>(6, 1));
  EXPECT_NEAR(run.cost(), 6 / 0.1, 1e-9);
  EXPECT_NEAR(run.busiest(), 6 / 0.1, 1e-9);
  EXPECT_NEAR(run.simulated, 0.1, 1e-12);
}

/// An interval that is charged more than it may be ends a run there, whatever the clock says.
TEST(Sampling, EndsWhereItIsChargedTooMuch) {
  SceneFamily cube = family("free_cube", {"solve.duration=0.1"});
  const Sampling sampling = sampling_of(cube.given(), {});
  Candidate candidate = cube.candidate(2);
  candidate.integrator = "verlet";
  candidate.dt = sampling.interval / 16;
  const auto sampled = [&](double most) {
    return sample_scene(
        cube.scene(candidate), sampling, [](const SampledRun&) { return true; },
        [](const Effort& effort) { return double(effort.work.steps); }, most);
  };
  const SampledRun free = sampled(16.5), cut = sampled(10.5);
  EXPECT_FALSE(free.ended_early);
  EXPECT_EQ(free.total_seconds(), 16 * sampling.count);
  EXPECT_TRUE(cut.ended_early);
  EXPECT_EQ(cut.total_seconds(), 11);
  EXPECT_NEAR(cut.simulated, 11 * *candidate.dt, 1e-12);
}

TEST(Sampling, MeasuresOnlyWhatIsRequested) {
  SceneFamily cube = family("free_cube", {"solve.duration=0.1"});
  Candidate candidate = cube.candidate(2);
  candidate.integrator = "verlet";
  candidate.dt = 0.1 / 256;
  const auto last_of = [&](ErrorOf of) {
    const SampledRun run = sample_scene(cube.scene(candidate), sampling_of(cube.given(), of),
                                        [](const SampledRun&) { return true; });
    EXPECT_EQ(run.status, Status::ok);
    return run.trajectory.samples.back();
  };
  const Trajectory::Sample moved = last_of(ErrorOf::displacement), swollen = last_of(ErrorOf::volume),
                           held = last_of(ErrorOf::energy);
  EXPECT_EQ(moved.displacement, swollen.displacement);
  EXPECT_EQ(moved.displacement, held.displacement);
  EXPECT_EQ(moved.volume_ratio, 1);
  EXPECT_NE(swollen.volume_ratio, 1);
  EXPECT_EQ(moved.exchanged, 0);
  EXPECT_GT(held.exchanged, 0);
  EXPECT_NE(held.energy, 0);
}

TEST(Advice, KeepsTheErrorAgainstAReferenceItDidNotUse) {
  SceneFamily cube = family("free_cube", {"solve.duration=0.5"});
  const AdviseRequest request{.error = 0.05, .patience = 20, .charge = by_work};
  Progress progress;
  const Advice advice = advise(cube, request, progress);
  ASSERT_TRUE(advice.best.has_value()) << advice.explanation;
  EXPECT_TRUE(advice.within_budget);
  const Trial& best = advice.trials[*advice.best];
  EXPECT_EQ(best.verdict, Verdict::advised);
  EXPECT_EQ(to_string(best), "advised");
  EXPECT_LE(best.error, request.error);
  EXPECT_LE(advice.checked_error, request.error);
  EXPECT_LE(best.error_at_half_step, request.error);
  EXPECT_GT(best.min_jacobian, 0);
  EXPECT_GT(best.max_stretch, 0);
  if (best.candidate.dt) {
    EXPECT_DOUBLE_EQ(*best.candidate.dt * steps_per_frame(*best.candidate.dt), frame);
  }
  EXPECT_FALSE(best.costs.empty());
  EXPECT_GT(best.cost, 0);
  for (const Trial& trial : advice.trials) EXPECT_FALSE(to_string(trial).empty());
  for (const Trial& trial : advice.trials)
    if (trial.meets && serves_some_motions(trial.candidate) == serves_some_motions(best.candidate)) {
      EXPECT_GE((1 + cost_noise) * trial.cost, best.cost);
    }

  const Sampling sampling = sampling_of(cube.given(), {});
  Candidate finer = at_level(cube, 10);
  finer.integrator = "rk4";
  finer.dt = sampling.interval / 8;
  const auto go_on = [](const SampledRun&) { return true; };
  const SampledRun truth = sample_scene(cube.scene(finer), sampling, go_on),
                   advised = sample_scene(cube.scene(best.candidate), sampling, go_on);
  ASSERT_EQ(truth.status, Status::ok);
  EXPECT_LE(ErrorEstimator(request.of, truth.trajectory).error_of(advised.trajectory), request.error);
  // Elements of another kind say nearly the same, and are candidates.
  EXPECT_EQ(advice.elements.level, 2 * best.candidate.level) << advice.elements.problem;
  EXPECT_LT(advice.elements.error, 2 * request.error);
  EXPECT_GT(advice.elements.uncertainty, 0);
  EXPECT_GT(advice.elements.cost, 0);
  EXPECT_GT(advice.elements.cost_of_finer, advice.elements.cost);
  for (const char* model : {"springs", "linear", "corotational", "st_venant_kirchhoff"})
    EXPECT_TRUE(std::any_of(advice.trials.begin(), advice.trials.end(), [&](const Trial& trial) {
      return trial.candidate.model == model;
    })) << model;
  const std::vector<NamedTable> tables = advice_tables(cube, request, advice);
  EXPECT_EQ(tables[0].table.size(), advice.trials.size());
  std::vector<NamedTable> read;
  read.reserve(tables.size());
  for (const NamedTable& table : tables)
    read.push_back({table.name, Table::read(table.table.csv(), table.name)});
  ASSERT_EQ(draw(read).charts.size(), 1U);
  const auto script = [](const std::vector<NamedTable>& all) {
    return gnuplot_script(draw(all).charts[0].chart, "a.svg", "a.png");
  };
  EXPECT_EQ(script(read), script(tables));
}

// What is advised is a file of settings, which load as what was tried.
TEST(SceneFamily, MatchesModuliAsALoadedSceneDoes) {
  const SceneFamily cantilever = family("cantilever");
  Candidate matched = at_level(cantilever, 2);
  matched.match = FrequencyMatch::Of::both;
  const Scene tried = cantilever.scene(matched),
              loaded = load_matched_scene(scene_file("cantilever"), cantilever.settings(matched)).scene;
  EXPECT_FALSE(tried.match);
  EXPECT_NEAR(tried.body.elastic->young, loaded.body.elastic->young, 1e-6 * loaded.body.elastic->young);
  EXPECT_NEAR(tried.body.elastic->poisson, loaded.body.elastic->poisson, 1e-6);
  EXPECT_NEAR(tried.body.damping.zeta, loaded.body.damping.zeta, 1e-6);
  EXPECT_LT(tried.body.elastic->young, 0.9 * cantilever.given().body.elastic->young);
  EXPECT_THROW(family("cantilever", {"body.match=both"}), InputError);
}

// A beam that bends: both ways to compute less of it are far cheaper than cells that resolve it.
TEST(Advice, TakesMatchedCellsOrAReducedBodyOfABeam) {
  SceneFamily beam = family("cantilever", {"solve.duration=0.5"});
  const AdviseRequest request{.error = 0.1, .patience = 10, .charge = by_work};
  Progress progress;
  const Advice advice = advise(beam, request, progress);
  ASSERT_TRUE(advice.best) << advice.explanation;
  const Trial& best = advice.trials[*advice.best];
  EXPECT_TRUE(serves_some_motions(best.candidate));
  EXPECT_LE(advice.checked_error, request.error);
  const bool is_matched = best.candidate.match.has_value();
  EXPECT_EQ((is_matched ? advice.about_matched : advice.about_reduced).rfind("taken: ", 0), 0U)
      << advice.about_matched << "\n"
      << advice.about_reduced;
  for (const Trial& trial : advice.trials)
    if (trial.meets && !serves_some_motions(trial.candidate)) {
      EXPECT_GE(trial.cost, worth_restricting * best.cost);
    }
}

/// Where a finer reference refutes those of a search, it is added to them, and they go on from there.
TEST(ReferenceLevels, GoOnFromWhatWasAdded) {
  SceneFamily cube = family("free_cube", {"solve.duration=0.1"});
  const AdviseRequest request{.error = 0.01, .patience = 1, .charge = by_work};
  Progress progress;
  SearchState state(cube, request, progress);
  ReferenceLevels references(state);
  references.refine();
  ASSERT_GE(references.all().size(), 3U);
  const int finest = references.finest().level;
  const double before = references.uncertainty();
  auto finer = references.compute(finest + 1);
  ASSERT_TRUE(finer.has_value());
  EXPECT_EQ(references.finest().level, finest);
  references.add(std::move(*finer));
  EXPECT_EQ(references.finest().level, finest + 1);
  EXPECT_NE(references.uncertainty(), before);
  const std::size_t computed = state.trials.size();
  references.refine();
  for (std::size_t i = computed; i < state.trials.size(); ++i)
    EXPECT_GT(state.trials[i].candidate.level, finest + 1);
  EXPECT_EQ(references.is_accurate_enough(), references.uncertainty() <= references.allowed_uncertainty());
  references.conclude();
  for (const auto& reference : references.all())
    if (reference.level < references.finest().level) {
      EXPECT_GT(state.trials[reference.trial].error, 0);
    }
}

// Vertex block descent in frame-sized steps folds this soft creature, and is the cheapest within 5 percent.
TEST(Advice, RejectsWhatFoldsWhereTheReferenceDoesNot) {
  SceneFamily creature =
      family("voxel_creature", {"body.cell_size=0.016667", "material.young=5e5", "solve.duration=0.1"});
  Progress progress;
  const Advice advice =
      advise(creature, {.error = 0.05, .of = ErrorOf::volume, .patience = 2.5, .charge = by_work}, progress);
  ASSERT_TRUE(advice.best.has_value()) << advice.explanation;
  EXPECT_FALSE(advice.reference_folds);
  EXPECT_GT(advice.trials[*advice.best].min_jacobian, 0);
  bool vbd_folds = false;
  for (const Trial& trial : advice.trials) {
    if (trial.meets) {
      EXPECT_GT(trial.min_jacobian, 0) << trial.candidate.integrator;
    }
    if (trial.verdict != Verdict::folds) continue;
    EXPECT_LE(trial.min_jacobian, 0);
    EXPECT_EQ(to_string(trial).find("folds: min_jacobian -"), 0U) << to_string(trial);
    vbd_folds = vbd_folds || trial.candidate.integrator == "vbd";
  }
  EXPECT_TRUE(vbd_folds);
  const Table rows = advice_tables(creature, {}, advice)[0].table;
  EXPECT_EQ(rows.number(*advice.best, "min_jacobian"), advice.trials[*advice.best].min_jacobian);
}

TEST(Advice, JudgesByTheLargerErrorOfAStepAndItsHalf) {
  Trial trial;
  trial.error = 0.03;
  EXPECT_EQ(judged_error(trial), 0.03);
  trial.error_at_half_step = 0.02;
  EXPECT_EQ(judged_error(trial), 0.03);
  trial.error_at_half_step = 0.27;
  EXPECT_EQ(judged_error(trial), 0.27);
  trial.verdict = Verdict::fluke;
  EXPECT_EQ(to_string(trial), "a fluke: at half the step the error is 27 %");
}

/// The engine programmer's question: what is advised keeps the budget, steps divide frames, and ten seconds
/// of it have nothing to warn of.
TEST(FrameAdvice, FitsTheBudgetAndRunsClean) {
  SceneFamily creature =
      family("voxel_creature", {"body.cell_size=0.016667", "material.young=5e5", "solve.duration=0.1"});
#ifdef NDEBUG
  const double budget = MSS_SANITIZED != 0 ? 3 : 0.1;
#else
  const double budget = 3;
#endif
  const AdviseRequest request{.budget = budget, .of_stability = true, .patience = 0.3};
  Progress progress;
  const Advice advice = advise_for_frames(creature, request, progress);
  ASSERT_TRUE(advice.best.has_value()) << advice.explanation;
  const Trial& best = advice.trials[*advice.best];
  EXPECT_EQ(to_string(best), "advised");
  EXPECT_LE(best.cost, *request.budget);
  EXPECT_LE(best.busiest, *request.budget);
  EXPECT_GT(best.min_jacobian, 0);
  EXPECT_DOUBLE_EQ(*best.candidate.dt * steps_per_frame(*best.candidate.dt), frame);
  Scene scene = creature.scene(best.candidate);
  scene.solve.duration = clean_seconds;
  const SimulationResult result = simulate(scene, progress);
  EXPECT_EQ(result.status, Status::ok);
  EXPECT_TRUE(diagnostics_of(scene, result).empty());
  for (const SeriesRow& row : result.series) EXPECT_GT(row.min_jacobian, 0) << row.t;
  const std::vector<NamedTable> tables = advice_tables(creature, request, advice);
  EXPECT_EQ(find_table(tables, "advise_request").number(0, "error"), 0) << "none is required";
  EXPECT_EQ(draw(tables).charts.size(), 1U);
}

TEST(FrameAdvice, SaysWhatDoesNotFit) {
  SceneFamily creature = family("voxel_creature", {"solve.duration=0.1"});
  Progress progress;
  const Advice advice = advise_for_frames(
      creature, {.budget = 1e-6, .of_stability = true, .patience = 0.1, .charge = by_work}, progress);
  EXPECT_FALSE(advice.best.has_value());
  EXPECT_NE(advice.explanation.find("nothing that was tried fits"), std::string::npos) << advice.explanation;
}

/// Where references take more than patience, errors are not known, and said to be so.
TEST(FrameAdvice, SaysThatErrorsAreNotKnown) {
  const SceneFamily cube = family("free_cube");
  Trial trial{.candidate = cube.candidate(1), .cost = 0.01, .min_jacobian = 0.9, .max_stretch = 0.1};
  trial.ran_at_half_step = true;
  Advice advice;
  advice.trials = {trial, trial};
  advice.best = 0;
  advice.ties = {1};
  advice.within_budget = true;
  advice.errors_rank = false;
  const std::string said = summary(cube, {.budget = 0.1, .of_stability = true}, advice);
  EXPECT_NE(said.find("error of displacement: not known"), std::string::npos) << said;
  EXPECT_NE(said.find("ms, error not known)"), std::string::npos) << said;
  EXPECT_EQ(said.find("nan"), std::string::npos) << said;
}

/// A budget that is not used up is explained.
TEST(FrameAdvice, SaysThatSmallerCellsFold) {
  const SceneFamily cube = family("free_cube");
  ASSERT_LT(cube.cell_size(2), cube.cell_size(1));
  Trial best{.candidate = cube.candidate(1), .cost = 0.01, .min_jacobian = 0.9, .max_stretch = 0.1};
  Trial smaller{.candidate = cube.candidate(2)};
  smaller.verdict = Verdict::folds;
  Advice advice;
  advice.trials = {best, smaller};
  advice.best = 0;
  advice.within_budget = true;
  const AdviseRequest request{.budget = 0.1, .of_stability = true};
  const std::string said = summary(cube, request, advice);
  EXPECT_NE(said.find("in smaller cells 1 candidate folds or nearly so"), std::string::npos) << said;
  advice.trials = {best, best};
  EXPECT_EQ(summary(cube, request, advice).find("in smaller cells"), std::string::npos);
}

/// A second search has the same trials, at the same costs.
TEST(Advice, DependsOnNothingButWhatItCharges) {
  SceneFamily cube = family("free_cube", {"solve.duration=0.1"});
  const AdviseRequest request{.error = 0.1, .patience = 1, .charge = by_work};
  const auto rows = [&] {
    Progress progress;
    return advice_tables(cube, request, advise(cube, request, progress))[0].table.csv();
  };
  const std::string once = rows();
  EXPECT_NE(once.find("advised"), std::string::npos);
  EXPECT_EQ(rows(), once);
}

// Its trials are dropped for no reason but the status of their runs.
TEST(Advice, ComparesWithAGridThatNothingPrunes) {
  SceneFamily cube = family("free_cube", {"solve.duration=0.02"});
  Progress progress;
  const Advice pruned = try_all(cube, {.error = 0.05, .charge = by_work}, 1, 4, true, progress),
               all = try_all(cube, {.error = 0.05, .charge = by_work}, 1, 4, false, progress);
  const auto unfinished = [](const Trial& trial) {  // and a step more would not go beyond the end
    return 0.02 * (1 - trial.share) > trial.candidate.dt.value_or(1e-9) &&
           (trial.verdict == Verdict::costly || trial.verdict == Verdict::inaccurate ||
            trial.verdict == Verdict::too_costly_to_run);
  };
  EXPECT_GT(std::count_if(pruned.trials.begin(), pruned.trials.end(), unfinished), 20);
  EXPECT_EQ(std::count_if(all.trials.begin(), all.trials.end(), unfinished), 0);
}

TEST(Advice, ExplainsWhatIsImpossible) {
  Progress progress;
  SceneFamily cube = family("free_cube", {"solve.duration=0.1"});
  const Advice inexact = advise(cube, {.error = 1e-9, .patience = 0.05, .charge = by_work}, progress);
  EXPECT_FALSE(inexact.best.has_value());
  EXPECT_NE(inexact.explanation.find("uncertain by"), std::string::npos) << inexact.explanation;
  AdviseRequest hasty{.error = 0.1, .patience = 20, .charge = by_work};
  hasty.budget = 1e-9;
  const Advice none = advise(cube, hasty, progress);
  ASSERT_TRUE(none.best.has_value()) << none.explanation;
  EXPECT_FALSE(none.within_budget);
  EXPECT_NE(none.explanation.find("nothing is that cheap"), std::string::npos) << none.explanation;
}

/// Its middle is a particle of every other lattice only.
TEST(Advice, PassesOverLatticesThatCannotBe) {
  SceneFamily cube =
      family("free_cube", {"solve.duration=0.1", "body.cells=[4, 4, 4]",
                           "strike=[{box=[[-0.1,-0.1,-0.1],[-0.1,-0.1,-0.1]],at=0.01,impulse=[0,0,1]}]"});
  Progress progress;
  const Advice advice = advise(cube, {.error = 0.5, .patience = 1, .charge = by_work}, progress);
  const auto impossible = [](const Trial& trial) {
    return trial.candidate.level == 1 &&
           to_string(trial).find("impossible: strike.0.box contains no particle") == 0;
  };
  EXPECT_TRUE(std::any_of(advice.trials.begin(), advice.trials.end(), impossible));
  EXPECT_TRUE(std::any_of(advice.trials.begin(), advice.trials.end(),
                          [](const Trial& trial) { return trial.candidate.level == 2 && trial.share == 1; }));
}

TEST(Advice, NeedsSomethingThatMoves) {
  Progress progress;
  SceneFamily still = family("free_cube", {"start={ velocity = [0, 0, 0] }", "solve.duration=0.1"});
  EXPECT_THROW(advise(still, {}, progress), InputError);
  SceneFamily brief = family("free_cube", {"solve.duration=0.01"});
  EXPECT_THROW(advise(brief, {.of = ErrorOf::frequency}, progress), InputError);
  SceneFamily flying = family("fig5_2_throw");
  EXPECT_THROW(advise(flying, {.of = ErrorOf::deformation}, progress), InputError);
}

// Errors of the cantilever at 2, 4 and 8 cells across are 19, 6.2 and 1.8 percent, corrected 3.6, 1.0 and
// 0.3. Smaller cells in places do not pay: bending is everywhere.
TEST(StaticAdvice, FindsCellsThatMeetTheErrorAsComputedAndCorrected) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "static_advice.toml";
  write_atomically(file,
                   "[body]\ncells = [16, 4, 4]\ncell_size = 0.25\n"
                   "[material]\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\nface_share = 1\n"
                   "[environment]\ngravity = [0, 0, 0]\n"
                   "[[hold]]\nbox = [[0, 0, 0], [0, 1, 1]]\n"
                   "[[load]]\nbox = [[4, 0, 0], [4, 1, 1]]\nforce = [0, 0, -1]\n"
                   "[solve]\nintegrator = \"static\"\n[expect]\n"
                   "displacement = { box = [[4, 0, 0], [4, 1, 1]], value = [0, 0, 0], within = 1 }\n");
  const Scene scene = load_scene(file);
  const AdviseRequest request{.error = 0.05, .patience = 0.8, .charge = by_work};
  Progress progress;
  const StaticAdvice advice = advise_at_rest(scene, request, progress);
  EXPECT_EQ(advice.explanation, "");
  EXPECT_EQ(advice.quantity, "displacement 0 z");
  EXPECT_EQ(advice.as_computed, 0.125);
  EXPECT_EQ(advice.corrected, 0.5);
  const std::vector<NamedTable> tables = static_tables(request, advice);
  const Table rows = tables[0].table.where("quantity", "displacement 0 z").where("cell_size", 0.25);
  ASSERT_EQ(rows.size(), 1);
  EXPECT_NEAR(rows.number(0, "limit"), -2.6413e-3, 2e-5);
  EXPECT_NEAR(rows.number(0, "error"), -0.0615, 0.007);
  EXPECT_NEAR(rows.number(0, "estimate") / rows.number(0, "limit"), 0.0517, 0.001);
  EXPECT_EQ(draw_at_rest(tables).charts.size(), 1);
  EXPECT_GE(advice.maps.size(), 3U);
  EXPECT_FALSE(advice.map);
  EXPECT_NE(summary(scene, request, advice).find("smaller cells in places do not pay"), std::string::npos);
  EXPECT_THROW(advise_at_rest(load_scene(file, {"body.refinement=\"auto\""}), request, progress), InputError);
  EXPECT_THROW(advise_at_rest(scene, {.of = ErrorOf::volume}, progress), InputError);
  const StaticAdvice hurried = advise_at_rest(scene, {.patience = 1e-9, .charge = by_work}, progress);
  EXPECT_EQ(hurried.sizes.size(), 1);
  EXPECT_NE(hurried.explanation.find("--patience"), std::string::npos);
  EXPECT_TRUE(hurried.maps.empty());
}

// A load on a quarter of the edge: the particles under it share it, so that its area, and with it the error,
// falls by half as cells do.
TEST(StaticAdvice, AdvisesSmallerCellsUnderALoadOnAPatch) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "static_maps.toml";
  write_atomically(file,
                   "[body]\ncells = [16, 16, 16]\ncell_size = 0.0625\n"
                   "[material]\ndensity = 20\nyoung = 1e5\npoisson = 0.3\n"
                   "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n"
                   "[[load]]\nbox = [[0.375, 0.375, 1], [0.625, 0.625, 1]]\nforce = [0, 0, -1]\n"
                   "[solve]\nintegrator = \"static\"\n[expect]\n"
                   "displacement = { box = [[0.375, 0.375, 1], [0.625, 0.625, 1]], value = [0, 0, 0], "
                   "within = 1 }\n");
  const Scene scene = load_scene(file);
  const AdviseRequest request{.error = 0.4, .patience = 0.8, .charge = by_work};
  Progress progress;
  const StaticAdvice advice = advise_at_rest(scene, request, progress);
  ASSERT_TRUE(advice.map) << summary(scene, request, advice);
  const MapTried& map = advice.maps[*advice.map];
  EXPECT_GT(map.cell_size, advice.as_computed);
  EXPECT_GT(map.gain, 3);
  const Table maps = find_table(static_tables(request, advice), "static_advice_maps");
  EXPECT_EQ(maps.size(), advice.maps.size());
  EXPECT_LT(std::abs(maps.number(*advice.map, "error")), 0.4);
  EXPECT_LT(3 * map.particles, 17U * 17 * 17);
  EXPECT_NE(summary(scene, request, advice).find("in place of 4913"), std::string::npos);
}

}  // namespace
}  // namespace mss::advise
