// The states that `mss recovery` traps a cube in.
#include <fmt/format.h>

#include <Eigen/Geometry>

#include "experiments/studies/recovery/recovery.hpp"

namespace mss::studies::recovery {

namespace {

constexpr double n = recovery_cells;
constexpr double perturbation = 1e-3;  ///< of places, by which seeds of a state differ [cells]

bool is_top(double place) { return place > n - 0.5; }

Vec3 mirrored(const Vec3& p, const Vec3& u, double) { return Vec3(n - p[0], p[1], p[2]) + perturbation * u; }

Vec3 turned(const Vec3& p, const Vec3& u, double) {
  const Vec3 middle = Vec3::Constant(n / 2);
  return middle + Eigen::AngleAxisd(2, Vec3(1, 2, 3).normalized()) * (p - middle) + perturbation * u;
}

Vec3 folded_layer(const Vec3& p, const Vec3& u, double) {
  return Vec3(p[0], p[1], is_top(p[2]) ? n - 2 : p[2]) + perturbation * u;
}

/// Pushes the upper corner (3 axes), edge (2) or face (1) in along its inner diagonal.
template <int axes>
Vec3 pushed(const Vec3& p, const Vec3& u, double cells) {
  Vec3 put = p + perturbation * u;
  bool on_top = true;
  for (int a = 3 - axes; a < 3; ++a) on_top = on_top && is_top(p[a]);
  if (on_top)
    for (int a = 3 - axes; a < 3; ++a) put[a] -= cells;
  return put;
}

/// Pushes in the four particles of the top face that are on none of its edges.
Vec3 patch(const Vec3& p, const Vec3& u, double cells) {
  const bool inner = p[0] > 0.5 && p[0] < n - 0.5 && p[1] > 0.5 && p[1] < n - 0.5;
  return p + perturbation * u - (inner && is_top(p[2]) ? cells : 0) * Vec3::UnitZ();
}

Vec3 flat(const Vec3& p, const Vec3& u, double share) {
  return {p[0] + perturbation * u[0], p[1] + perturbation * u[1], share * (p[2] + u[2])};
}

Vec3 shrunk(const Vec3& p, const Vec3& u, double share) { return share * (p + u); }

Vec3 random_places(const Vec3&, const Vec3& u, double) { return n / 2 * u; }

}  // namespace

const std::vector<TrappedState>& trapped_states() {
  static const std::vector<TrappedState> all = [] {
    std::vector<TrappedState> states{{"mirrored", 0, mirrored}, {"folded layer", 0, folded_layer}};
    for (const double cells : {1.0, 1.5, 2.5}) {
      states.push_back({"corner", cells, pushed<3>});
      states.push_back({"edge", cells, pushed<2>});
      states.push_back({"face", cells, pushed<1>});
      states.push_back({"patch", cells, patch});
    }
    states.push_back({"flat", 0.01, flat});
    states.push_back({"shrunk", 0.001, shrunk});
    states.push_back({"random", 0, random_places});
    return states;
  }();
  return all;
}

const TrappedState& turned_state() {
  static const TrappedState state{"turned", 0, turned};
  return state;
}

std::string to_string(const TrappedState& state) {
  return state.amount == 0 ? state.name : fmt::format("{} {:g}", state.name, state.amount);
}

std::string_view to_string(Stiffness stiffness) {
  switch (stiffness) {
    case Stiffness::thesis_springs:
      return "thesis_springs";
    case Stiffness::calibrated_springs:
      return "calibrated_springs";
    case Stiffness::corotational_elements:
      return "corotational_elements";
  }
  return "unknown";
}

}  // namespace mss::studies::recovery
