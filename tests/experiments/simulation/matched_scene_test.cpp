// Cells whose moduli are matched: what their motions are worth, what is refused, and what is warned of.
#include "experiments/simulation/matched_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss {
namespace {

constexpr double pi = 3.14159265358979;

/// A beam of 1 x 0.25 x 0.25 m clamped at x = 0, of E = 10 MPa, whose viscosity is 8e-5 s of its shear
/// modulus.
std::string beam_text(int cells, double gravity, const std::string& more = "",
                      const std::string& method = "velocity_verlet") {
  return fmt::format(
      "[body]\ncells = [{0}, {1}, {1}]\ncell_size = {2}\n"
      "[material]\ndensity = 1000\nyoung = 1e7\npoisson = 0.3\n"
      "[damping]\nviscosity = 307.69230769230768\n"
      "[environment]\ngravity = [0, 0, {3}]\n"
      "[[hold]]\nbox = [[0, 0, 0], [0, 0.25, 0.25]]\n"
      "[solve]\nintegrator = \"{5}\"\nduration = 0.5\n{4}",
      cells, cells / 4, 1.0 / cells, -gravity, more, method);
}

/// The same cells, matched to those of the finest.
Scene beam(int cells, double gravity, const std::string& match, int finest) {
  if (match.empty()) return parse_scene(beam_text(cells, gravity));
  return matched(parse_scene(beam_text(cells, gravity), {fmt::format("body.match=\"{}\"", match),
                                                         fmt::format("body.match_to={}", finest / cells)}))
      .scene;
}

/// Where a static load leaves the beam.
State<double> at_rest(const Scene& scene, const std::string& more) {
  Scene loaded = parse_scene(beam_text(scene.body.voxels.nx(), 0, more, "static"));
  loaded.body = scene.body;
  loaded.solve.duration = 1;
  const Body body(loaded.body);
  SceneRun<double> run(loaded, body);
  Work work;
  EXPECT_EQ(run.advance(loaded.solve.duration, work), Status::ok);
  State<double> state = run.state();
  state.t = 0;
  state.v.array() = 0;
  return state;
}

/// The longest step that ends at frames of 1/60 s and is at most a share of the limit [s].
double frame_step(const Scene& scene, const Body& body, double share) {
  SpringSystem<double> system(body, scene.environment, {.threads = 1});
  Work work;
  const double dt =
      predicted_step(find_integrator("velocity_verlet"), system, system.undeformed_state(), work).dt;
  return 1 / (60 * std::ceil(1 / (60 * share * dt)));
}

using Frames = std::vector<Field<double>>;

/// Positions over thirty frames of 1/60 s.
Frames motion_of(const Scene& scene, const Body& body, double share, const std::string& released_from) {
  Scene run_scene = scene;
  run_scene.solve.dt = frame_step(scene, body, share);
  SceneRun<double> run(run_scene, body);
  if (!released_from.empty()) run.go_on_from(at_rest(scene, released_from));
  Frames frames{run.state().x};
  Work work;
  for (int frame = 1; frame <= 30; ++frame) {
    EXPECT_EQ(run.advance(frame / 60.0, work), Status::ok);
    frames.push_back(run.state().x);
  }
  return frames;
}

/// Largest root-mean-square distance of a motion from a finer one, over the largest displacement of that.
double error_of(const Frames& coarse, const Body& of, const Frames& fine, const Body& truth) {
  TriangleMesh particles;
  for (const std::ptrdiff_t site : truth.sites()) particles.vertices.push_back(truth.rest_position(site));
  const BodyConfig& config = of.config();
  const EmbeddedSurface points(particles, config.voxels, config.cell_size, config.origin);
  double most_error = 0, most_moved = 0;
  for (std::size_t f = 0; f < fine.size(); ++f) {
    double error = 0, moved = 0;
    for (std::size_t p = 0; p < truth.sites().size(); ++p) {
      const Vec3 x = fine[f].at(truth.sites()[p]);
      error += (points.at(p, coarse[f]) - x).squaredNorm();
      moved += (x - particles.vertices[p]).squaredNorm();
    }
    most_error = std::max(most_error, error);
    most_moved = std::max(most_moved, moved);
  }
  return std::sqrt(most_error / most_moved);
}

const std::string tip_load = "[[load]]\nbox = [[1, 0, 0], [1, 0.25, 0.25]]\nforce = [0, 0, -1570]\n";
const std::string tip_turn = fmt::format(
    "[[hold]]\nbox = [[1, 0, 0], [1, 0.25, 0.25]]\nturn = {{ axis = [1, 0, 0], centre = [1, 0.125, 0.125], "
    "rate = {}, until = 1.0 }}\n",
    15 * pi / 180);

constexpr int finest = 32;

/// The motion of the beam in fine cells, and errors of coarser ones.
class BeamMotion {
 public:
  BeamMotion(double gravity, const std::string& released_from)
      : gravity_(gravity),
        from_(released_from),
        body_(beam(finest, gravity, "", finest).body),
        frames_(motion_of(beam(finest, gravity, "", finest), body_, 0.3, from_)) {}

  double error(int cells, const std::string& match) const {
    const Scene scene = beam(cells, gravity_, match, finest);
    const Body body(scene.body);
    return error_of(motion_of(scene, body, 0.9, from_), body, frames_, body_);
  }

 private:
  double gravity_;
  std::string from_;
  Body body_;
  Frames frames_;
};

/// What a step of all particles costs, relative to others, a frame.
double cost(int cells, const std::string& match) {
  const Scene scene = beam(cells, 0, match, finest);
  const Body body(scene.body);
  return double(body.particle_count()) / frame_step(scene, body, 0.9);
}

TEST(MatchedScene, BendsAsTheBodyInSmallCells) {
  const BeamMotion motion(32.85, "");
  EXPECT_LT(motion.error(4, "bending"), 0.073);
  EXPECT_LT(motion.error(8, "both"), 0.029);
  EXPECT_LT(motion.error(16, "both"), 0.011);
  EXPECT_GT(motion.error(24, ""), 0.029) << "so cells as they are have to be smaller for an error as small";
  EXPECT_GT(cost(24, ""), 50 * cost(8, "both"));
}

TEST(MatchedScene, ServesSmallAndLargeMotionsAlike) {
  EXPECT_LT(BeamMotion(4.358, "").error(8, "both"), 0.03);
  EXPECT_LT(BeamMotion(151.1, "").error(8, "both"), 0.03);
  EXPECT_LT(BeamMotion(0, tip_load).error(8, "both"), 0.043);
}

// By velocity_verlet at 0.9 of its limit. Steps so long make vibrations faster, and larger cells make the
// second torsion slower: steps that are exact, rk4's, err by 4.7 percent, those of verlet by 4.5.
TEST(MatchedScene, TwistsAsTheBodyInSmallCells) {
  const BeamMotion motion(0, tip_turn);
  EXPECT_LT(motion.error(8, "both"), 0.042);
  EXPECT_LT(motion.error(8, "torsion"), 0.055);
  EXPECT_GT(motion.error(8, "bending"), 1) << "E alone was matched to something else";
}

/// The slowest frequency of a beam in its own cells [Hz], by no code of matching.
double slowest_frequency(const Scene& scene) {
  const Body body(scene.body);
  SpringSystem<double> system(body, scene.environment, {.threads = 1});
  Work work;
  return slowest_modes(system, system.undeformed_state(), 1, work).modes.front().omega / (2 * pi);
}

TEST(MatchedScene, HasTheFrequencyOfTheLimit) {
  const MatchedScene ready = matched(parse_scene(beam_text(8, 0), {"body.match=\"bending\""}));
  ASSERT_TRUE(ready.report);
  const double fine = slowest_frequency(beam(32, 0, "", 32)), finer = slowest_frequency(beam(64, 0, "", 64));
  const double limit = finer + (finer - fine) / 3;
  EXPECT_NEAR(slowest_frequency(ready.scene), limit, 2e-3 * limit);
  EXPECT_GT(fine, 1.005 * limit) << "the limit is another number than that of these cells";
}

TEST(MatchedScene, KeepsTheDecayOfVibrations) {
  const Scene as_is = beam(8, 0, "", 32), now = beam(8, 0, "both", 32);
  EXPECT_NEAR(now.body.damping.viscosity / now.body.shear_modulus(),
              as_is.body.damping.viscosity / as_is.body.shear_modulus(), 1e-12);
}

std::string warnings_of(const MatchedScene& ready) {
  return fmt::format("{}", fmt::join(ready.scene.warnings, " "));
}

TEST(MatchedScene, SaysThatTheThesisDampingIsLeftAlone) {
  std::string text = beam_text(8, 0);
  const std::string viscosity = "viscosity = 307.69230769230768";
  text.replace(text.find(viscosity), viscosity.size(), "thesis = true");
  const MatchedScene ready = matched(parse_scene(text, {"body.match=\"bending\"", "body.match_to=2"}));
  EXPECT_NE(warnings_of(ready).find("damping.thesis is left as it is"), std::string::npos)
      << warnings_of(ready);
}

TEST(MatchedScene, LowersPoissonsRatioWhereItCannotGrow) {
  const MatchedScene ready = matched(
      parse_scene(beam_text(8, 0), {"body.match=\"both\"", "body.match_to=2", "material.poisson=0.495"}));
  EXPECT_LT(ready.report->after.poisson, 0.49);
  EXPECT_LT(ready.report->error_of_matched(), 1e-3);
}

TEST(MatchedScene, WarnsOfAPlateThatOneNumberCannotServe) {
  std::string text = beam_text(8, 0);
  for (const auto& [from, to] : {std::pair{"[8, 2, 2]", "[8, 4, 1]"}, {"0.25, 0.25]]", "0.5, 0.125]]"}})
    text.replace(text.find(from), std::string(from).size(), to);
  const MatchedScene plate = matched(parse_scene(text, {"body.match=\"bending\"", "body.match_to=4"}));
  EXPECT_NE(warnings_of(plate).find("(bending, 6.971 Hz) is 25 % too slow"), std::string::npos)
      << warnings_of(plate);
  EXPECT_NE(warnings_of(plate).find("move the body 79 % too far"), std::string::npos) << warnings_of(plate);
  const MatchedScene beam = matched(parse_scene(beam_text(8, 0), {"body.match=\"both\"", "body.match_to=4"}));
  EXPECT_EQ(warnings_of(beam).find("bending"), std::string::npos) << warnings_of(beam);
}

TEST(MatchedScene, IsNotRunUnmatched) {
  const Scene scene = parse_scene(beam_text(8, 0), {"body.match=\"bending\""});
  EXPECT_THROW(check_solve(scene), InputError);
  EXPECT_NO_THROW(check_solve(matched(scene).scene));
}

TEST(MatchedScene, MatchesPartsAlikeInMeshes) {
  const MatchedScene ready =
      load_matched_scene(MSS_SOURCE_DIR "/experiments/scenes/mesh_bracket.toml",
                         {"body.cell_size=0.1", "body.match=\"both\"", "body.match_to=2"});
  const Scene as_is =
      load_scene(MSS_SOURCE_DIR "/experiments/scenes/mesh_bracket.toml", {"body.cell_size=0.1"});
  const ElasticConstants &foot = *ready.scene.body.elastic, &arm = *ready.scene.body.parts[0].elastic,
                         &foot_before = *as_is.body.elastic, &arm_before = *as_is.body.parts[0].elastic;
  EXPECT_NEAR(foot.young / foot_before.young, arm.young / arm_before.young, 1e-9);
  EXPECT_NEAR((1 + foot.poisson) / (1 + foot_before.poisson), (1 + arm.poisson) / (1 + arm_before.poisson),
              1e-9);
  EXPECT_LT(ready.report->error_of_matched(), 1e-3);
}

TEST(MatchedScene, TakesFreeBodies) {
  const MatchedScene bear =
      load_matched_scene(MSS_SOURCE_DIR "/experiments/scenes/mesh_bear.toml",
                         {"body.cells_across=8", "body.match=\"modes\"", "body.match_to=2"});
  ASSERT_FALSE(bear.report->vibrations.empty());
  EXPECT_LT(std::abs(bear.report->vibrations.front().mismatch), 0.03);
}

TEST(MatchedScene, RefusesWhatHasNoSuchVibrationInASentence) {
  try {
    matched(
        parse_scene("[body]\ncells = [2, 2, 2]\ncell_size = 0.5\nmatch = \"torsion\"\n"
                    "[material]\ndensity = 1000\nyoung = 1e6\npoisson = 0.3\n"
                    "[[refine]]\nbox = [[0, 0, 0], [0.5, 0.5, 0.5]]\n"));
    FAIL() << "it has cells of two sizes";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("leave [[refine]]"), std::string::npos) << error.what();
  }
}

TEST(MatchedScene, RefusesABodyWithoutVibrationsInASentence) {
  try {
    matched(
        parse_scene("[body]\ncells = [1, 1, 1]\ncell_size = 0.5\nmatch = \"bending\"\nmatch_to = 2\n"
                    "[material]\ndensity = 1000\nyoung = 1e6\npoisson = 0.3\n"
                    "[[hold]]\nbox = [[0, 0, 0], [0.5, 0.5, 0.5]]\n"));
    FAIL() << "all of it is held";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("the body has none"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace mss
