#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "core/environment/environment.hpp"

namespace mss::studies::refine {

/// A static problem of small deformations whose solution is wanted in one number: the mean displacement of
/// the particles in a box.
struct Problem {
  std::string name{};
  std::string description{};
  Vec3 size = Vec3::Ones();                   ///< of the box around it [m]
  std::function<bool(const Vec3&)> filled{};  ///< whether there is a cell around a point; empty: everywhere
  Environment environment{};
  Box goal{};
  Vec3 direction = Vec3::UnitZ();  ///< of length 1
  bool at_the_load = true;         ///< the goal is the displacement under the only load
};

/// Total force [N]; responses are linear, so any does.
inline constexpr double total_load = 1;

/// Cantilever of 4 x 1 x 1 m, clamped at x = 0, sheared at its tip.
Problem beam();
/// L of 3 x 1 x 3 m, its two arms 1 m thick: clamped on top, loaded down at its end.
Problem bracket();
/// Block of 4 x 1 x 1 m on a floor it is glued to, loaded down at one end; the goal is at the other, where
/// hardly anything of the load arrives.
Problem far_goal();
std::vector<Problem> problems();

/// The body in n cells a metre, of a material calibrated with face share t.
BodyConfig in_cells(const Problem& problem, int n, const ElasticConstants& material, double face_share);

}  // namespace mss::studies::refine
