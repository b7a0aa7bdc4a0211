#pragma once

#include <vector>

#include "core/base/state.hpp"
#include "core/body/body.hpp"
#include "core/environment/environment.hpp"
#include "core/environment/plane_contact.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "core/system/plane_impulses.hpp"

namespace mss {

/// Of every vertex a third of its triangles' areas [m^2].
std::vector<double> vertex_areas(const TriangleMesh& mesh);

/// Of every vertex the mass m_s [kg] that penalties push, see SurfaceContact.
std::vector<double> vertex_masses(const TriangleMesh& mesh, const EmbeddedSurface& surface, const Body& body);

/// Planes and obstacles that touch the vertices of a mesh which the cells of a body carry, `contact_on =
/// "surface"`. What happens to a vertex is handed to the eight particles of its cell by its weights w_i, so
/// that linear and angular momentum change by what the plane gives and nothing else. All is done in the order
/// of vertices, by one thread.
///
/// Penalties are forces per mass. A vertex s of the share a_s of the surface has the mass
///   m_s = a_s min_i m_i / W_i,   W_i = sum_s a_s L_s |w_si|,   L_s = sum_i |w_si|,
/// so that sum_s m_s L_s |w_si| <= m_i. With that and Cauchy and Schwarz,
///   sum_s m_s |sum_i w_si u_i|^2 <= sum_s m_s L_s sum_i |w_si| |u_i|^2 <= sum_i m_i |u_i|^2:
/// a penalty of stiffness omega^2 per mass adds at most omega^2 to the squared frequency of any motion u, as
/// it does on particles, and PlaneContact::with_penalties() is a bound here too; so for damping.
///
/// Impulses: a vertex that the law gives the change of velocity dv gets the impulse P = dv / sum_i w_i^2 /
/// m_i, of which particle i takes w_i P, and positions move alike: the vertex then moves exactly as the law
/// says. A held coordinate takes none, as if its mass were infinite. Impulses that other vertices got in this
/// step count as if they had acted at its beginning: then none is larger than what the speed that is left
/// asks for, and none adds energy. Sweeps are repeated until no vertex is behind a plane or moves into one.
class SurfaceContact {
 public:
  /// All must outlive it but the mesh. No plane may be of the law `thesis`.
  SurfaceContact(const TriangleMesh& mesh, const Body& body, const HeldSites& held,
                 const PlaneContact& planes);

  const EmbeddedSurface& surface() const { return surface_; }
  /// m_s [kg]
  double mass(std::size_t vertex) const { return mass_[vertex]; }

  /// Adds what penalties do to particles: forces [N],
  template <class Real>
  void add_force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) const;
  /// accelerations [m/s^2], also of held coordinates;
  template <class Real>
  void add_acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) const;
  /// their energy [J].
  template <class Real>
  double potential(double t, const Field<Real>& x) const;

  /// Calls visit(vertex, T) with the 3 x 3 tangent T of every vertex that penalties press: the block of
  /// corners i and j is w_i w_j T.
  template <class Real, class Visit>
  void for_each_tangent(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                        Visit&& visit) const {
    for_each_pressed(t, x, [&](std::size_t vertex, const Vec3& at) {
      visit(vertex, planes_.tangent({at, surface_.at(vertex, v)}, t, sum, mass_[vertex]));
    });
  }
  /// Adds its blocks on the diagonal: add(site, block).
  template <class Real, class Add>
  void for_each_diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                         Add&& add) const {
    for_each_tangent(t, x, v, sum, [&](std::size_t vertex, const Eigen::Matrix3d& tangent) {
      for (int c = 0; c < 8; ++c) {
        const double weight = surface_.weights(vertex)[std::size_t(c)];
        add(surface_.site(vertex) + body_.lattice().corner(c), Eigen::Matrix3d(weight * weight * tangent));
      }
    });
  }

  /// Calls visit(penalty, place, force) for what every penalty plane does to a vertex [N].
  template <class Real, class Visit>
  void for_each_penalty_force(const State<Real>& state, Visit&& visit) const {
    for_each_pressed(state.t, state.x, [&](std::size_t s, const Vec3& at) {
      for (std::size_t p = 0; p < planes_.penalties(); ++p)
        visit(p, at, Vec3(mass_[s] * planes_.acceleration(p, {at, surface_.at(s, state.v)}, state.t)));
    });
  }

  /// Applies the collisions of a step of dt from `before` to `state`, and adds what planes give to `impulses`
  /// if there are some. False if nothing changed.
  template <class Real>
  bool collide(const State<Real>& before, double dt, State<Real>& state, PlaneImpulses* impulses) const;

  /// For every penalty plane the smallest gap of a vertex [m].
  template <class Real>
  std::vector<double> smallest_gaps(const Field<Real>& x, double t) const {
    return planes_.smallest_gaps(surface_.interpolate(x), t);
  }

 private:
  /// A vertex's step without impulses.
  struct Flight {
    Motion before, after;
  };
  template <class Real>
  Motion motion(std::size_t vertex, const State<Real>& state) const {
    return {surface_.at(vertex, state.x), surface_.at(vertex, state.v)};
  }
  template <class Real, class Visit>
  void for_each_pressed(double t, const Field<Real>& x, Visit&& visit) const {
    for (std::size_t s = 0; planes_.has_penalties() && s < surface_.size(); ++s)
      if (const Vec3 at = surface_.at(s, x); planes_.presses(at, t)) visit(s, at);
  }
  /// A change of a vertex's velocity by a plane.
  struct Push {
    std::size_t plane;
    Vec3 dv;
  };
  template <class Real>
  bool sweep(const std::vector<Flight>& flights, double dt, State<Real>& state,
             PlaneImpulses* impulses) const;
  template <class Real>
  void push(std::size_t vertex, const Vec3& dx, const Vec3& dv, State<Real>& state) const;
  void add_impulses(std::size_t vertex, const std::vector<Push>& pushes, PlaneImpulses& impulses) const;
  std::array<double, 8> yields(std::size_t vertex, int axis) const;

  const Body& body_;
  const PlaneContact& planes_;
  EmbeddedSurface surface_;
  std::vector<double> mass_;
  Field<double> inverse_mass_;  ///< of coordinates [1/kg]; 0 where held
};

}  // namespace mss
