#include "core/body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <unordered_map>

#include "core/error.hpp"

namespace mss {

namespace {

constexpr int corner_bit(int corner, int axis) { return (corner >> axis) & 1; }

/// Which of the 27 cells around a site touch both given corners of its own cell, as bits: for one corner
/// twice these are the particle's up to eight cells, for the two ends of a spring those that share it.
constexpr std::uint32_t cells_touching(int corner_a, int corner_b) {
  std::uint32_t cells = 0;
  for (int cell = 0; cell < 27; ++cell) {
    const std::array<int, 3> d{cell % 3 - 1, cell / 3 % 3 - 1, cell / 9 - 1};
    bool touches = true;
    for (int axis = 0; axis < 3; ++axis)
      for (const int corner : {corner_a, corner_b}) {
        const int from_cell = corner_bit(corner, axis) - d[std::size_t(axis)];
        touches = touches && (from_cell == 0 || from_cell == 1);
      }
    if (touches) cells |= 1U << unsigned(cell);
  }
  return cells;
}

constexpr auto cells_of_corner = [] {
  std::array<std::uint32_t, 8> cells{};
  for (int c = 0; c < 8; ++c) cells[std::size_t(c)] = cells_touching(c, c);
  return cells;
}();
constexpr auto cells_of_slot = [] {
  std::array<std::uint32_t, spring_slots.size()> cells{};
  for (std::size_t s = 0; s < cells.size(); ++s)
    cells[s] = cells_touching(spring_slots[s].a, spring_slots[s].b);
  return cells;
}();

/// The fill factors of some of these cells, added.
double sum_of(const std::array<float, 27>& fill, std::uint32_t cells) {
  double sum = 0;
  for (; cells != 0; cells &= cells - 1) sum += double(fill[std::size_t(std::countr_zero(cells))]);
  return sum;
}

struct HashCells {
  std::size_t operator()(const std::array<float, 27>& cells) const {
    std::size_t hash = 14695981039346656037U;  // FNV-1a
    for (const float fill : cells) hash = (hash ^ std::bit_cast<std::uint32_t>(fill)) * 1099511628211U;
    return hash;
  }
};

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
  check_fill();
  find_particles();
  classify_sites();
  add_weights();
}

void Body::check_fill() const {
  const std::vector<float>& fill = config_.cell_fill;
  if (fill.empty()) return;
  const VoxelGrid& voxels = config_.voxels;
  const auto boxed = std::size_t(voxels.nx()) * std::size_t(voxels.ny()) * std::size_t(voxels.nz());
  if (fill.size() != boxed)
    throw InputError(fmt::format("{} fill factors for a box of {} cells", fill.size(), boxed));
  if (config_.sharing != Sharing::weighted)
    throw InputError("fill factors need springs that cells share by weight (sharing = \"weighted\")");
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i)
        if (const float f = this->fill(i, j, k); voxels.at(i, j, k) && !(f > 0 && f <= 1))
          throw InputError(fmt::format("fill factor {} of cell ({}, {}, {}) is not in (0, 1]", f, i, j, k));
}

/// 0 where there is no cell.
float Body::fill(int i, int j, int k) const {
  if (!config_.voxels.at(i, j, k)) return 0;
  return config_.cell_fill.empty() ? 1 : config_.cell_fill[config_.voxels.index(i, j, k)];
}

void Body::find_particles() {
  cell_.assign(std::size_t(lattice_.size), 0);
  particle_.assign(std::size_t(lattice_.size), -1);
  const VoxelGrid& voxels = config_.voxels;
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i) {
        if (!voxels.at(i, j, k)) continue;
        ++cells_;
        filled_cells_ += double(fill(i, j, k));
        const std::ptrdiff_t site = lattice_.site(i, j, k);
        cell_[std::size_t(site)] = 1;
        for (int c = 0; c < 8; ++c) particle_[std::size_t(site + lattice_.corner(c))] = 0;
      }
  for (std::ptrdiff_t site = 0; site < lattice_.sites; ++site)
    if (int& particle = particle_[std::size_t(site)]; particle == 0) {
      particle = int(site_of_.size());
      site_of_.push_back(site);
    }
}

void Body::classify_sites() {
  kind_.assign(std::size_t(lattice_.size), 0);
  elements_.emplace_back();  // kind 0: nothing
  std::unordered_map<Neighbourhood, std::uint32_t, HashCells> kind_of{{Neighbourhood{}, 0}};
  const VoxelGrid& voxels = config_.voxels;
  for (int k = 0; k <= voxels.nz(); ++k)
    for (int j = 0; j <= voxels.ny(); ++j) {
      Neighbourhood cells{};
      const auto add_column = [&](int i) {  // moves on along x
        for (std::size_t row = 0; row < 9; ++row) {
          std::copy_n(&cells[3 * row + 1], 2, &cells[3 * row]);
          cells[3 * row + 2] = fill(i, j + int(row) % 3 - 1, k + int(row) / 3 - 1);
        }
      };
      add_column(0);
      for (int i = 0; i <= voxels.nx(); ++i) {
        add_column(i + 1);
        const auto [entry, is_new] = kind_of.try_emplace(cells, std::uint32_t(elements_.size()));
        if (is_new) elements_.push_back(elements_from(cells));
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

double Body::interior_stiffness(std::size_t slot) const {
  if (!in_topology(config_.topology, slot)) return 0;
  const std::array<double, 3> of_class{config_.springs.edge, config_.springs.face, config_.springs.body};
  return of_class[static_cast<std::size_t>(spring_slots[slot].kind)];
}

double Body::interior_fold_guard() const { return config_.fold_guard * config_.shear_modulus(); }

SiteElements Body::elements_from(const Neighbourhood& cells) const {
  constexpr std::array<double, 3> cells_of_interior_spring{4, 2, 1};
  std::array<double, 8> mass{};  // of the cell's corners
  for (std::size_t c = 0; c < mass.size(); ++c) mass[c] = eighth_mass_ * sum_of(cells, cells_of_corner[c]);
  SiteElements e;
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    const auto [a, b, kind] = spring_slots[s];
    const double shared = sum_of(cells, cells_of_slot[s]);
    if (shared == 0) continue;
    const double weight = config_.sharing == Sharing::uniform
                              ? 1
                              : shared / cells_of_interior_spring[static_cast<std::size_t>(kind)];
    e.weight[group_of[s]] = weight;
    e.stiffness[s] = weight * interior_stiffness(s);
    if (e.stiffness[s] != 0)
      e.damping[s] = config_.damping.coefficient(e.stiffness[s], mass[std::size_t(a)], mass[std::size_t(b)],
                                                 rest_length(kind), config_.shear_modulus());
  }
  e.volume = e.weight[spring_groups - 1] * config_.springs.volume;
  e.fold_guard = e.weight[spring_groups - 1] * interior_fold_guard();
  e.corner_fill = sum_of(cells, cells_of_corner[0]);
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
