#include "core/springs/discrete_gradient.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/base/error.hpp"
#include "core/forces/cell_geometry.hpp"
#include "core/forces/spring_law.hpp"

namespace mss {

namespace {

template <class Real>
void add(Field<Real>& field, std::ptrdiff_t site, const Vec3& value) {
  for (int axis = 0; axis < 3; ++axis) field.axis(axis)[site] += static_cast<Real>(value[axis]);
}

/// The change of the volume force by the mean edges, for k_vol / V_rest = 1.
Eigen::Matrix3d volume_correction(const Eigen::Matrix3d& edges0, const Eigen::Matrix3d& edges1, double rest) {
  const Eigen::Matrix3d middle = (edges0 + edges1) / 2, slopes = volume_slopes(middle);
  const double mean = (volume_of(edges0) + volume_of(edges1)) / 2;
  return (volume_of(middle) - rest) * slopes -
         (mean - rest) * (volume_slopes(edges0) + 4 * slopes + volume_slopes(edges1)) / 6;
}

}  // namespace

template <class Real>
DiscreteGradient<Real>& discrete_gradient_of(System<Real>& system) {
  if (DiscreteGradient<Real>* gradient = system.discrete_gradient()) return *gradient;
  throw InputError(
      "this model has no discrete gradient (forces whose work over a step is exactly the energy lost), which "
      "energy_momentum needs; choose the model \"springs\", or another method");
}

template <class Real>
void SpringDiscreteGradient<Real>::correct(const Field<Real>& x0, const Field<Real>& x1, Field<Real>& f) {
  correct_springs(x0, x1, f);
  if (body_.config().has_volume_force()) correct_volumes(x0, x1, f);
}

template <class Real>
void SpringDiscreteGradient<Real>::correct_springs(const Field<Real>& x0, const Field<Real>& x1,
                                                   Field<Real>& f) const {
  constexpr double shortest = 1e-15;  // as in the sweep, where d = 0 must give no force
  body_.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double k, double) {
    const Vec3 d0 = x0.at(b) - x0.at(a), d1 = x1.at(b) - x1.at(a), middle = (d0 + d1) / 2;
    const double length = std::max(middle.norm(), shortest);
    const Vec3 pull = discrete_gradient_correction(k, body_.rest_length(slot.kind), length, d0.norm(),
                                                   d1.norm(), shortest) *
                      middle;
    add(f, a, pull);
    add(f, b, -pull);
  });
}

template <class Real>
void SpringDiscreteGradient<Real>::correct_volumes(const Field<Real>& x0, const Field<Real>& x1,
                                                   Field<Real>& f) const {
  const double rest = body_.cell_volume();
  body_.for_each_cell([&](std::ptrdiff_t site) {
    const Eigen::Matrix3d by_edges = body_.weights_at(site).volume * body_.kinds().interior_volume() /
                                     (4 * rest) *
                                     volume_correction(mean_edges(corners_of(body_, x0, site)),
                                                       mean_edges(corners_of(body_, x1, site)), rest);
    for (int c = 0; c < 8; ++c) add(f, site + body_.lattice().corner(c), by_edges * corner_sides(c));
  });
}

template DiscreteGradient<float>& discrete_gradient_of(System<float>&);
template DiscreteGradient<double>& discrete_gradient_of(System<double>&);
template class SpringDiscreteGradient<float>;
template class SpringDiscreteGradient<double>;

}  // namespace mss
