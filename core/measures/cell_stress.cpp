#include "core/measures/cell_stress.hpp"

#include <cmath>

#include "core/forces/cell_geometry.hpp"

namespace mss {

template <class Real>
CellStress cell_stress(const SolidSystem<Real>& system, const State<Real>& state) {
  CellStress stress = system.cell_virials(state.x, state.v);
  if (!stress) return stress;
  auto next = stress->begin();
  for (const auto& [body, first] : system.levels())
    body.for_each_cell([&, &body = body, &first = first](std::ptrdiff_t site) {
      const double volume =
          body.weights_at(site).fill * trilinear_volume(corners_of(body, state.x, first + site));
      *next = ((*next + next->transpose()) / (2 * volume)).eval();
      ++next;
    });
  return stress;
}

double von_mises(const Eigen::Matrix3d& stress) {
  return std::sqrt(1.5) * (stress - stress.trace() / 3 * Eigen::Matrix3d::Identity()).norm();
}

template CellStress cell_stress(const SolidSystem<float>&, const State<float>&);
template CellStress cell_stress(const SolidSystem<double>&, const State<double>&);

}  // namespace mss
