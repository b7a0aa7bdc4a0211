#include "core/body/body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "core/base/error.hpp"
#include "core/body/fill_shares.hpp"

namespace mss {

namespace {

struct HashCells {
  std::size_t operator()(const std::array<std::uint32_t, 27>& cells) const {
    std::size_t hash = 14695981039346656037U;  // FNV-1a
    for (const std::uint32_t content : cells) hash = (hash ^ content) * 1099511628211U;
    return hash;
  }
};

/// The planes of a body that a rank has, of the whole body's lattice: its share, and a ghost plane on each
/// side where there are others.
PlaneRange planes_with_ghosts(const Communicator& ranks, int planes) {
  if (ranks.count() > planes && planes == 1)
    throw InputError(
        fmt::format("{} ranks share a body by its planes of particles along z, and it is flat along z; give "
                    "it cells along z, or one rank",
                    ranks.count()));
  if (ranks.count() > planes)
    throw InputError(fmt::format("{} ranks share a body of {} planes of particles along z; give at most {}",
                                 ranks.count(), planes, planes));
  const auto [first, last] = ranks.share_of(planes);
  return {ranks.is_lowest() ? first : first - 1, ranks.is_highest() ? last : last + 1};
}

PlaneRange shifted(PlaneRange planes, int by) { return {planes.first + by, planes.last + by}; }

/// Those of a cell that are not beside it along a flat axis.
std::vector<int> corners_along(int flat_axes) {
  std::vector<int> corners;
  for (int c = 0; c < 8; ++c)
    if ((c & flat_axes) == 0) corners.push_back(c);
  return corners;
}

}  // namespace

Body::Body(const BodyConfig& config, const Communicator& ranks)
    : config_(config),
      ranks_(ranks),
      planes_(planes_with_ghosts(ranks, config.voxels.nz() + 1)),
      own_(shifted(ranks.share_of(config.voxels.nz() + 1), -planes_.first)),
      lattice_(config.voxels.nx(), config.voxels.ny(), planes_.last - planes_.first - 1),
      corners_(corners_along(config.voxels.flat_axes())),
      parts_(config.all_parts()),
      kinds_(config_) {
  check_contents(config_);
  find_particles();
  classify_sites();
  check_masses();
  find_added_masses();
}

/// Each rank goes through all cells, so that sums over them are everywhere the same.
void Body::find_particles() {
  particle_.assign(std::size_t(lattice_.size), -1);
  std::vector<double> filled(parts_.size());  // by mass
  config_.voxels.for_each_place([&](int i, int j, int k) {
    if (!config_.voxels.at(i, j, k)) return;
    ++cells_;
    for (const auto& [part, fill] : config_.content(config_.content_at(i, j, k))) {
      filled_cells_ += mean_of(fill.octant);
      filled[std::size_t(part)] += mean_of(fill.corner);
    }
    const int plane = k - planes_.first;
    const std::ptrdiff_t site = lattice_.site(i, j, plane);
    for (const int c : corners_)
      if (is_own(plane + (c >> 2))) particle_[std::size_t(site + lattice_.corner(c))] = 0;
  });
  for (std::size_t part = 0; part < parts_.size(); ++part)
    mass_of_cells_ += parts_[part].density * filled[part] * cell_volume();
  for (std::ptrdiff_t site = lattice_.plane * own_.first; site < lattice_.plane * own_.last; ++site)
    if (int& particle = particle_[std::size_t(site)]; particle == 0) {
      particle = int(site_of_.size());
      site_of_.push_back(site);
    }
}

/// Each rank goes through all sites, so that kinds are everywhere the same.
void Body::classify_sites() {
  kind_.assign(std::size_t(lattice_.size), 0);
  // The set contains numbers of neighbourhoods, which lie in a row: of a mesh's surface there are many.
  std::vector<CellsAround> kinds{{}};  // kind 0: nothing
  const auto hash = [&](std::uint32_t kind) { return HashCells()(kinds[kind]); };
  const auto equal = [&](std::uint32_t a, std::uint32_t b) { return kinds[a] == kinds[b]; };
  std::unordered_set<std::uint32_t, decltype(hash), decltype(equal)> known({0}, 16, hash, equal);
  const VoxelGrid& voxels = config_.voxels;
  for (int k = 0; k <= voxels.nz(); ++k)
    for (int j = 0; j <= voxels.ny(); ++j) {
      CellsAround cells{};
      const auto add_column = [&](int i) {  // moves on along x
        for (std::size_t row = 0; row < 9; ++row) {
          std::copy_n(&cells[3 * row + 1], 2, &cells[3 * row]);
          cells[3 * row + 2] = config_.content_at(i, j + int(row) % 3 - 1, k + int(row) / 3 - 1);
        }
      };
      add_column(-1);
      add_column(0);
      const int plane = k - planes_.first;
      for (int i = 0; i <= voxels.nx(); ++i) {
        add_column(i + 1);
        if (is_own(plane) ? particle(lattice_.site(i, j, plane)) < 0 : !touch_site(cells)) continue;
        const CellsAround& key = kinds.emplace_back(kinds_.relevant(cells));
        const auto [kind, is_new] = known.insert(std::uint32_t(kinds.size() - 1));
        if (is_new)
          kinds_.add(key);
        else
          kinds.pop_back();
        if (is_here(plane)) kind_[std::size_t(lattice_.site(i, j, plane))] = *kind;
      }
    }
  ranks_.add_in_order(springs_, [&] { for_each_spring([&](auto&&...) { ++springs_; }); });
}

/// A particle in empty octants has mass by the floor b alone.
void Body::check_masses() const {
  for (const std::ptrdiff_t site : site_of_)
    if (!(weights_at(site).mass > 0))
      throw InputError("a particle has no mass: give its cells more, or fill_blend_mass above 0");
}

void Body::find_added_masses() {
  if (config_.weights.empty()) return;
  added_mass_.assign(std::size_t(lattice_.size), 0);
  for (const Weight& weight : config_.weights) {
    const std::vector<std::ptrdiff_t> sites = select(weight.box.lower, weight.box.upper);
    std::size_t count = 0;
    ranks_.add_in_order(count, [&] { count += sites.size(); });
    for (const std::ptrdiff_t site : sites) added_mass_[std::size_t(site)] += weight.mass / double(count);
    if (count > 0) all_added_mass_ += weight.mass;
  }
}

Vec3 Body::rest_position(std::ptrdiff_t site) const {
  const auto [i, j, k] = lattice_.coordinates(site);
  return config_.origin + config_.cell_size * Vec3(i, j, k + planes_.first);
}

std::vector<std::ptrdiff_t> Body::select(const Vec3& lower, const Vec3& upper) const {
  const double slack = 1e-9 * config_.cell_size;
  std::vector<std::ptrdiff_t> selected;
  for (const std::ptrdiff_t site : site_of_) {
    const Vec3 p = rest_position(site);
    if ((p.array() >= lower.array() - slack).all() && (p.array() <= upper.array() + slack).all())
      selected.push_back(site);
  }
  return selected;
}

std::vector<std::ptrdiff_t> select(const std::vector<Level>& levels, const Box& box) {
  std::vector<std::ptrdiff_t> selected;
  for (const auto& [body, first] : levels)
    for (const std::ptrdiff_t site : body.select(box.lower, box.upper)) selected.push_back(first + site);
  return selected;
}

template <class Real>
void copy_level(const Field<Real>& whole, const Level& level, Field<Real>& part) {
  for (int axis = 0; axis < 3; ++axis)
    std::copy_n(whole.axis(axis) + level.first, level.body.lattice().size, part.axis(axis));
}

template <class Real>
void copy_level(const Level& level, const Field<Real>& part, Field<Real>& whole) {
  for (int axis = 0; axis < 3; ++axis)
    std::copy_n(part.axis(axis), level.body.lattice().size, whole.axis(axis) + level.first);
}

template void copy_level(const Field<float>&, const Level&, Field<float>&);
template void copy_level(const Field<double>&, const Level&, Field<double>&);
template void copy_level(const Level&, const Field<float>&, Field<float>&);
template void copy_level(const Level&, const Field<double>&, Field<double>&);

}  // namespace mss
