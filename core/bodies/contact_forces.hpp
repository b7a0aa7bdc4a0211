#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/base/field.hpp"
#include "core/base/thread_team.hpp"
#include "core/bodies/contact_surface.hpp"
#include "core/bodies/touch.hpp"
#include "core/environment/environment.hpp"
#include "core/mesh/triangle_tree.hpp"

namespace mss {

class Record;

/// How bodies touch at a moment, and the worst that has happened so far.
struct ContactReport {
  std::size_t touches = 0;   ///< vertices behind triangles, once for each body
  double depth = 0;          ///< of the deepest [m]
  double energy = 0;         ///< stored in contact [J]
  double force = 0;          ///< sum of the normal forces [N]
  double depth_so_far = 0;   ///< of the deepest after any step, over the smallest cell's size
  double reach_so_far = 0;   ///< the same over what contact can follow: from 1 on it loses a vertex
  double motion_so_far = 0;  ///< the most that near bodies moved by each other in a step, over that

  /// See core/base/record.hpp.
  void remember(Record& record);
};

/// Contact between the surfaces of bodies, and of a body's with itself: a force on every vertex that is
/// behind a triangle it faces, and the opposite one on the triangle's corners (touch.hpp). Of several
/// triangles of a body a vertex may touch the nearest. Triangles that are no farther than 1.5 cells from a
/// vertex of the same body at rest do not touch it.
///
/// A vertex s with a share A_s of its surface has the stiffness
///   k = stiffness / 4 A_s min(K_s, K_t),  K_s = omega^2 min(m_s / A_s, c),  1 / K_t = sum_i w_i / K_i,
/// with its body's bound omega on frequencies, m_s as in SurfaceContact, c the least m / A that the body
/// would have if all its cells were full, and the weights w_i of the triangle's corners i in its point
/// nearest to the vertex. So all of a body of full cells is as stiff, and where its cells are nearly empty it
/// is softer. The forces of touches, normal and tangential, are below k (w_a - w_b)^2 with the weights of
/// particles w in the vertex and in the triangle's point, and (w_a - w_b)^2 <= 2 w_a^2 + 2 w_b^2: as vertices
/// they add at most stiffness / 2 omega^2 to the squared frequencies; as triangles as much, if the vertices
/// behind a triangle have its area, and twice if they have twice that: w_i^2 K_t <= w_i K_i.
///
/// What happens depends on the ends of steps, come_to(), too. A vertex begins to touch a triangle by coming
/// through it: one that was behind its plane before, beside it, as of a block that passes another, does not
/// touch when it comes nearer. And friction holds a vertex where it first touched, at its anchor, by a spring
/// of the same stiffness along the triangle, up to Coulomb's limit; where it slips the anchor follows.
/// Cundall & Strack, Geotechnique 29 (1979) 47. The limit is that of the pressure where the last step ended:
/// so within a step friction has an energy, and what implicit methods solve is symmetric.
///
/// Everything is found and added in an order that threads do not change.
class ContactForces {
 public:
  /// One for each body.
  struct Toucher {
    const Body* body;
    const TriangleMesh* mesh;  ///< nullptr: the faces of its cells
    double omega;              ///< bound on its frequencies [rad/s]
  };
  /// The bodies and the team must outlive it.
  ContactForces(const std::vector<Toucher>& bodies, const BodyContact& rules, ThreadTeam& team);

  /// Positions of the bodies' particles, one field for each body.
  template <class Real>
  using Positions = std::span<const Field<Real>* const>;
  template <class Real>
  using Fields = std::span<Field<Real>* const>;

  /// Finds the touches at positions; what follows is of these.
  template <class Real>
  void find(Positions<Real> x);

  /// Adds the forces [N].
  template <class Real>
  void add_forces(Fields<Real> forces);
  /// Adds the forces over the particles' masses [m/s^2].
  template <class Real>
  void add_accelerations(Fields<Real> accelerations);
  bool touches() const { return !contacts_.empty() || !grips_.empty(); }
  double energy() const;
  ContactReport report() const;

  /// The system has come to positions, at the end of a step. To those of the last time: nothing happens.
  template <class Real>
  void come_to(Positions<Real> x);
  /// No step has ended yet; what was worst so far remains.
  void forget();

  /// A touch for studies: the force [N] on the vertex's body at the vertex [m].
  struct Point {
    int body, other;
    Vec3 at, force;
  };
  std::vector<Point> points() const;

  /// A particle that takes part in a touch, and its weight there: positive in the vertex, negative in the
  /// triangle.
  struct Carrier {
    int body;
    std::ptrdiff_t site;
    double weight;
  };
  /// Calls visit(carriers, block) for terms of the stiffness matrix: block times the product of two carriers'
  /// weights [N/m]. They are symmetric and positive semidefinite: what turning of triangles adds is left out.
  template <class Visit>
  void for_each_stiffness(Visit&& visit) const {
    std::vector<Carrier> carriers;
    for (const Contact& contact : contacts_) {
      const Eigen::Matrix3d block = stiffness_of(contact, carriers);
      visit(std::span<const Carrier>(carriers), block);
    }
    for (std::size_t i = 0; i < grips_.size(); ++i) {
      if (!(grips_[i].held > 0)) continue;
      const Eigen::Matrix3d block = stiffness_of_grip(i, carriers);
      visit(std::span<const Carrier>(carriers), block);
    }
  }

  /// What the bound on squared frequencies is multiplied by.
  static double with_contact(const BodyContact& rules) {
    return rules.acts() ? 1 + 1.5 * rules.stiffness : 1;
  }

  /// See core/base/record.hpp.
  void remember(Record& record);

 private:
  struct Candidate {
    int vertex, triangle;  ///< of all
  };
  /// A vertex that touched a body where the last step ended, the point of a triangle to which friction holds
  /// it, and how much of an offset it can hold.
  struct Trace {
    int vertex = 0, body = 0;
    int triangle = 0;
    std::array<double, 3> anchor{};
    double limit = 0;      ///< [m]
    double stiffness = 0;  ///< k [N/m]
    void remember(Record& record);
  };
  struct Contact {
    int vertex, triangle;
    Touch touch;
    double stiffness;    ///< k [N/m]
    double softening;    ///< what k loses for what 1 / K_t gains: 0 where K_s counts [N^2/m^4]
    double pressure;     ///< over k [m]
    const Trace* trace;  ///< nullptr: none
  };
  struct Found {
    std::vector<Contact> touches;
    bool some_wait = false;  ///< which do not touch for where the step began, and may in the next
  };
  /// How friction holds a vertex until the step ends, whether it still touches or not: so what is held does
  /// not change from one moment to the next.
  struct Grip {
    double stiffness = 0;  ///< k [N/m]
    Offset offset{};       ///< from the anchor
    double held = 0;       ///< share of the offset that friction can hold
  };

  struct Plane {
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
  };

  TouchLengths lengths_of(int a, int b) const;
  TouchLengths lengths_of(const Contact& contact) const {
    return lengths_of(body_of_vertex_[std::size_t(contact.vertex)],
                      body_of_triangle_[std::size_t(contact.triangle)]);
  }
  std::array<Vec3, 3> corners(int triangle) const;
  Vec3 outwards_at(int vertex) const;
  bool may_touch(int body, int other) const { return body == other ? rules_.self : rules_.bodies; }
  bool is_far_at_rest(int vertex, int triangle) const;
  template <class Real>
  bool gather(Positions<Real> x);
  void find_candidates();
  void find_candidates(int body, int other, std::vector<Candidate>& found) const;
  void find_planes();
  void find_contacts();
  void add_contacts_of(std::size_t begin, std::size_t end, Found& found) const;
  std::optional<Contact> nearest_of(std::span<const Candidate> candidates) const;
  bool is_in_valley(const Contact& contact) const;
  bool begins(const Contact& contact) const;
  bool goes_on(const Contact& contact) const;
  void find_grips();
  Grip grip_of(const Trace& trace) const;
  void press(Contact& contact) const;
  TouchForces forces_of(const Contact& contact) const;
  std::array<double, 3> compliances(int triangle) const;
  const Trace* trace_of(const Contact& contact) const;
  Trace trace_after(const Contact& contact) const;
  const Grip* grip_at(const Contact& contact) const {
    return contact.trace ? &grips_[std::size_t(contact.trace - traces_.data())] : nullptr;
  }

  void add_to_vertices();
  void clear_vertices();
  Eigen::Matrix3d stiffness_of(const Contact& contact, std::vector<Carrier>& carriers) const;
  Eigen::Matrix3d stiffness_of_grip(std::size_t trace, std::vector<Carrier>& carriers) const;
  void set_carriers(int vertex, int triangle, const std::array<double, 3>& weights,
                    std::vector<Carrier>& carriers) const;
  void add_carriers(int vertex, double weight, std::vector<Carrier>& carriers) const;
  void watch_motion();

  BodyContact rules_;
  ThreadTeam& team_;
  std::vector<Toucher> bodies_;
  std::vector<ContactSurface> surfaces_;
  std::vector<TriangleTree> trees_;
  std::vector<int> first_vertex_, first_triangle_;  ///< by body, and one more
  std::vector<int> body_of_vertex_, body_of_triangle_;
  std::vector<std::array<int, 3>> triangles_;  ///< of vertices of all
  std::vector<double> stiffness_, area_;       ///< by vertex: K_s [N/m^3], A_s [m^2]
  double skin_ = 0;  ///< how much farther than they touch candidates are looked for [m]

  std::vector<Vec3> positions_, searched_at_, stepped_from_;  ///< by vertex; empty: never
  std::vector<Candidate> candidates_;                         ///< by vertex, then triangle
  std::vector<int> near_triangles_;                           ///< of candidates, ascending
  std::vector<Plane> planes_;                                 ///< by triangle, of those near vertices
  std::vector<Contact> contacts_;                             ///< by vertex, then body
  bool some_wait_ = false;                                    ///< see Found
  std::vector<Trace> traces_;                                 ///< by vertex, then body
  std::vector<Grip> grips_;                                   ///< one for each trace
  std::vector<Vec3> forces_;                                  ///< by vertex
  std::vector<int> pushed_;                                   ///< vertices with forces, ascending
  double depth_so_far_ = 0, reach_so_far_ = 0, motion_so_far_ = 0;
};

}  // namespace mss
