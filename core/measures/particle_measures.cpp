#include "core/measures/particle_measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/forces/cell_geometry.hpp"
#include "core/forces/spring_law.hpp"
#include "core/measures/measures.hpp"

namespace mss {

namespace {

/// Calls visit(cell, corners, c) for every cell that has the particle at a site as its corner c.
template <class Visit>
void for_each_cell_at(const Level& level, const Field<double>& x, std::ptrdiff_t site, Visit&& visit) {
  for (int c = 0; c < 8; ++c) {
    const std::ptrdiff_t cell = site - level.body.lattice().corner(c);
    if (cell >= 0 && level.body.has_cell(cell)) visit(cell, corners_of(level.body, x, level.first + cell), c);
  }
}

}  // namespace

double stretch_at(const Level& level, const Field<double>& x, std::ptrdiff_t site) {
  const Body& body = level.body;
  const Lattice& lattice = body.lattice();
  double largest = 0;
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    const auto [a, b, kind] = spring_slots[s];
    for (const int end : {a, b}) {
      const std::ptrdiff_t owner = site - lattice.corner(end);
      if (owner < 0 || body.kinds().stiffness(body.kind(owner), s) == 0) continue;
      const double length =
          (x.at(level.first + owner + lattice.corner(b)) - x.at(level.first + owner + lattice.corner(a)))
              .norm();
      largest = std::max(largest, std::abs(spring_strain(length, body.rest_length(kind))));
    }
  }
  return largest;
}

double volume_ratio_at(const Level& level, const Field<double>& x, std::ptrdiff_t site) {
  if (!level.body.config().is_solid()) return 1;
  double volume = 0, filled = 0;
  for_each_cell_at(level, x, site, [&](std::ptrdiff_t cell, const std::array<Vec3, 8>& corners, int) {
    const double fill = level.body.weights_at(cell).fill;
    volume += fill * trilinear_volume(corners);
    filled += fill;
  });
  return volume / (filled * level.body.cell_volume());
}

double jacobian_at(const Level& level, const Field<double>& x, std::ptrdiff_t site) {
  if (!level.body.config().is_solid()) return 1;
  double smallest = std::numeric_limits<double>::infinity();
  for_each_cell_at(level, x, site, [&](std::ptrdiff_t, const std::array<Vec3, 8>& corners, int c) {
    smallest = std::min(smallest, corner_volume(corners, c));
  });
  return smallest / level.body.cell_volume();
}

}  // namespace mss
