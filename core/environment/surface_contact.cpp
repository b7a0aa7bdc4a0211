#include "core/environment/surface_contact.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace mss {

std::vector<double> vertex_areas(const TriangleMesh& mesh) {
  std::vector<double> shares(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    for (const int vertex : mesh.triangles[t]) shares[std::size_t(vertex)] += (b - a).cross(c - a).norm() / 6;
  }
  return shares;
}

std::vector<double> vertex_masses(const TriangleMesh& mesh, const EmbeddedSurface& surface,
                                  const Body& body) {
  const std::vector<double> shares = vertex_areas(mesh);
  std::vector<double> sums(std::size_t(body.lattice().size));  // W_i by site
  const auto for_each_corner = [&](std::size_t s, auto&& visit) {
    for (int c = 0; c < 8; ++c)
      if (const double weight = surface.weights(s)[std::size_t(c)]; weight != 0)
        visit(surface.site(s) + body.lattice().corner(c), std::abs(weight));
  };
  for (std::size_t s = 0; s < surface.size(); ++s) {
    double length = 0;
    for_each_corner(s, [&](std::ptrdiff_t, double weight) { length += weight; });
    for_each_corner(
        s, [&](std::ptrdiff_t i, double weight) { sums[std::size_t(i)] += shares[s] * length * weight; });
  }
  std::vector<double> masses(surface.size());
  for (std::size_t s = 0; s < surface.size(); ++s) {
    if (shares[s] == 0) continue;
    double least = std::numeric_limits<double>::infinity();
    for_each_corner(
        s, [&](std::ptrdiff_t i, double) { least = std::min(least, body.mass(i) / sums[std::size_t(i)]); });
    masses[s] = shares[s] * least;
  }
  return masses;
}

namespace {

Field<double> inverse_masses(const Body& body, const HeldSites& held) {
  Field<double> inverse(body.lattice().size);
  for (const std::ptrdiff_t site : body.sites())
    for (int axis = 0; axis < 3; ++axis)
      inverse.axis(axis)[site] = held.holds(site, axis) ? 0 : 1 / body.mass(site);
  return inverse;
}

}  // namespace

SurfaceContact::SurfaceContact(const TriangleMesh& mesh, const Body& body, const HeldSites& held,
                               const PlaneContact& planes)
    : body_(body),
      planes_(planes),
      surface_(mesh, body.config().voxels, body.config().cell_size, body.config().origin),
      mass_(vertex_masses(mesh, surface_, body)),
      inverse_mass_(inverse_masses(body, held)) {}

template <class Real>
void SurfaceContact::add_force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) const {
  for_each_pressed(t, x, [&](std::size_t s, const Vec3& at) {
    surface_.distribute(s, mass_[s] * planes_.acceleration({at, surface_.at(s, v)}, t), f);
  });
}

template <class Real>
void SurfaceContact::add_acceleration(double t, const Field<Real>& x, const Field<Real>& v,
                                      Field<Real>& a) const {
  for_each_pressed(t, x, [&](std::size_t s, const Vec3& at) {
    const Vec3 force = mass_[s] * planes_.acceleration({at, surface_.at(s, v)}, t);
    for (int c = 0; c < 8; ++c) {
      const std::ptrdiff_t site = surface_.site(s) + body_.lattice().corner(c);
      a.set(site, a.at(site) + surface_.weights(s)[std::size_t(c)] / body_.mass(site) * force);
    }
  });
}

template <class Real>
double SurfaceContact::potential(double t, const Field<Real>& x) const {
  double sum = 0;
  for_each_pressed(t, x, [&](std::size_t s, const Vec3& at) {
    double over_mass = 0;
    planes_.add_potential(at, t, over_mass);
    sum += mass_[s] * over_mass;
  });
  return sum;
}

template <class Real>
bool SurfaceContact::collide(const State<Real>& before, double dt, State<Real>& state,
                             PlaneImpulses* impulses) const {
  bool any = false;
  for (std::size_t s = 0; !any && s < surface_.size(); ++s)
    any = planes_.touches([&] { return surface_.at(s, before.x); }, surface_.at(s, state.x), state.t, dt);
  if (!any) return false;
  std::vector<Flight> flights;
  flights.reserve(surface_.size());
  for (std::size_t s = 0; s < surface_.size(); ++s) flights.push_back({motion(s, before), motion(s, state)});
  constexpr int most_sweeps = 32;
  any = false;
  for (int n = 0; n < most_sweeps && sweep(flights, dt, state, impulses); ++n) any = true;
  return any;
}

/// False if no vertex needed an impulse.
template <class Real>
bool SurfaceContact::sweep(const std::vector<Flight>& flights, double dt, State<Real>& state,
                           PlaneImpulses* impulses) const {
  bool any = false;
  std::vector<Push> pushes;
  for (std::size_t s = 0; s < flights.size(); ++s) {
    const Motion now = motion(s, state);
    const auto& [before, after] = flights[s];
    const auto began = [&, from = &before.x] { return *from; };
    if (!planes_.touches(began, now.x, state.t, dt)) continue;
    const bool is_pushed = now.x != after.x || now.v != after.v;
    if (is_pushed && planes_.is_free(now, state.t, dt)) continue;
    const Vec3 gained = now.v - after.v;
    const Motion start{before.x + now.x - after.x - dt * gained, before.v + gained};
    Motion corrected = now;
    pushes.clear();
    const auto give = [&](std::size_t plane, const Vec3& dv) { pushes.push_back({plane, dv}); };
    if (!planes_.collide(start, state.t, dt, corrected, give, true)) continue;
    push(s, corrected.x - now.x, corrected.v - now.v, state);
    if (impulses) add_impulses(s, pushes, *impulses);
    any = true;
  }
  return any;
}

/// By how much particles move along an axis for a unit of the vertex's motion; zero where all are held.
std::array<double, 8> SurfaceContact::yields(std::size_t vertex, int axis) const {
  const std::array<double, 8>& weights = surface_.weights(vertex);
  std::array<double, 8> yields{};  // of a unit impulse, w_i / m_i
  double of_vertex = 0;
  for (std::size_t c = 0; c < 8; ++c) {
    yields[c] = weights[c] * inverse_mass_.axis(axis)[surface_.site(vertex) + body_.lattice().corner(int(c))];
    of_vertex += weights[c] * yields[c];
  }
  if (of_vertex == 0) return {};
  for (double& yield : yields) yield /= of_vertex;
  return yields;
}

template <class Real>
void SurfaceContact::push(std::size_t vertex, const Vec3& dx, const Vec3& dv, State<Real>& state) const {
  for (int axis = 0; axis < 3; ++axis) {
    const std::array<double, 8> yield = yields(vertex, axis);
    for (int c = 0; c < 8; ++c) {
      const std::ptrdiff_t site = surface_.site(vertex) + body_.lattice().corner(c);
      state.x.axis(axis)[site] += static_cast<Real>(yield[std::size_t(c)] * dx[axis]);
      state.v.axis(axis)[site] += static_cast<Real>(yield[std::size_t(c)] * dv[axis]);
    }
  }
}

void SurfaceContact::add_impulses(std::size_t vertex, const std::vector<Push>& pushes,
                                  PlaneImpulses& impulses) const {
  const std::array<std::array<double, 8>, 3> yield{yields(vertex, 0), yields(vertex, 1), yields(vertex, 2)};
  for (const auto& [plane, dv] : pushes)
    for (std::size_t c = 0; c < 8; ++c) {
      const std::ptrdiff_t site = surface_.site(vertex) + body_.lattice().corner(int(c));
      const Vec3 moved{yield[0][c] * dv[0], yield[1][c] * dv[1], yield[2][c] * dv[2]};
      impulses.add(plane, site, body_.mass(site) * moved);
    }
}

template void SurfaceContact::add_force(double, const Field<float>&, const Field<float>&,
                                        Field<float>&) const;
template void SurfaceContact::add_force(double, const Field<double>&, const Field<double>&,
                                        Field<double>&) const;
template void SurfaceContact::add_acceleration(double, const Field<float>&, const Field<float>&,
                                               Field<float>&) const;
template void SurfaceContact::add_acceleration(double, const Field<double>&, const Field<double>&,
                                               Field<double>&) const;
template double SurfaceContact::potential(double, const Field<float>&) const;
template double SurfaceContact::potential(double, const Field<double>&) const;
template bool SurfaceContact::collide(const State<float>&, double, State<float>&, PlaneImpulses*) const;
template bool SurfaceContact::collide(const State<double>&, double, State<double>&, PlaneImpulses*) const;

}  // namespace mss
