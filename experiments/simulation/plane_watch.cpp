#include "experiments/simulation/plane_watch.hpp"

#include <algorithm>
#include <limits>

#include "core/base/field_part.hpp"

namespace mss {

namespace {

double tolerated_depth(ContactLaw law, const BodyConfig& body, double penalties) {
  constexpr double rounding = 1e-9;
  if (law == ContactLaw::penalty) return penalties * body.cell_size;
  const VoxelGrid& voxels = body.voxels;
  return rounding * body.cell_size * Vec3(voxels.nx(), voxels.ny(), voxels.nz()).norm();
}

/// Whether a particle is held against a push of a plane with that normal.
bool is_held(const HeldSites& held, std::ptrdiff_t site, const Vec3& normal) {
  if (held.empty()) return false;
  for (int axis = 0; axis < 3; ++axis)
    if (normal[axis] != 0 && held.holds(site, axis)) return true;
  return false;
}

}  // namespace

template <class Real>
PlaneWatch<Real>::PlaneWatch(const Scene& scene, const SolidSystem<Real>& system)
    : planes_(scene.environment.planes),
      obstacles_(scene.environment.obstacles.begin(), scene.environment.obstacles.end()),
      system_(system),
      watched_(planes_.size() + obstacles_.size()) {
  if (watched_.empty()) return;
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  std::vector<std::ptrdiff_t> particles = system.particles();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!bodies[b]->contact_surface) continue;
    const BodyConfig& body = bodies[b]->body;
    const auto& [of_level, first] = system.levels()[b];
    const std::ptrdiff_t size = of_level.lattice().size, from = first;
    surfaces_.push_back(
        {EmbeddedSurface(*bodies[b]->contact_surface, body.voxels, body.cell_size, body.origin), from, size});
    std::erase_if(particles, [&](std::ptrdiff_t site) { return site >= from && site < from + size; });
  }
  const HeldSites held(system.levels(), scene.environment.holds);
  constexpr double of_mesh = 0.01;
  for (std::size_t p = 0; p < watched_.size(); ++p) {
    const bool is_plane = p < planes_.size();
    watched_[p].tolerated = tolerated_depth(law(p), scene.body, tolerated_by_penalties);
    if (!is_plane && obstacles_[p - planes_.size()].obstacle().shape == ObstacleShape::mesh)
      watched_[p].tolerated = std::max(watched_[p].tolerated, of_mesh * scene.body.cell_size);
    const Vec3 normal = is_plane ? planes_[p].normal : Vec3(Vec3::Ones());  // an obstacle pushes anywhere
    for (const std::ptrdiff_t site : particles)
      if (!is_held(held, site, normal)) watched_[p].sites.push_back(site);
  }
}

template <class Real>
typename PlaneWatch<Real>::Depths PlaneWatch<Real>::depths(std::size_t plane,
                                                           const State<Real>& state) const {
  constexpr double rounding = 64 * double(std::numeric_limits<Real>::epsilon());
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Depths depths{-infinity, infinity, 0};
  const auto take = [&](const Vec3& x) {
    const double depth = -gap(plane, x, state.t);
    depths.smallest = std::min(depths.smallest, depth);
    depths.rounding = std::max(depths.rounding, rounding * x.norm());
    depths.largest = std::max(depths.largest, depth);
  };
  for (const auto& [surface, first, size] : surfaces_)
    for (const Vec3& vertex : surface.interpolate(part_of(state.x, first, size))) take(vertex);
  for (const std::ptrdiff_t site : watched_[plane].sites) take(state.x.at(site));
  const Communicator& ranks = system_.ranks();
  return {ranks.largest(depths.largest), -ranks.largest(-depths.smallest), ranks.largest(depths.rounding)};
}

template <class Real>
void PlaneWatch<Real>::add(const State<Real>& state) {
  for (std::size_t p = 0; p < watched_.size(); ++p) {
    Watched& watched = watched_[p];
    const auto [largest, smallest, rounding] = depths(p, state);
    const bool is_behind = largest > watched.tolerated + rounding;
    watched.ends_whole = is_behind && smallest >= -rounding;
    if (!is_behind && !watched.was_clear) watched.depth = 0;
    watched.was_clear |= !is_behind;
    if (!is_behind || (watched.was_clear && largest <= watched.depth)) continue;
    watched.t = state.t;
    watched.depth = largest;
  }
}

template <class Real>
bool PlaneWatch<Real>::lifts() const {
  for (std::size_t p = 0; p < watched_.size(); ++p)
    if (law(p) == ContactLaw::impulse && !watched_[p].was_clear) return true;
  return false;
}

template <class Real>
std::vector<Penetration> PlaneWatch<Real>::found() const {
  std::vector<Penetration> found;
  for (std::size_t p = 0; p < watched_.size(); ++p)
    if (watched_[p].depth > 0)
      found.push_back({p, watched_[p].t, watched_[p].depth, watched_[p].ends_whole, !surfaces_.empty()});
  return found;
}

template class PlaneWatch<float>;
template class PlaneWatch<double>;

}  // namespace mss
