#include "core/body.hpp"

#include <unordered_map>

namespace mss {

namespace {

/// Bit of the cell at offset (di, dj, dk) in {-1, 0, 1}^3 from a site's own cell.
constexpr std::uint32_t neighbour_bit(int di, int dj, int dk) {
  return 1U << unsigned((di + 1) + 3 * (dj + 1) + 9 * (dk + 1));
}

constexpr int corner_bit(int corner, int axis) { return (corner >> axis) & 1; }

/// Cells of a neighbourhood that touch all the given corners of the central cell: for one corner that is the
/// particle's up to eight cells, for the two ends of a spring the cells that share it.
int cells_touching(std::uint32_t neighbourhood, int corner_a, int corner_b) {
  int count = 0;
  for (int dk = -1; dk <= 1; ++dk)
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di) {
        const std::array<int, 3> d{di, dj, dk};
        bool touches = true;
        for (int axis = 0; axis < 3; ++axis)
          for (const int corner : {corner_a, corner_b}) {
            const int from_cell = corner_bit(corner, axis) - d[std::size_t(axis)];
            touches = touches && (from_cell == 0 || from_cell == 1);
          }
        if (touches && (neighbourhood & neighbour_bit(di, dj, dk)) != 0) ++count;
      }
  return count;
}

bool in_topology(Topology topology, std::size_t slot) {
  if (spring_slots[slot].kind != SpringSlot::Class::face) return true;
  if (topology == Topology::edges_body) return false;
  const bool first_diagonal = spring_slots[slot].a == 0;
  return topology == Topology::full || first_diagonal;
}

}  // namespace

Body::Body(const BodyConfig& config)
    : config_(config),
      lattice_(config.voxels.nx(), config.voxels.ny(), config.voxels.nz()),
      eighth_mass_(config.density * config.cell_size * config.cell_size * config.cell_size / 8) {
  count_corners();
  classify_sites();
  add_weights();
}

void Body::count_corners() {
  cell_.assign(std::size_t(lattice_.size), 0);
  corner_cells_.assign(std::size_t(lattice_.size), 0);
  const VoxelGrid& voxels = config_.voxels;
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i) {
        if (!voxels.at(i, j, k)) continue;
        ++cells_;
        const std::ptrdiff_t site = lattice_.site(i, j, k);
        cell_[std::size_t(site)] = 1;
        for (int c = 0; c < 8; ++c) ++corner_cells_[std::size_t(site + lattice_.corner(c))];
      }
  for (std::ptrdiff_t site = 0; site < lattice_.sites; ++site)
    if (corner_cells_[std::size_t(site)] != 0) site_of_.push_back(site);
}

void Body::classify_sites() {
  kind_.assign(std::size_t(lattice_.size), 0);
  elements_.emplace_back();  // kind 0: nothing
  std::unordered_map<std::uint32_t, std::uint32_t> kind_of{{0, 0}};
  const VoxelGrid& voxels = config_.voxels;
  const auto column = [&](int i, int j, int k) {  // the nine cells with this i, as bits of di = -1
    std::uint32_t bits = 0;
    for (int dk = -1; dk <= 1; ++dk)
      for (int dj = -1; dj <= 1; ++dj)
        if (voxels.at(i, j + dj, k + dk)) bits |= neighbour_bit(-1, dj, dk);
    return bits;
  };
  for (int k = 0; k <= voxels.nz(); ++k)
    for (int j = 0; j <= voxels.ny(); ++j) {
      std::uint32_t left = 0, centre = 0, right = column(0, j, k);
      for (int i = 0; i <= voxels.nx(); ++i) {
        left = centre;
        centre = right;
        right = column(i + 1, j, k);
        const std::uint32_t neighbourhood = left | centre << 1U | right << 2U;
        const auto [entry, is_new] = kind_of.try_emplace(neighbourhood, std::uint32_t(elements_.size()));
        if (is_new) elements_.push_back(elements_from(neighbourhood));
        kind_[std::size_t(lattice_.site(i, j, k))] = entry->second;
      }
    }
  for_each_spring([&](auto&&...) { ++springs_; });
}

void Body::add_weights() {
  if (config_.weights.empty()) return;
  weight_.assign(std::size_t(lattice_.size), 0);
  for (const Weight& weight : config_.weights) {
    const std::vector<std::ptrdiff_t> sites = select(weight.box.lower, weight.box.upper);
    for (const std::ptrdiff_t site : sites) weight_[std::size_t(site)] += weight.mass / double(sites.size());
    if (!sites.empty()) all_weights_ += weight.mass;
  }
}

SiteElements Body::elements_from(std::uint32_t neighbourhood) const {
  SiteElements e;
  const std::array<double, 3> class_stiffness{config_.springs.edge, config_.springs.face,
                                              config_.springs.body};
  constexpr std::array<double, 3> cells_of_interior_spring{4, 2, 1};
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    const auto [a, b, kind] = spring_slots[s];
    const int sharing_cells = cells_touching(neighbourhood, a, b);
    if (sharing_cells == 0 || !in_topology(config_.topology, s)) continue;
    const auto c = static_cast<std::size_t>(kind);
    const double weight =
        config_.sharing == Sharing::uniform ? 1 : double(sharing_cells) / cells_of_interior_spring[c];
    const double mass_a = eighth_mass_ * cells_touching(neighbourhood, a, a);
    const double mass_b = eighth_mass_ * cells_touching(neighbourhood, b, b);
    e.stiffness[s] = weight * class_stiffness[c];
    e.damping[s] = config_.damping.coefficient(e.stiffness[s], mass_a, mass_b, rest_length(kind));
  }
  if ((neighbourhood & neighbour_bit(0, 0, 0)) != 0) {
    e.volume = config_.springs.volume;
    e.fold_guard = config_.fold_guard * cubic_stiffness(config_.springs, config_.cell_size).c44;
  }
  return e;
}

Vec3 Body::rest_position(std::ptrdiff_t site) const {
  const std::ptrdiff_t in_plane = site % lattice_.plane;
  const std::ptrdiff_t i = in_plane % lattice_.row, j = in_plane / lattice_.row, k = site / lattice_.plane;
  return config_.origin + config_.cell_size * Vec3(double(i), double(j), double(k));
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

}  // namespace mss
