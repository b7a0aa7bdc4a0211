#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/field.hpp"
#include "core/base/piecewise_linear.hpp"
#include "core/body/body.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// A rotation about a fixed axis that stops at a given time.
struct Turn {
  Vec3 axis = Vec3::UnitZ();
  Vec3 centre = Vec3::Zero();                              ///< any point of the axis [m]
  double rate = 0;                                         ///< [rad/s]
  double until = std::numeric_limits<double>::infinity();  ///< [s]
};

/// A boundary condition: particles whose motion is prescribed, as a function of time alone:
///   x(t) = R(t) (rest + displacement - centre) + centre + velocity t + path(t).
/// Those in a box; or, of the faces of a mesh that have all corners in the box, those within half a cell.
struct Hold {
  Box box{};
  std::array<bool, 3> axes{true, true, true};  ///< which coordinates are held
  Vec3 velocity = Vec3::Zero();                ///< [m/s]
  Vec3 displacement = Vec3::Zero();            ///< applied at once [m]
  std::optional<Turn> turn{};
  std::shared_ptr<const TriangleMesh> surface{};  ///< none: particles in the box
  PiecewiseLinear<Vec3> path{};                   ///< [m]; none: stays at 0

  /// Whether it moves anything at a time, or later.
  bool moves(double t = 0) const {
    return !velocity.isZero(0) || (turn && turn->rate != 0 && t < turn->until) || path.changes(t);
  }
};

/// A total force [N] on the particles in a box, shared in proportion to their mass, or, of a layer of
/// particles along an axis, to their mass over the length of their cells, so that a face has the same load
/// where its cells are smaller; or on the vertices in the box of a mesh that the cells carry, shared equally
/// and handed to particles by the vertices' weights.
struct Load {
  Box box{};
  Vec3 force = Vec3::Zero();
  std::shared_ptr<const TriangleMesh> surface{};  ///< none: particles
  PiecewiseLinear<double> history{};              ///< which share of the force acts when; none: all of it
};

/// A total impulse [N s] that the particles in a box get at once, each the same change of velocity. It is
/// applied by the run of a scene; to a system it is a change of state.
struct Strike {
  Box box{};
  double at = 0;  ///< [s]
  Vec3 impulse = Vec3::Zero();
};

/// How particles and a plane touch; the laws are in contact.hpp.
enum class ContactLaw {
  thesis,   ///< the thesis's Algorithm 2, at the end of steps
  impulse,  ///< restitution, Coulomb's cone and rest; inside the steps of methods that find forces at their
            ///< ends
  penalty   ///< a smooth force
};

/// A half-space that particles cannot enter.
struct Plane {
  Vec3 point = Vec3::Zero();    ///< any point of the plane [m]
  Vec3 normal = Vec3::UnitZ();  ///< towards the free side, of length 1
  ContactLaw contact = ContactLaw::impulse;
  double restitution = 0.5;  ///< speed after a collision over that before, from 0 to 1
  double friction = 0.4;     ///< Coulomb's coefficient

  /// How far a point is from the plane, negative behind it [m].
  double gap(const Vec3& x) const { return normal.dot(x - point); }
};

enum class ObstacleShape { sphere, box, capsule, cylinder, mesh };

/// A solid that particles cannot enter, which moves as a function of time alone. At rest it is its shape,
/// about its own axes, turned and moved to `centre`; from there
///   x(t) = R(t) (rest - c) + c + path(t),   c the centre of its turn.
struct Obstacle {
  ObstacleShape shape = ObstacleShape::sphere;
  double radius = 0;         ///< of a sphere, a capsule and a cylinder [m]
  double length = 0;         ///< of a capsule between the centres of its caps, of a cylinder its height [m]
  Vec3 size = Vec3::Zero();  ///< edges of a box [m]
  std::shared_ptr<const TriangleMesh> mesh{};  ///< closed, facing outward [m]
  std::string mesh_file{};                     ///< as the scene has it
  double mesh_scale = 1;                       ///< that it was read with
  Vec3 centre = Vec3::Zero();                  ///< of a mesh, where its origin is [m]
  Vec3 axis = Vec3::UnitZ();  ///< of a capsule and a cylinder; others are rotated about it, by `degrees`
  double degrees = 0;
  PiecewiseLinear<Vec3> path{};  ///< [m]; none: stays at 0
  std::optional<Turn> turn{};
  ContactLaw contact = ContactLaw::impulse;
  double restitution = 0.5;  ///< as a plane's
  double friction = 0.4;

  /// Whether it moves at a time, or later.
  bool moves(double t = 0) const { return (turn && turn->rate != 0 && t < turn->until) || path.changes(t); }
};

/// Which surfaces of bodies touch, by a smooth force, see core/bodies/README.md.
struct BodyContact {
  bool bodies = false;    ///< those of different bodies
  bool self = false;      ///< parts of one body's
  double friction = 0.4;  ///< Coulomb's coefficient
  double stiffness = 1;   ///< of contact over that of the bodies' cells

  bool acts() const { return bodies || self; }
};

/// External influences on a body.
struct Environment {
  Vec3 gravity = Vec3::Zero();  ///< [m/s^2]
  std::vector<Hold> holds{};
  std::vector<Load> loads{};
  std::vector<Strike> strikes{};
  std::vector<Plane> planes{};
  std::vector<Obstacle> obstacles{};
  /// The mesh, carried by the body's cells, whose vertices planes and obstacles touch; none: they touch
  /// particles.
  std::shared_ptr<const TriangleMesh> contact_surface{};
  BodyContact contact{};
};

/// Position and velocity that a boundary condition prescribes at time t for a particle resting at `rest`.
struct Prescribed {
  Vec3 position;
  Vec3 velocity;
};
Prescribed prescribed_motion(const Hold& hold, const Vec3& rest, double t);

/// The acceleration of that motion [m/s^2]: of a turn, towards its axis.
Vec3 prescribed_acceleration(const Hold& hold, const Vec3& rest, double t);

/// Sites that a boundary condition is about, ascending.
std::vector<std::ptrdiff_t> sites_of(const Hold& hold, const Body& body);

/// The boundary conditions of an environment resolved to sites, sorted, so that a sweep can apply them plane
/// by plane. Where they overlap, the later one wins for the axes it names.
class HeldSites {
 public:
  HeldSites(const Body& body, const std::vector<Hold>& holds)
      : HeldSites(std::vector<Level>{{body}}, holds) {}
  HeldSites(const std::vector<Level>& levels, const std::vector<Hold>& holds);

  bool empty() const { return entries_.empty(); }

  /// Writes prescribed positions and velocities at time t to the held coordinates of sites in [first, last).
  template <class Real>
  void apply(double t, std::ptrdiff_t first, std::ptrdiff_t last, Field<Real>& x, Field<Real>& v) const;

  /// True if boundary conditions move a site in [first, last) at time t, or will.
  bool move(double t, std::ptrdiff_t first, std::ptrdiff_t last) const;

  /// Sites that have a held coordinate, ascending.
  std::vector<std::ptrdiff_t> sites() const;

  /// True if a coordinate of a site is held.
  bool holds(std::ptrdiff_t site, int axis) const;

  /// 1 along axes that nothing holds, 0 along others.
  Vec3 free_axes(std::ptrdiff_t site) const {
    return {holds(site, 0) ? 0.0 : 1.0, holds(site, 1) ? 0.0 : 1.0, holds(site, 2) ? 0.0 : 1.0};
  }

  /// Calls visit(site, axis, hold, acceleration) for every held coordinate, with the index of the hold that
  /// it obeys and the acceleration that this prescribes at time t [m/s^2], ascending by site.
  template <class Visit>
  void for_each(double t, Visit&& visit) const {
    for (std::size_t e = 0; e < entries_.size(); ++e) {
      const auto& [site, hold, rest, axes] = entries_[e];
      const Vec3 acceleration = prescribed_acceleration(holds_[hold], rest, t);
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (axes[axis] && !is_overruled(e, axis)) visit(site, int(axis), hold, acceleration[int(axis)]);
    }
  }

  /// Zeroes the held coordinates of a field (an acceleration, a search direction).
  template <class Real>
  void clear(Field<Real>& field) const;

 private:
  struct Entry {
    std::ptrdiff_t site;
    std::size_t hold;
    Vec3 rest;
    std::array<bool, 3> axes;
  };
  /// Whether a later hold has that coordinate.
  bool is_overruled(std::size_t entry, std::size_t axis) const {
    for (std::size_t e = entry + 1; e < entries_.size() && entries_[e].site == entries_[entry].site; ++e)
      if (entries_[e].axes[axis]) return true;
    return false;
  }

  std::vector<Hold> holds_;
  std::vector<Entry> entries_;  ///< ascending by site
};

/// The loads of an environment resolved to sites: forces on a few particles that depend on time alone.
class LoadedSites {
 public:
  LoadedSites(const Body& body, const std::vector<Load>& loads)
      : LoadedSites(std::vector<Level>{{body}}, loads) {}
  /// With more than one level, for loads on particles alone.
  LoadedSites(const std::vector<Level>& levels, const std::vector<Load>& loads);

  bool empty() const { return entries_.empty(); }

  /// Sites that have a load at some time, ascending.
  std::vector<std::ptrdiff_t> sites() const;
  /// True if a load changes at time t, or later.
  bool change(double t) const;

  /// Adds the loads at time t on sites in [first, last) to forces [N] stored from site `first` on, one array
  /// per axis.
  template <class Real>
  void add(double t, std::ptrdiff_t first, std::ptrdiff_t last, const std::array<Real*, 3>& forces) const;

  /// Adds the potential -sum F.x of the loads at time t and positions x to a sum [J].
  template <class Real>
  void add_potential(double t, const Field<Real>& x, double& sum) const;

 private:
  struct Entry {
    std::ptrdiff_t site;
    std::size_t load;
    Vec3 force;
  };
  void add_on_particles(const std::vector<Level>& levels, std::size_t load);
  void add_on_surface(const Body& body, std::size_t load);
  Vec3 force_at(double t, const Entry& entry) const {
    const PiecewiseLinear<double>& history = loads_[entry.load].history;
    return history.empty() ? entry.force : history.at(t) * entry.force;
  }

  std::vector<Load> loads_;
  std::vector<Entry> entries_;  ///< ascending by site
};

}  // namespace mss
