#include "core/environment/environment.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/mesh/embedded_surface.hpp"

namespace mss {

namespace {

/// Of entries ascending by site.
template <class Entry>
std::vector<std::ptrdiff_t> distinct_sites(const std::vector<Entry>& entries) {
  std::vector<std::ptrdiff_t> sites;
  for (const Entry& entry : entries)
    if (sites.empty() || sites.back() != entry.site) sites.push_back(entry.site);
  return sites;
}

/// Of a hold that turns: from its centre to the particle, without what moves both.
Vec3 arm_of(const Hold& hold, const Vec3& rest, double t) {
  const Turn& turn = *hold.turn;
  return Eigen::AngleAxisd(turn.rate * std::min(t, turn.until), turn.axis.normalized()) *
         (rest + hold.displacement - turn.centre);
}

}  // namespace

Prescribed prescribed_motion(const Hold& hold, const Vec3& rest, double t) {
  Prescribed p{rest + hold.displacement + hold.velocity * t, hold.velocity};
  if (hold.turn) {
    const Turn& turn = *hold.turn;
    const Vec3 arm = arm_of(hold, rest, t);
    p.position = turn.centre + arm + hold.velocity * t;
    if (t < turn.until) p.velocity += turn.rate * turn.axis.normalized().cross(arm);
  }
  if (!hold.path.empty()) {
    p.position += hold.path.at(t);
    p.velocity += hold.path.slope(t);
  }
  return p;
}

Vec3 prescribed_acceleration(const Hold& hold, const Vec3& rest, double t) {
  if (!hold.turn || t >= hold.turn->until) return Vec3::Zero();
  const Turn& turn = *hold.turn;
  const Vec3 axis = turn.axis.normalized();
  return turn.rate * axis.cross(turn.rate * axis.cross(arm_of(hold, rest, t)));
}

std::vector<std::ptrdiff_t> sites_of(const Hold& hold, const Body& body) {
  if (!hold.surface) return body.select(hold.box.lower, hold.box.upper);
  const double h = body.config().cell_size, reach = (0.5 + 1e-9) * h;
  std::vector<bool> held(std::size_t(body.lattice().size));
  for (const std::size_t face : faces_in(*hold.surface, hold.box, 1e-9 * h)) {
    const std::array<Vec3, 3> corners = hold.surface->corners(face);
    Eigen::AlignedBox3d around;
    for (const Vec3& corner : corners) around.extend(corner);
    for (const std::ptrdiff_t site :
         body.select(around.min() - Vec3::Constant(reach), around.max() + Vec3::Constant(reach)))
      if (distance(body.rest_position(site), corners) <= reach) held[std::size_t(site)] = true;
  }
  std::vector<std::ptrdiff_t> sites = body.sites();
  std::erase_if(sites, [&](std::ptrdiff_t site) { return !held[std::size_t(site)]; });
  return sites;
}

HeldSites::HeldSites(const std::vector<Level>& levels, const std::vector<Hold>& holds) : holds_(holds) {
  for (const auto& [body, first] : levels)
    for (std::size_t h = 0; h < holds.size(); ++h)
      for (const std::ptrdiff_t site : sites_of(holds[h], body))
        entries_.push_back({first + site, h, body.rest_position(site), holds[h].axes});
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.site < b.site; });
}

template <class Real>
void HeldSites::apply(double t, std::ptrdiff_t first, std::ptrdiff_t last, Field<Real>& x,
                      Field<Real>& v) const {
  const auto begin = std::lower_bound(entries_.begin(), entries_.end(), first,
                                      [](const Entry& e, std::ptrdiff_t site) { return e.site < site; });
  for (auto e = begin; e != entries_.end() && e->site < last; ++e) {
    const Prescribed p = prescribed_motion(holds_[e->hold], e->rest, t);
    for (int a = 0; a < 3; ++a) {
      if (!e->axes[std::size_t(a)]) continue;
      x.axis(a)[e->site] = static_cast<Real>(p.position[a]);
      v.axis(a)[e->site] = static_cast<Real>(p.velocity[a]);
    }
  }
}

bool HeldSites::move(double t, std::ptrdiff_t first, std::ptrdiff_t last) const {
  const auto begin = std::lower_bound(entries_.begin(), entries_.end(), first,
                                      [](const Entry& e, std::ptrdiff_t site) { return e.site < site; });
  for (auto e = begin; e != entries_.end() && e->site < last; ++e)
    if (holds_[e->hold].moves(t)) return true;
  return false;
}

std::vector<std::ptrdiff_t> HeldSites::sites() const { return distinct_sites(entries_); }

bool HeldSites::holds(std::ptrdiff_t site, int axis) const {
  const auto begin = std::lower_bound(entries_.begin(), entries_.end(), site,
                                      [](const Entry& e, std::ptrdiff_t s) { return e.site < s; });
  for (auto e = begin; e != entries_.end() && e->site == site; ++e)
    if (e->axes[std::size_t(axis)]) return true;
  return false;
}

template <class Real>
void HeldSites::clear(Field<Real>& field) const {
  for (const Entry& e : entries_)
    for (int a = 0; a < 3; ++a)
      if (e.axes[std::size_t(a)]) field.axis(a)[e.site] = Real(0);
}

LoadedSites::LoadedSites(const std::vector<Level>& levels, const std::vector<Load>& loads) : loads_(loads) {
  for (std::size_t load = 0; load < loads.size(); ++load)
    if (loads[load].surface)
      add_on_surface(levels.front().body, load);
    else
      add_on_particles(levels, load);
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.site < b.site; });
}

void LoadedSites::add_on_particles(const std::vector<Level>& levels, std::size_t number) {
  const Load& load = loads_[number];
  const double cell_size = levels.front().body.config().cell_size;
  struct Loaded {
    std::ptrdiff_t site;
    double mass,
        shrinkage;  ///< of the cells: a power of two, so that shares are exact where there is one size
  };
  std::vector<Loaded> loaded;
  Eigen::AlignedBox3d extent;
  for (const auto& [body, first] : levels)
    for (const std::ptrdiff_t site : body.select(load.box.lower, load.box.upper)) {
      loaded.push_back({first + site, body.mass(site), cell_size / body.config().cell_size});
      extent.extend(body.rest_position(site));
    }
  const Communicator& ranks = levels.front().body.ranks();
  Eigen::AlignedBox3d whole_extent;
  for (Vec3* corner : {&whole_extent.min(), &whole_extent.max()})
    ranks.add_in_order(*corner, [&] {
      *corner = corner == &whole_extent.min() ? corner->cwiseMin(extent.min()).eval()
                                              : corner->cwiseMax(extent.max()).eval();
    });
  if (whole_extent.isEmpty()) return;
  const auto layers = double((whole_extent.sizes().array() < 1e-9 * cell_size).count());
  double sum = 0;
  ranks.add_in_order(sum, [&] {
    for (const Loaded& l : loaded) sum += l.mass * std::pow(l.shrinkage, layers);
  });
  for (const Loaded& l : loaded)
    entries_.push_back({l.site, number, load.force * (l.mass * std::pow(l.shrinkage, layers) / sum)});
}

void LoadedSites::add_on_surface(const Body& body, std::size_t number) {
  const Load& load = loads_[number];
  const BodyConfig& config = body.config();
  const EmbeddedSurface surface(*load.surface, config.voxels, config.cell_size, config.origin);
  const std::vector<std::size_t> vertices = vertices_in(*load.surface, load.box, 1e-9 * config.cell_size);
  Field<double> forces(body.lattice().size);
  for (const std::size_t vertex : vertices)
    surface.distribute(vertex, load.force / double(vertices.size()), forces);
  for (const std::ptrdiff_t site : body.sites())
    if (forces.at(site) != Vec3::Zero()) entries_.push_back({site, number, forces.at(site)});
}

std::vector<std::ptrdiff_t> LoadedSites::sites() const { return distinct_sites(entries_); }

bool LoadedSites::change(double t) const {
  return std::any_of(loads_.begin(), loads_.end(), [&](const Load& load) { return load.history.changes(t); });
}

template <class Real>
void LoadedSites::add(double t, std::ptrdiff_t first, std::ptrdiff_t last,
                      const std::array<Real*, 3>& forces) const {
  const auto begin = std::lower_bound(entries_.begin(), entries_.end(), first,
                                      [](const Entry& e, std::ptrdiff_t site) { return e.site < site; });
  for (auto e = begin; e != entries_.end() && e->site < last; ++e) {
    const Vec3 force = force_at(t, *e);
    for (int a = 0; a < 3; ++a) forces[std::size_t(a)][e->site - first] += static_cast<Real>(force[a]);
  }
}

template <class Real>
void LoadedSites::add_potential(double t, const Field<Real>& x, double& sum) const {
  for (const Entry& e : entries_) sum -= force_at(t, e).dot(x.at(e.site));
}

template void HeldSites::apply(double, std::ptrdiff_t, std::ptrdiff_t, Field<float>&, Field<float>&) const;
template void HeldSites::apply(double, std::ptrdiff_t, std::ptrdiff_t, Field<double>&, Field<double>&) const;
template void HeldSites::clear(Field<float>&) const;
template void HeldSites::clear(Field<double>&) const;
template void LoadedSites::add(double, std::ptrdiff_t, std::ptrdiff_t, const std::array<float*, 3>&) const;
template void LoadedSites::add(double, std::ptrdiff_t, std::ptrdiff_t, const std::array<double*, 3>&) const;
template void LoadedSites::add_potential(double, const Field<float>&, double&) const;
template void LoadedSites::add_potential(double, const Field<double>&, double&) const;

}  // namespace mss
