// A scene in other cells: what stays the same, and what `--set` would have to say for it.
#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "experiments/advise/advise.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::advise {

SceneFamily::SceneFamily(std::filesystem::path file, std::vector<std::string> overrides)
    : file_(std::move(file)), overrides_(std::move(overrides)), asked_(load_scene(file_, overrides_)) {
  const auto refuse = [&](const char* problem) {
    throw InputError(fmt::format("{}: {}", file_.string(), problem));
  };
  check_model(asked_);
  if (asked_.body.damping.law == Damping::Law::thesis)
    refuse("damping.thesis has no viscosity that other cells could keep; give damping.ratio");
  if (find_integrator(asked_.solve.integrator).stepping == Stepping::equilibrium)
    refuse("solve.integrator = \"static\" is for rest, and advice for motion; give another one");
  if (!(asked_.solve.duration > 0)) refuse("solve.duration = 0 leaves nothing to advise about");
  const Json body = Json::parse(asked_.resolved)["body"];
  from_voxels_ = body.contains("voxels");
  refined_ = body.value("refine", 1) != 1;
  base_ = asked_.body.voxels.size();
  asked_level_ = from_voxels_ ? body["refine"].get<int>() : std::gcd(base_[0], std::gcd(base_[1], base_[2]));
  for (int& cells : base_) cells /= asked_level_;
  coarsest_ = asked_.body.cell_size * asked_level_;
}

bool SceneFamily::is_calibrated() const {
  return asked_.body.elastic.has_value() && asked_.model == spring_model;
}

bool SceneFamily::has_volume_force() const {
  return asked_.model == spring_model && asked_.body.springs.volume != 0;
}

std::vector<std::string> SceneFamily::settings(const Candidate& c) const {
  std::vector<std::string> all;
  const auto set = [&](const char* key, const auto& value) {
    all.push_back(fmt::format("{}={}", key, value));
  };
  const double finer = double(c.level) / asked_level_;
  if (from_voxels_) {
    set("body.refine", c.level);
  } else {
    set("body.cells",
        fmt::format("[{}, {}, {}]", base_[0] * c.level, base_[1] * c.level, base_[2] * c.level));
    set("body.cell_size", cell_size(c.level));
    if (refined_) set("body.refine", 1);
  }
  if (asked_.body.sharing == Sharing::uniform) set("body.sharing", "weighted");
  if (is_calibrated()) set("material.face_share", c.face_share);
  if (!asked_.body.elastic) {
    const SpringConstants& k = asked_.body.springs;
    set("material.springs",
        fmt::format("{{ edge = {}, face = {}, body = {} }}", k.edge / finer, k.face / finer, k.body / finer));
  }
  if (!c.volume_force) {
    if (asked_.body.elastic)
      set("material.volume_force", "false");
    else
      set("material.volume", 0.0);
  }
  if (asked_.body.damping.law == Damping::Law::ratio) set("damping.ratio", asked_.body.damping.zeta * finer);
  set("solve.integrator", c.integrator);
  if (c.dt > 0)
    set("solve.dt", c.dt);
  else
    set("solve.dt", "safe");  // of adaptive methods: their own
  set("solve.precision", c.precision == Precision::single ? "single" : "double");
  if (asked_.solve.threads == 0) set("solve.threads", c.threads);
  if (!c.linear_solver.empty()) set("solve.linear_solver", c.linear_solver);
  if (c.tolerance > 0) set("solve.tolerance", c.tolerance);
  return all;
}

Scene SceneFamily::scene(const Candidate& candidate) const {
  std::vector<std::string> all = overrides_;
  for (std::string& setting : settings(candidate)) all.push_back(std::move(setting));
  return load_scene(file_, all);
}

SpectralBound SceneFamily::bound(const Candidate& c) {
  const std::tuple key(c.level, c.face_share, c.volume_force);
  if (const auto known = bounds_.find(key); known != bounds_.end()) return known->second;
  Candidate lattice{
      .level = c.level, .face_share = c.face_share, .volume_force = c.volume_force, .integrator = "verlet"};
  const Scene scene = this->scene(lattice);
  const Body body(scene.body);
  const SpectralBound bound = make_system<double>(scene.model, body, scene.environment, 1)->spectral_bound();
  return bounds_[key] = bound;
}

}  // namespace mss::advise
