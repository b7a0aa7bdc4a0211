#include "core/body/site_kinds.hpp"

#include <cmath>

#include "core/base/lattice.hpp"
#include "core/body/fill_shares.hpp"

namespace mss {

namespace {

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

constexpr bool is_in(std::uint32_t cells, int cell) { return (cells >> unsigned(cell) & 1) != 0; }

/// A corner of a site's own cell as one of the 27 cells numbers it that touches it.
constexpr int corner_in(int cell, int corner) {
  const std::array<int, 3> d{cell % 3 - 1, cell / 3 % 3 - 1, cell / 9 - 1};
  int number = 0;
  for (int axis = 0; axis < 3; ++axis) number |= (corner_bit(corner, axis) - d[std::size_t(axis)]) << axis;
  return number;
}

/// All springs of a site touch its own cell's faces at the particle or lie in it; masses of the other corners
/// matter to dampers alone.
std::uint32_t relevant_cells(const BodyConfig& body) {
  const bool by_mass = body.any_part([](const Part& part) {
    return part.damping.law == Damping::Law::ratio || part.damping.law == Damping::Law::thesis;
  });
  return by_mass ? (1U << 27U) - 1 : cells_of_corner[0];
}

bool in_topology(Topology topology, int flat_axes, std::size_t slot) {
  if (((spring_slots[slot].a | spring_slots[slot].b) & flat_axes) != 0) return false;
  if (spring_slots[slot].kind != SpringSlot::Class::face) return true;
  if (topology == Topology::edges_body) return false;
  const bool first_diagonal = spring_slots[slot].a == 0;
  return topology == Topology::full || first_diagonal;
}

}  // namespace

/// What the cells around a site have of one part, in full cells.
struct SiteKinds::Shares {
  std::array<double, spring_slots.size()> spring{};
  std::array<double, 8> corner{};  ///< of its own cell, for masses
  double cell = 0;
};

bool touch_site(const CellsAround& cells) {
  for (int cell = 0; cell < 27; ++cell)
    if (is_in(cells_of_corner[0], cell) && cells[std::size_t(cell)] != 0) return true;
  return false;
}

SiteKinds::SiteKinds(const BodyConfig& config)
    : config_(config),
      parts_(config.all_parts()),
      springs_floor_(config.springs_floor()),
      mass_floor_(config.mass_floor()),
      relevant_(relevant_cells(config)) {
  find_constants();
  find_damping_time();
  add({});
}

CellsAround SiteKinds::relevant(const CellsAround& cells) const {
  CellsAround key{};
  for (int cell = 0; cell < 27; ++cell)
    if (is_in(relevant_, cell)) key[std::size_t(cell)] = cells[std::size_t(cell)];
  return key;
}

void SiteKinds::find_constants() {
  const auto take_largest = [](double& interior, double of_part) {
    if (std::abs(of_part) > std::abs(interior)) interior = of_part;
  };
  for (const Part& part : parts_) {
    const auto& [edge, face, body, volume] = part.springs;
    const double shear_modulus = config_.shear_modulus_of(part.springs);
    constants_.push_back({.spring = {edge, face, body},
                          .volume = volume,
                          .fold_guard = config_.fold_guard * shear_modulus,
                          .shear_modulus = shear_modulus});
  }
  Constants largest;
  for (const Constants& of_part : constants_) {
    for (std::size_t kind = 0; kind < 3; ++kind) take_largest(largest.spring[kind], of_part.spring[kind]);
    take_largest(largest.volume, of_part.volume);
    take_largest(largest.fold_guard, of_part.fold_guard);
  }
  interior_ = constants_.front();
  for (std::size_t kind = 0; kind < 3; ++kind)
    if (interior_.spring[kind] == 0) interior_.spring[kind] = largest.spring[kind];
  if (interior_.volume == 0) interior_.volume = largest.volume;
  if (interior_.fold_guard == 0) interior_.fold_guard = largest.fold_guard;
}

/// One for all springs if nothing damps, or viscosity alone, to which parts are as to their stiffness.
void SiteKinds::find_damping_time() {
  const auto time_of = [&](std::size_t part) -> std::optional<double> {
    const Damping& damping = parts_[part].damping;
    if (damping.law == Damping::Law::none) return 0;
    if (damping.law != Damping::Law::viscosity) return std::nullopt;
    return damping.viscosity / constants_[part].shear_modulus;
  };
  damping_time_ = time_of(0);
  for (std::size_t part = 1; part < parts_.size(); ++part)
    if (time_of(part) != damping_time_) damping_time_.reset();
}

double SiteKinds::mass_of_full_corner(std::size_t part) const {
  return parts_[part].density * config_.cell_volume() / 8;
}

double SiteKinds::interior_stiffness(std::size_t slot) const {
  return in_topology(config_.topology, config_.voxels.flat_axes(), slot)
             ? interior_.spring[static_cast<std::size_t>(spring_slots[slot].kind)]
             : 0;
}

SiteKinds::Shares SiteKinds::shares_of(const CellsAround& cells, int part) const {
  constexpr std::size_t own = 13;
  Shares shares;
  for (int cell = 0; cell < 27; ++cell) {
    if (cells[std::size_t(cell)] == 0) continue;
    for (const auto& [of_part, fill] : config_.content(cells[std::size_t(cell)])) {
      if (of_part != part) continue;
      if (cell == own) shares.cell += mean_of(fill.octant);
      for (std::size_t s = 0; s < spring_slots.size(); ++s) {
        if (!is_in(cells_of_slot[s], cell)) continue;
        shares.spring[s] += spring_share(fill, corner_in(cell, spring_slots[s].a),
                                         corner_in(cell, spring_slots[s].b), springs_floor_);
      }
      for (std::size_t c = 0; c < 8; ++c)
        if (is_in(cells_of_corner[c], cell))
          shares.corner[c] += corner_share(fill, corner_in(cell, int(c)), mass_floor_);
    }
  }
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    if (config_.sharing == Sharing::uniform)
      shares.spring[s] = shares.spring[s] == 0 ? 0 : 1;
    else
      shares.spring[s] /= cells_at_interior(spring_slots[s].kind);
  }
  return shares;
}

/// What no part has, has the share as its weight: it multiplies zero.
void SiteKinds::add_weights_of(const Shares& shares, std::size_t part, SiteWeights& w) const {
  const Constants& k = constants_[part];
  const auto over = [](double of_part, double interior) { return interior == 0 ? 1 : of_part / interior; };
  for (std::size_t group = 0; group < slot_of_group.size(); ++group) {
    const std::size_t s = slot_of_group[group];
    if (interior_stiffness(s) == 0 && !config_.is_solid()) continue;
    const auto kind = static_cast<std::size_t>(spring_slots[s].kind);
    w.spring[group] += shares.spring[s] * over(k.spring[kind], interior_.spring[kind]);
  }
  if (!config_.is_solid()) return;
  w.volume += shares.cell * over(k.volume, interior_.volume);
  w.fold_guard += shares.cell * over(k.fold_guard, interior_.fold_guard);
  w.fill += shares.cell;
}

void SiteKinds::add(const CellsAround& cells) {
  constexpr std::size_t own = 13;
  SiteWeights w;
  std::vector<Shares> shares;  // by part
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    shares.push_back(shares_of(cells, int(part)));
    add_weights_of(shares.back(), part, w);
    w.mass += mass_of_full_corner(part) * shares.back().corner[0];
  }
  w.content = config_.is_solid() ? cells[own] : 0;
  weights_.push_back(w);
  if (!damping_time_) dampings_.push_back(dampings_of(shares));
}

/// Of the kind that is the last so far.
std::array<double, spring_slots.size()> SiteKinds::dampings_of(const std::vector<Shares>& shares) const {
  std::array<double, 8> mass{};  // of the cell's corners
  for (std::size_t part = 0; part < parts_.size(); ++part)
    for (std::size_t c = 0; c < mass.size(); ++c)
      mass[c] += mass_of_full_corner(part) * shares[part].corner[c];
  std::array<double, spring_slots.size()> dampings{};
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    const auto [a, b, kind] = spring_slots[s];
    const double k = stiffness(std::uint32_t(weights_.size() - 1), s);
    for (std::size_t part = 0; part < parts_.size() && k != 0; ++part) {
      const double of_part = shares[part].spring[s] * constants_[part].spring[static_cast<std::size_t>(kind)];
      if (of_part == 0) continue;
      dampings[s] +=
          of_part / k *
          parts_[part].damping.coefficient(k, mass[std::size_t(a)], mass[std::size_t(b)],
                                           config_.rest_length(kind), constants_[part].shear_modulus);
    }
  }
  return dampings;
}

SiteElements SiteKinds::elements(std::uint32_t kind) const {
  const SiteWeights& w = weights_[kind];
  SiteElements e{.volume = w.volume * interior_.volume, .fold_guard = w.fold_guard * interior_.fold_guard};
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    e.stiffness[s] = stiffness(kind, s);
    e.damping[s] = damping_time_ ? *damping_time_ * e.stiffness[s] : dampings_[kind][s];
  }
  return e;
}

}  // namespace mss
