// A scene in other cells: what stays the same, and the settings that `--set` takes for it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "experiments/advise/advise.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/scene_check.hpp"

namespace mss::advise {

namespace {

/// Whether a candidate's integrator is a variant that says its number of iterations, or its solver.
bool fixes_iterations(const Candidate& c) { return c.integrator.find(':') != std::string::npos; }
bool fixes_solver(const Candidate& c) { return c.integrator.find('/') != std::string::npos; }

}  // namespace

SceneFamily::SceneFamily(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  contacts_.push_back({"as given", {}, load_scene(file, overrides)});
  const Scene& given = this->given();
  const auto refuse = [&](const char* problem) {
    throw InputError(fmt::format("{}: {}", file.string(), problem));
  };
  if (given.match) refuse("advice tries matched cells by itself; leave body.match out");
  check_model(given);
  if (is_refined(given))
    refuse("advice is about bodies with cells of one size; leave [[refine]] and body.refinement out");
  if (given.body.any_part([](const Part& part) { return part.damping.law == Damping::Law::thesis; }))
    refuse(
        "damping.thesis has no viscosity that other cells could keep; give damping.viscosity or "
        "damping.ratio");
  if (find_integrator(given.solve.integrator).stepping == Stepping::equilibrium)
    refuse(
        "solve.integrator = \"static\" finds an equilibrium, and advice is about motion; give another one");
  if (!(given.solve.duration > 0)) refuse("solve.duration = 0 leaves nothing to advise about");
  base_ = given.body.voxels.size();
  given_level_ = level_of(given);
  for (int& cells : base_) cells /= given_level_;
  coarsest_ = given.body.cell_size * given_level_;
  add_contacts(file, overrides);
}

/// Penalties shorten safe steps, and the vertices of a surface may be more than a body's particles.
void SceneFamily::add_contacts(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const std::vector<Plane> planes = given().environment.planes;
  ContactChoice choice{"impulse", {}, {}};
  for (std::size_t p = 0; p < planes.size(); ++p)
    if (planes[p].contact != ContactLaw::impulse)
      choice.settings.push_back(fmt::format("plane.{}.contact=impulse", p));
  const std::vector<Obstacle> obstacles = given().environment.obstacles;
  for (std::size_t o = 0; o < obstacles.size(); ++o)
    if (obstacles[o].contact != ContactLaw::impulse)
      choice.settings.push_back(fmt::format("obstacle.{}.contact=impulse", o));
  const bool on_surface = given().environment.contact_surface != nullptr;
  const auto add = [&] {
    std::vector<std::string> all = overrides;
    all.insert(all.end(), choice.settings.begin(), choice.settings.end());
    choice.scene = load_scene(file, all);
    contacts_.push_back(choice);
  };
  if (!choice.settings.empty()) add();
  if ((planes.empty() && obstacles.empty()) || !on_surface) return;
  choice.name = "impulse on particles";
  choice.settings.emplace_back("body.contact_on=particles");
  add();
}

bool SceneFamily::is_calibrated() const {
  return given().model == spring_model &&
         !given().body.any_part([](const Part& part) { return !part.elastic; });
}

bool SceneFamily::takes_elements() const { return is_calibrated() && given().body.fold_guard == 0; }

bool SceneFamily::has_volume_force() const {
  return given().model == spring_model && given().body.has_volume_force();
}

Candidate SceneFamily::candidate(int level) const {
  Candidate candidate{edit_of(given())};
  candidate.level = level;
  candidate.sharing = Sharing::weighted;
  if (is_calibrated()) candidate.face_share = 0.5;
  if (candidate.threads == 0) candidate.threads = 1;
  return candidate;
}

std::vector<std::string> SceneFamily::settings(const Candidate& c) const {
  std::vector<std::string> all;
  const auto set = [&](const char* key, const auto& value) {
    all.push_back(fmt::format("{}={}", key, value));
  };
  const double finer = double(c.level) / given_level_;
  all = contacts_[c.contact].settings;
  const IntegratorInfo& method = find_integrator(c.integrator);
  if (!given().voxel_file.empty()) {
    set("body.refine", c.level);
  } else if (given().mesh) {
    if (given().mesh->by_count)
      set("body.cells_across", given().mesh->longest_extent() / cell_size(c.level));
    else
      set("body.cell_size", cell_size(c.level));
    if (given().refine != 1) set("body.refine", 1);
  } else {
    set("body.cells",
        fmt::format("[{}, {}, {}]", base_[0] * c.level, base_[1] * c.level, base_[2] * c.level));
    set("body.cell_size", cell_size(c.level));
    if (given().refine != 1) set("body.refine", 1);
  }
  if (given().body.sharing == Sharing::uniform) set("body.sharing", "weighted");
  if (c.model != given().model) set("material.model", c.model);
  if (is_calibrated()) set("material.face_share", c.face_share);
  if (c.match) set("body.match", to_string(*c.match));
  if (!c.elastic)
    set("material.springs", fmt::format("{{ edge = {}, face = {}, body = {} }}", c.springs.edge / finer,
                                        c.springs.face / finer, c.springs.body / finer));
  if (!c.volume_force) {
    if (c.elastic)
      set("material.volume_force", "false");
    else
      set("material.volume", 0.0);
  }
  if (c.damping.law == Damping::Law::ratio) set("damping.ratio", c.damping.zeta * finer);
  for (std::size_t part = 0; part < given().body.parts.size(); ++part)
    if (const Damping& damping = given().body.parts[part].damping; damping.law == Damping::Law::ratio)
      set(fmt::format("part.{}.damping.ratio", part).c_str(), damping.zeta * finer);
  set("solve.integrator", c.integrator);
  if (fixes_iterations(c) && given().solve.iterations != SolveConfig{}.iterations)
    set("solve.iterations", SolveConfig{}.iterations);
  if (fixes_solver(c) && given().solve.nonlinear_solver != SolveConfig{}.nonlinear_solver)
    set("solve.nonlinear_solver", SolveConfig{}.nonlinear_solver);
  if (c.dt)
    set("solve.dt", *c.dt);
  else
    set("solve.dt", "safe");  // of adaptive methods: their own
  if (c.dt.value_or(0) > given().solve.every) set("solve.every", *c.dt);
  set("solve.precision", to_string(c.precision));
  if (given().solve.threads == 0) set("solve.threads", c.threads);
  if (method.implicit && method.stepping == Stepping::fixed) set("solve.linear_solver", c.linear_solver);
  if (method.stepping == Stepping::adaptive) set("solve.tolerance", c.tolerance);
  return all;
}

Scene SceneFamily::scene(const Candidate& candidate) const {
  Scene scene = edited(contacts_[candidate.contact].scene, candidate);
  if (fixes_iterations(candidate)) scene.solve.iterations = SolveConfig{}.iterations;
  if (fixes_solver(candidate)) scene.solve.nonlinear_solver = SolveConfig{}.nonlinear_solver;
  scene.solve.every = std::max(scene.solve.every, candidate.dt.value_or(0));  // there is a row a step at most
  if (!candidate.match) return scene;
  const Lattice key = lattice_of(candidate);
  if (!matched_.contains(key)) {
    Scene to_match = scene;
    to_match.match = FrequencyMatch{.of = *candidate.match};
    matched_[key] = matched(to_match).scene;
  }
  scene.body = matched_[key].body;
  scene.warnings = matched_[key].warnings;
  return scene;
}

SpectralBound SceneFamily::bound(const Candidate& c) {
  const Lattice key = lattice_of(c);
  if (const auto known = bounds_.find(key); known != bounds_.end()) return known->second;
  const Scene scene = this->scene(c);
  const Body body(scene.body);
  const SpectralBound bound = make_system<double>(scene.model, body, scene.environment, 1)->spectral_bound();
  return bounds_[key] = bound;
}

}  // namespace mss::advise
