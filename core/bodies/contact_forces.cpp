#include "core/bodies/contact_forces.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/base/record.hpp"

namespace mss {

namespace {

/// Lengths of the law in cells.
constexpr double reach_share = 0.5, layer_share = 0.002, rim_share_of_cell = 0.05, skin_share = 0.25;
/// Parts of a body no farther apart at rest are neighbours, in cells.
constexpr double neighbours_share = 1.5;

bool overlap(const Box& a, const Box& b, double distance) {
  return (a.lower - b.upper).maxCoeff() <= distance && (b.lower - a.upper).maxCoeff() <= distance;
}

/// Zero of a flat triangle: nothing is behind it.
Vec3 normal_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 area = (b - a).cross(c - a);
  const double size = area.norm();
  return size > 0 ? Vec3(area / size) : Vec3(Vec3::Zero());
}

bool contains(const Box& box, const Vec3& x, double distance) {
  return (box.lower - x).maxCoeff() <= distance && (x - box.upper).maxCoeff() <= distance;
}

}  // namespace

ContactForces::ContactForces(const std::vector<Toucher>& bodies, const BodyContact& rules, ThreadTeam& team)
    : rules_(rules), team_(team), bodies_(bodies), first_vertex_{0}, first_triangle_{0} {
  skin_ = std::numeric_limits<double>::infinity();
  for (const auto& [body, mesh, omega] : bodies_) {
    const ContactSurface& surface = surfaces_.emplace_back(*body, mesh);
    trees_.emplace_back(surface.mesh());
    for (const auto& [a, b, c] : surface.mesh().triangles)
      triangles_.push_back({a + first_vertex_.back(), b + first_vertex_.back(), c + first_vertex_.back()});
    for (std::size_t v = 0; v < surface.size(); ++v) {
      stiffness_.push_back(omega * omega * surface.mass_per_area(v));
      area_.push_back(surface.area(v));
    }
    const int number = int(surfaces_.size()) - 1;
    body_of_vertex_.resize(body_of_vertex_.size() + surface.size(), number);
    body_of_triangle_.resize(triangles_.size(), number);
    first_vertex_.push_back(int(body_of_vertex_.size()));
    first_triangle_.push_back(int(triangles_.size()));
    skin_ = std::min(skin_, skin_share * body->config().cell_size);
  }
  forces_.assign(body_of_vertex_.size(), Vec3::Zero());
  planes_.resize(triangles_.size());
}

TouchLengths ContactForces::lengths_of(int a, int b) const {
  const double cell = std::min(bodies_[std::size_t(a)].body->config().cell_size,
                               bodies_[std::size_t(b)].body->config().cell_size);
  return {reach_share * cell, layer_share * cell, rim_share_of_cell * cell};
}

std::array<Vec3, 3> ContactForces::corners(int triangle) const {
  const auto& [a, b, c] = triangles_[std::size_t(triangle)];
  return {positions_[std::size_t(a)], positions_[std::size_t(b)], positions_[std::size_t(c)]};
}

/// The sum of its triangles' areas as vectors.
Vec3 ContactForces::outwards_at(int vertex) const {
  const auto body = std::size_t(body_of_vertex_[std::size_t(vertex)]);
  Vec3 sum = Vec3::Zero();
  for (const int triangle : surfaces_[body].triangles_at(std::size_t(vertex - first_vertex_[body]))) {
    const auto [a, b, c] = corners(first_triangle_[body] + triangle);
    sum += (b - a).cross(c - a);
  }
  return sum.stableNormalized();
}

bool ContactForces::is_far_at_rest(int vertex, int triangle) const {
  const auto body = std::size_t(body_of_vertex_[std::size_t(vertex)]);
  const TriangleMesh& rest = surfaces_[body].mesh();
  const Vec3& x = rest.vertices[std::size_t(vertex - first_vertex_[body])];
  const Vec3 nearest = nearest_point(x, rest.corners(std::size_t(triangle - first_triangle_[body]))).at;
  return (nearest - x).norm() > neighbours_share * bodies_[body].body->config().cell_size;
}

/// False if nothing has moved.
template <class Real>
bool ContactForces::gather(Positions<Real> x) {
  std::vector<Vec3> at(body_of_vertex_.size());
  constexpr std::ptrdiff_t portion = 512;
  const auto count = std::ptrdiff_t(at.size());
  team_.for_each((count + portion - 1) / portion, [&](std::ptrdiff_t p) {
    for (std::ptrdiff_t v = p * portion; v < std::min(count, (p + 1) * portion); ++v) {
      const auto body = std::size_t(body_of_vertex_[std::size_t(v)]);
      at[std::size_t(v)] = surfaces_[body].at(std::size_t(v - first_vertex_[body]), *x[body]);
    }
  });
  const bool same = at == positions_;
  positions_ = std::move(at);
  return !same;
}

template <class Real>
void ContactForces::find(Positions<Real> x) {
  if (!gather(x)) return;
  double moved = searched_at_.empty() ? std::numeric_limits<double>::infinity() : 0;
  for (std::size_t v = 0; v < searched_at_.size(); ++v)
    moved = std::max(moved, (positions_[v] - searched_at_[v]).squaredNorm());
  if (!(std::sqrt(moved) <= skin_ / 2)) find_candidates();
  find_contacts();
}

void ContactForces::find_candidates() {
  searched_at_ = positions_;
  candidates_.clear();
  const auto count = std::ptrdiff_t(surfaces_.size());
  team_.for_each(count, [&](std::ptrdiff_t i) {
    const auto begin = positions_.begin() + first_vertex_[std::size_t(i)],
               end = positions_.begin() + first_vertex_[std::size_t(i) + 1];
    trees_[std::size_t(i)].fit(std::vector<Vec3>(begin, end));
  });
  std::vector<std::vector<Candidate>> of_body(surfaces_.size());
  team_.for_each(count, [&](std::ptrdiff_t i) {
    for (int other = 0; other < int(count); ++other)
      if (may_touch(int(i), other)) find_candidates(int(i), other, of_body[std::size_t(i)]);
    std::sort(of_body[std::size_t(i)].begin(), of_body[std::size_t(i)].end(),
              [](const Candidate& a, const Candidate& b) {
                return std::tie(a.vertex, a.triangle) < std::tie(b.vertex, b.triangle);
              });
  });
  for (const std::vector<Candidate>& found : of_body)
    candidates_.insert(candidates_.end(), found.begin(), found.end());
  std::vector<bool> is_near(triangles_.size());
  for (const Candidate& candidate : candidates_) is_near[std::size_t(candidate.triangle)] = true;
  near_triangles_.clear();
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    if (is_near[t]) near_triangles_.push_back(int(t));
}

/// Vertices of a body near triangles of another, or of the same.
void ContactForces::find_candidates(int body, int other, std::vector<Candidate>& found) const {
  const TriangleTree& tree = trees_[std::size_t(other)];
  const double distance = lengths_of(body, other).reach + skin_;
  if (!overlap(trees_[std::size_t(body)].bounds(), tree.bounds(), distance)) return;
  for (int v = first_vertex_[std::size_t(body)]; v < first_vertex_[std::size_t(body) + 1]; ++v) {
    const Vec3& x = positions_[std::size_t(v)];
    if (!contains(tree.bounds(), x, distance)) continue;
    tree.for_each_near(x, distance, [&](std::size_t t) {
      const int triangle = first_triangle_[std::size_t(other)] + int(t);
      if (body != other || is_far_at_rest(v, triangle)) found.push_back({v, triangle});
    });
  }
}

/// Of the triangles that vertices are near.
void ContactForces::find_planes() {
  constexpr std::ptrdiff_t portion = 256;
  const auto count = std::ptrdiff_t(near_triangles_.size());
  team_.for_each((count + portion - 1) / portion, [&](std::ptrdiff_t p) {
    for (std::ptrdiff_t i = p * portion; i < std::min(count, (p + 1) * portion); ++i) {
      const int triangle = near_triangles_[std::size_t(i)];
      const auto [a, b, c] = corners(triangle);
      planes_[std::size_t(triangle)] = {a, normal_of(a, b, c)};
    }
  });
}

/// In portions of candidates that begin with a vertex's first.
void ContactForces::find_contacts() {
  find_planes();
  constexpr std::size_t portion = 256;
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < candidates_.size(); ++i)
    if ((begins.empty() || i - begins.back() >= portion) &&
        (i == 0 || candidates_[i].vertex != candidates_[i - 1].vertex))
      begins.push_back(i);
  begins.push_back(candidates_.size());
  std::vector<Found> found(begins.size() - 1);
  team_.for_each(std::ptrdiff_t(found.size()), [&](std::ptrdiff_t p) {
    add_contacts_of(begins[std::size_t(p)], begins[std::size_t(p) + 1], found[std::size_t(p)]);
  });
  contacts_.clear();
  some_wait_ = false;
  for (const Found& part : found) {
    contacts_.insert(contacts_.end(), part.touches.begin(), part.touches.end());
    some_wait_ |= part.some_wait;
  }
  find_grips();
}

/// Candidates of a vertex and a body follow each other: the nearest of them counts.
void ContactForces::add_contacts_of(std::size_t begin, std::size_t end, Found& found) const {
  const auto belong = [&](const Candidate& a, const Candidate& b) {
    return a.vertex == b.vertex &&
           body_of_triangle_[std::size_t(a.triangle)] == body_of_triangle_[std::size_t(b.triangle)];
  };
  for (std::size_t i = begin; i < end;) {
    std::size_t next = i + 1;
    while (next < end && belong(candidates_[i], candidates_[next])) ++next;
    std::optional<Contact> contact = nearest_of(std::span(candidates_).subspan(i, next - i));
    i = next;
    if (!contact) continue;
    if (is_in_valley(*contact)) round_off(contact->touch, corners(contact->triangle));
    contact->trace = trace_of(*contact);
    if (!contact->trace && !is_within_rim(contact->touch, lengths_of(*contact))) continue;
    if (contact->trace ? goes_on(*contact) : begins(*contact)) {
      press(*contact);
      found.touches.push_back(*contact);
    } else {
      found.some_wait = true;
    }
  }
}

/// Of the triangles that it is behind, unless it is nearer to one that it is in front of. Most vertices are
/// in front of all planes, which is quickly seen.
std::optional<ContactForces::Contact> ContactForces::nearest_of(std::span<const Candidate> candidates) const {
  constexpr double rounding = 1e-6;
  const int vertex = candidates[0].vertex, body = body_of_vertex_[std::size_t(vertex)],
            other = body_of_triangle_[std::size_t(candidates[0].triangle)];
  const TouchLengths lengths = lengths_of(body, other);
  const Vec3& at = positions_[std::size_t(vertex)];
  std::optional<Vec3> outwards;
  std::optional<Contact> nearest;
  double farthest = lengths.reach;
  for (const bool is_behind : {true, false}) {
    for (const Candidate& candidate : candidates) {
      const Plane& plane = planes_[std::size_t(candidate.triangle)];
      const double depth = -plane.normal.dot(at - plane.point);
      if ((depth > 0) != is_behind || !(std::abs(depth) <= farthest)) continue;
      if (!outwards) outwards = outwards_at(vertex);
      if (!faces(plane.normal, *outwards)) continue;
      const std::optional<Touch> now = touch(at, *outwards, corners(candidate.triangle), lengths);
      if (!now || (nearest && !is_nearer(*now, nearest->touch))) continue;
      if (!is_behind) return std::nullopt;
      farthest = (1 + rounding) * now->from_nearest.norm();
      nearest = {vertex, candidate.triangle, *now, 0, 0, 0, nullptr};
    }
    if (!nearest) return std::nullopt;
  }
  return nearest;
}

/// Whether it is behind all triangles of an edge or a corner, and faces them: elsewhere that is a rim.
bool ContactForces::is_in_valley(const Contact& contact) const {
  const Touch& now = contact.touch;
  if (!(now.depth > 0) || !(now.beside > 0)) return false;
  std::array<int, 2> ends{-1, -1};
  for (std::size_t i = 0, count = 0; i < 3; ++i) {
    if (!(now.nearest[i] > 0)) continue;
    if (count == 2) return false;
    ends[count++] = triangles_[std::size_t(contact.triangle)][i];
  }
  if (ends[1] < 0) ends[1] = ends[0];
  const int touching = body_of_vertex_[std::size_t(contact.vertex)];
  const auto body = std::size_t(body_of_triangle_[std::size_t(contact.triangle)]);
  const TouchLengths lengths = lengths_of(touching, int(body));
  if (!(now.from_nearest.norm() < lengths.reach)) return false;
  const Vec3 outwards = outwards_at(contact.vertex);
  const auto is_behind = [&](int triangle) {
    const std::optional<Touch> other =
        touch(positions_[std::size_t(contact.vertex)], outwards, corners(triangle), lengths);
    return other && other->depth > 0;
  };
  for (const int around : surfaces_[body].triangles_at(std::size_t(ends[0] - first_vertex_[body]))) {
    const int triangle = first_triangle_[body] + around;
    const std::array<int, 3>& of = triangles_[std::size_t(triangle)];
    if (std::find(of.begin(), of.end(), ends[1]) != of.end() && !is_behind(triangle)) return false;
  }
  return true;
}

const ContactForces::Trace* ContactForces::trace_of(const Contact& contact) const {
  const int vertex = contact.vertex, body = body_of_triangle_[std::size_t(contact.triangle)];
  const auto found = std::lower_bound(
      traces_.begin(), traces_.end(), std::tie(vertex, body),
      [](const Trace& trace, const auto& key) { return std::tie(trace.vertex, trace.body) < key; });
  return found != traces_.end() && found->vertex == vertex && found->body == body ? &*found : nullptr;
}

/// It was not behind the triangle's plane where the step began.
bool ContactForces::begins(const Contact& contact) const {
  if (stepped_from_.empty()) return true;
  const auto& [a, b, c] = triangles_[std::size_t(contact.triangle)];
  const Vec3& corner = stepped_from_[std::size_t(a)];
  const Vec3 area = (stepped_from_[std::size_t(b)] - corner).cross(stepped_from_[std::size_t(c)] - corner);
  return !(area.dot(corner - stepped_from_[std::size_t(contact.vertex)]) >
           lengths_of(contact).layer * area.norm());
}

/// Not from a triangle that has let it go to another around a corner, which it is deeper behind.
bool ContactForces::goes_on(const Contact& contact) const {
  constexpr double around_corner = 0.7;  // cosine of the angle between normals
  const int before = contact.trace->triangle;
  if (before == contact.triangle) return true;
  const Vec3& at = positions_[std::size_t(contact.vertex)];
  const auto [a, b, c] = corners(before);
  const Vec3 normal = normal_of(a, b, c);
  const TouchLengths lengths = lengths_of(contact);
  return normal.dot(planes_[std::size_t(contact.triangle)].normal) > around_corner ||
         contact.touch.depth <= -normal.dot(at - a) + lengths.layer ||
         touch(at, outwards_at(contact.vertex), {a, b, c}, lengths);
}

/// 1 / K of its corners.
std::array<double, 3> ContactForces::compliances(int triangle) const {
  std::array<double, 3> of{};
  for (std::size_t i = 0; i < 3; ++i)
    of[i] = 1 / stiffness_[std::size_t(triangles_[std::size_t(triangle)][i])];
  return of;
}

/// How stiffly, and how much.
void ContactForces::press(Contact& contact) const {
  const auto vertex = std::size_t(contact.vertex);
  const std::array<double, 3> corners = compliances(contact.triangle), &weights = contact.touch.nearest;
  const double own = stiffness_[vertex], share = rules_.stiffness / 4 * area_[vertex];
  const bool is_even = corners[0] == corners[1] && corners[1] == corners[2];
  const double at_nearest =
      1 /
      (is_even ? corners[0] : weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2]);
  contact.stiffness = share * std::min(own, at_nearest);
  contact.softening = is_even || own <= at_nearest ? 0 : share * at_nearest * at_nearest;
  if (contact.trace) contact.touch.growth = most_growth;
  contact.pressure = touch_pressure(contact.touch, lengths_of(contact));
}

void ContactForces::find_grips() {
  grips_.resize(traces_.size());
  constexpr std::ptrdiff_t portion = 256;
  const auto count = std::ptrdiff_t(traces_.size());
  team_.for_each((count + portion - 1) / portion, [&](std::ptrdiff_t p) {
    for (std::ptrdiff_t i = p * portion; i < std::min(count, (p + 1) * portion); ++i)
      grips_[std::size_t(i)] = grip_of(traces_[std::size_t(i)]);
  });
}

ContactForces::Grip ContactForces::grip_of(const Trace& trace) const {
  Grip grip;
  if (!(trace.limit > 0)) return grip;
  grip.stiffness = trace.stiffness;
  grip.offset = offset_from(trace.anchor, positions_[std::size_t(trace.vertex)], corners(trace.triangle));
  const double length = grip.offset.along.norm();
  grip.held = length > trace.limit ? trace.limit / length : 1;
  return grip;
}

template <class Real>
void ContactForces::come_to(Positions<Real> x) {
  find(x);
  if (positions_ == stepped_from_) return;
  std::vector<Trace> traces;
  for (const Contact& contact : contacts_) {
    traces.push_back(trace_after(contact));
    const double reach = lengths_of(contact).reach;
    depth_so_far_ = std::max(depth_so_far_, contact.touch.depth * reach_share / reach);
    reach_so_far_ = std::max(reach_so_far_, contact.touch.depth / reach);
  }
  traces_ = std::move(traces);
  for (Contact& contact : contacts_) {
    contact.trace = trace_of(contact);
    press(contact);
  }
  watch_motion();
  some_wait_ ? find_contacts() : find_grips();
}

/// The anchor of a vertex that slips is as far from it as friction can hold.
ContactForces::Trace ContactForces::trace_after(const Contact& contact) const {
  Trace trace{.vertex = contact.vertex,
              .body = body_of_triangle_[std::size_t(contact.triangle)],
              .triangle = contact.triangle,
              .anchor = contact.touch.foot,
              .limit = rules_.friction * contact.pressure,
              .stiffness = contact.stiffness};
  const Grip* grip = grip_at(contact);
  if (!grip || !(grip->held > 0)) return trace;
  if (grip->held == 1 && contact.trace->triangle == contact.triangle)
    trace.anchor = contact.trace->anchor;
  else
    trace.anchor = foot_on(positions_[std::size_t(contact.vertex)] - grip->held * grip->offset.along,
                           corners(contact.triangle));
  return trace;
}

void ContactForces::forget() {
  traces_.clear();
  grips_.clear();
  stepped_from_.clear();
  if (!positions_.empty()) find_contacts();
}

/// Boxes about where bodies were and are say which may have met.
void ContactForces::watch_motion() {
  const std::vector<Vec3> from = std::exchange(stepped_from_, positions_);
  if (from.empty()) return;
  struct Swept {
    Box box;
    Vec3 motion;
  };
  std::vector<Swept> swept;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const auto begin = std::size_t(first_vertex_[i]), end = std::size_t(first_vertex_[i + 1]);
    Swept now{{from[begin], from[begin]}, Vec3::Zero()};
    for (std::size_t v = begin; v < end; ++v) {
      now.box.lower = now.box.lower.cwiseMin(from[v]).cwiseMin(positions_[v]);
      now.box.upper = now.box.upper.cwiseMax(from[v]).cwiseMax(positions_[v]);
      now.motion += (positions_[v] - from[v]) / double(end - begin);
    }
    swept.push_back(now);
  }
  for (std::size_t a = 0; a < swept.size() && rules_.bodies; ++a)
    for (std::size_t b = a + 1; b < swept.size(); ++b)
      if (overlap(swept[a].box, swept[b].box, 0))
        motion_so_far_ = std::max(
            motion_so_far_, (swept[a].motion - swept[b].motion).norm() / lengths_of(int(a), int(b)).reach);
}

/// [N], of a touch without friction.
TouchForces ContactForces::forces_of(const Contact& contact) const {
  const TouchLengths lengths = lengths_of(contact);
  TouchForces forces = touch_forces(contact.touch, lengths), slope{};
  const double falls = contact.softening * touch_energy(contact.touch, lengths);
  if (falls > 0)
    slope = slope_at_nearest(contact.touch, positions_[std::size_t(contact.vertex)],
                             corners(contact.triangle), compliances(contact.triangle));
  const auto add = [&](Vec3& force, const Vec3& more) {
    force *= contact.stiffness;
    if (falls > 0) force -= falls * more;
  };
  add(forces.vertex, slope.vertex);
  for (std::size_t i = 0; i < 3; ++i) add(forces.corners[i], slope.corners[i]);
  return forces;
}

/// Forces of all touches, by vertex.
void ContactForces::add_to_vertices() {
  const auto push = [&](int vertex, const Vec3& force) {
    forces_[std::size_t(vertex)] += force;
    pushed_.push_back(vertex);
  };
  for (const Contact& contact : contacts_) {
    const TouchForces forces = forces_of(contact);
    push(contact.vertex, forces.vertex);
    for (std::size_t i = 0; i < 3; ++i) push(triangles_[std::size_t(contact.triangle)][i], forces.corners[i]);
  }
  for (std::size_t t = 0; t < traces_.size(); ++t) {
    const double friction = grips_[t].stiffness * grips_[t].held;
    if (!(friction > 0)) continue;
    push(traces_[t].vertex, -friction * grips_[t].offset.along);
    for (std::size_t i = 0; i < 3; ++i)
      push(triangles_[std::size_t(traces_[t].triangle)][i], friction * grips_[t].offset.by_corner[i]);
  }
  std::sort(pushed_.begin(), pushed_.end());
  pushed_.erase(std::unique(pushed_.begin(), pushed_.end()), pushed_.end());
}

void ContactForces::clear_vertices() {
  for (const int vertex : pushed_) forces_[std::size_t(vertex)].setZero();
  pushed_.clear();
}

template <class Real>
void ContactForces::add_forces(Fields<Real> forces) {
  add_to_vertices();
  for (const int vertex : pushed_) {
    const auto body = std::size_t(body_of_vertex_[std::size_t(vertex)]);
    for (const auto& [site, weight] : surfaces_[body].shares(std::size_t(vertex - first_vertex_[body])))
      forces[body]->set(site, forces[body]->at(site) + weight * forces_[std::size_t(vertex)]);
  }
  clear_vertices();
}

template <class Real>
void ContactForces::add_accelerations(Fields<Real> accelerations) {
  add_to_vertices();
  for (const int vertex : pushed_) {
    const auto body = std::size_t(body_of_vertex_[std::size_t(vertex)]);
    Field<Real>& a = *accelerations[body];
    for (const auto& [site, weight] : surfaces_[body].shares(std::size_t(vertex - first_vertex_[body])))
      a.set(site, a.at(site) + weight / bodies_[body].body->mass(site) * forces_[std::size_t(vertex)]);
  }
  clear_vertices();
}

double ContactForces::energy() const {
  double sum = 0;
  for (const Contact& contact : contacts_) {
    sum += contact.stiffness * touch_energy(contact.touch, lengths_of(contact));
  }
  for (const Grip& grip : grips_) sum += grip.stiffness * (grip.held * grip.offset.along).squaredNorm() / 2;
  return sum;
}

ContactReport ContactForces::report() const {
  ContactReport report{.touches = contacts_.size(),
                       .energy = energy(),
                       .depth_so_far = depth_so_far_,
                       .reach_so_far = reach_so_far_,
                       .motion_so_far = motion_so_far_};
  for (const Contact& contact : contacts_) {
    report.depth = std::max(report.depth, contact.touch.depth);
    report.force += contact.stiffness * contact.pressure;
  }
  return report;
}

std::vector<ContactForces::Point> ContactForces::points() const {
  std::vector<Point> points;
  for (const Contact& contact : contacts_) {
    const int body = body_of_vertex_[std::size_t(contact.vertex)],
              other = body_of_triangle_[std::size_t(contact.triangle)];
    Vec3 force = forces_of(contact).vertex;
    if (const Grip* grip = grip_at(contact)) force -= grip->stiffness * grip->held * grip->offset.along;
    points.push_back({body, other, positions_[std::size_t(contact.vertex)], force});
  }
  return points;
}

void ContactForces::add_carriers(int vertex, double weight, std::vector<Carrier>& carriers) const {
  const int body = body_of_vertex_[std::size_t(vertex)];
  for (const auto& [site, share] :
       surfaces_[std::size_t(body)].shares(std::size_t(vertex - first_vertex_[std::size_t(body)]))) {
    const auto known = std::find_if(carriers.begin(), carriers.end(), [&, at = site](const Carrier& carrier) {
      return carrier.body == body && carrier.site == at;
    });
    if (known == carriers.end())
      carriers.push_back({body, site, weight * share});
    else
      known->weight += weight * share;
  }
}

void ContactForces::set_carriers(int vertex, int triangle, const std::array<double, 3>& weights,
                                 std::vector<Carrier>& carriers) const {
  carriers.clear();
  add_carriers(vertex, 1, carriers);
  for (std::size_t i = 0; i < 3; ++i)
    add_carriers(triangles_[std::size_t(triangle)][i], -weights[i], carriers);
}

Eigen::Matrix3d ContactForces::stiffness_of(const Contact& contact, std::vector<Carrier>& carriers) const {
  set_carriers(contact.vertex, contact.triangle, contact.touch.foot, carriers);
  return contact.stiffness * touch_stiffness(contact.touch, lengths_of(contact));
}

Eigen::Matrix3d ContactForces::stiffness_of_grip(std::size_t index, std::vector<Carrier>& carriers) const {
  const Trace& trace = traces_[index];
  const Grip& grip = grips_[index];
  set_carriers(trace.vertex, trace.triangle, trace.anchor, carriers);
  const Vec3& n = grip.offset.normal;
  Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - n * n.transpose();
  if (grip.held < 1) {
    const Vec3 along = grip.offset.along.stableNormalized();
    across -= along * along.transpose();
  }
  return grip.stiffness * grip.held * across;
}

void ContactReport::remember(Record& record) {
  record.keep(touches, depth, energy, force, depth_so_far, reach_so_far, motion_so_far);
}

void ContactForces::Trace::remember(Record& record) {
  record.keep(vertex, body, triangle, limit, stiffness);
  for (double& weight : anchor) record.keep(weight);
}

/// Candidates follow from positions; what is found does not depend on when they were looked for.
void ContactForces::remember(Record& record) {
  record.keep(traces_, depth_so_far_, reach_so_far_, motion_so_far_);
  std::uint64_t stepped = stepped_from_.size();
  record.keep(stepped);
  stepped_from_.resize(std::size_t(stepped));
  for (Vec3& x : stepped_from_) record.keep(x);
  if (record.reads()) positions_.clear(), grips_.assign(traces_.size(), {});
}

template void ContactForces::find(Positions<float>);
template void ContactForces::find(Positions<double>);
template void ContactForces::come_to(Positions<float>);
template void ContactForces::come_to(Positions<double>);
template void ContactForces::add_forces(Fields<float>);
template void ContactForces::add_forces(Fields<double>);
template void ContactForces::add_accelerations(Fields<float>);
template void ContactForces::add_accelerations(Fields<double>);

}  // namespace mss
