#include "core/body/body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "core/base/error.hpp"
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

struct HashCells {
  std::size_t operator()(const std::array<std::uint32_t, 27>& cells) const {
    std::size_t hash = 14695981039346656037U;  // FNV-1a
    for (const std::uint32_t content : cells) hash = (hash ^ content) * 1099511628211U;
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

double corner_share(const CellFill& fill, int corner, double floor) {
  return blend(double(fill.corner[std::size_t(corner)]), floor, mean_of(fill.corner));
}

bool BodyConfig::is_full() const {
  const CellContent full{PartFill{}};
  return std::all_of(contents.begin(), contents.end(),
                     [&](const CellContent& content) { return content == full; });
}

void resample(BodyConfig& body, int before, int after) {
  const VoxelGrid from = body.voxels;
  const std::vector<std::uint32_t> content_of = std::move(body.content_of);
  body.voxels = VoxelGrid(from.nx() / before * after, from.ny() / before * after, from.nz() / before * after);
  body.content_of.clear();
  for (int k = 0; k < body.voxels.nz(); ++k)
    for (int j = 0; j < body.voxels.ny(); ++j)
      for (int i = 0; i < body.voxels.nx(); ++i) {
        const int x = i / after * before, y = j / after * before, z = k / after * before;
        body.voxels.set(i, j, k, from.at(x, y, z));
        if (!content_of.empty()) body.content_of.push_back(content_of[from.index(x, y, z)]);
      }
}

/// What the cells around a site have of one part, in full cells.
struct Body::Shares {
  std::array<double, spring_slots.size()> spring{};
  std::array<double, 8> corner{};  ///< of its own cell, for masses
  double cell = 0;
};

namespace {

/// The planes of a body that a rank has, of the whole body's lattice: its share, and a ghost plane on each
/// side where there are others.
PlaneRange planes_with_ghosts(const Communicator& ranks, int planes) {
  if (ranks.count() > planes)
    throw InputError(fmt::format("{} ranks share a body of {} planes of particles along z; give at most {}",
                                 ranks.count(), planes, planes));
  const auto [first, last] = ranks.share_of(planes);
  return {ranks.is_lowest() ? first : first - 1, ranks.is_highest() ? last : last + 1};
}

PlaneRange shifted(PlaneRange planes, int by) { return {planes.first + by, planes.last + by}; }

}  // namespace

Body::Body(const BodyConfig& config, const Communicator& ranks)
    : config_(config),
      ranks_(ranks),
      planes_(planes_with_ghosts(ranks, config.voxels.nz() + 1)),
      own_(shifted(ranks.share_of(config.voxels.nz() + 1), -planes_.first)),
      lattice_(config.voxels.nx(), config.voxels.ny(), planes_.last - planes_.first - 1),
      parts_(config.all_parts()),
      springs_floor_(config.springs_floor()),
      mass_floor_(config.mass_floor()) {
  check_contents();
  find_constants();
  find_damping_time();
  find_particles();
  classify_sites();
  check_masses();
  add_weights();
}

void Body::check_contents() const {
  if (config_.content_of.empty() && config_.contents.empty()) return;
  if (config_.sharing != Sharing::weighted)
    throw InputError(
        "fill factors and parts need springs that cells share by weight (sharing = \"weighted\")");
  for (std::size_t content = 0; content < config_.contents.size(); ++content) check_content(content);
  const VoxelGrid& voxels = config_.voxels;
  const auto boxed = std::size_t(voxels.nx()) * std::size_t(voxels.ny()) * std::size_t(voxels.nz());
  if (config_.content_of.size() != boxed)
    throw InputError(fmt::format("contents of {} cells for a box of {}", config_.content_of.size(), boxed));
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i)
        if (voxels.at(i, j, k) && content(i, j, k) > config_.contents.size())
          throw InputError(fmt::format("cell ({}, {}, {}) has content {} of {}", i, j, k,
                                       content(i, j, k) - 1, config_.contents.size()));
}

void Body::check_content(std::size_t content) const {
  constexpr float rounding = 1e-5F;
  CellFill all{};
  for (const auto& [part, fill] : config_.contents[content]) {
    if (part < 0 || std::size_t(part) >= parts_.size())
      throw InputError(
          fmt::format("content {} is of part {}, and there are {}", content, part, parts_.size()));
    for (std::size_t c = 0; c < 8; ++c) {
      if (!(fill.octant[c] >= 0 && fill.corner[c] >= 0 && std::isfinite(fill.corner[c])))
        throw InputError(fmt::format("content {} fills {} of an octant and gives its corner {} of a mass",
                                     content, fill.octant[c], fill.corner[c]));
      all.octant[c] += fill.octant[c];
    }
  }
  if (const float most = *std::max_element(all.octant.begin(), all.octant.end());
      !(most > 0 && most <= 1 + rounding))
    throw InputError(
        fmt::format("content {} fills {} of an octant; allowed is more than 0, at most 1", content, most));
}

/// From 1; 0 where there is no cell.
std::uint32_t Body::content(int i, int j, int k) const {
  if (!config_.voxels.at(i, j, k)) return 0;
  return config_.content_of.empty() ? 1 : 1 + config_.content_of[config_.voxels.index(i, j, k)];
}

const CellContent& Body::content_of(std::uint32_t content) const {
  static const CellContent full{PartFill{}};
  return config_.contents.empty() ? full : config_.contents[content - 1];
}

void Body::find_constants() {
  const auto take_largest = [](double& interior, double of_part) {
    if (std::abs(of_part) > std::abs(interior)) interior = of_part;
  };
  for (const Part& part : parts_) {
    const auto& [edge, face, body, volume] = part.springs;
    const double shear_modulus = cubic_stiffness(part.springs, config_.cell_size).c44;
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
void Body::find_damping_time() {
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

/// Each rank goes through all cells, so that sums over them are everywhere the same.
void Body::find_particles() {
  particle_.assign(std::size_t(lattice_.size), -1);
  std::vector<double> filled(parts_.size());  // by mass
  const VoxelGrid& voxels = config_.voxels;
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i) {
        if (!voxels.at(i, j, k)) continue;
        ++cells_;
        for (const auto& [part, fill] : content_of(content(i, j, k))) {
          filled_cells_ += mean_of(fill.octant);
          filled[std::size_t(part)] += mean_of(fill.corner);
        }
        const int plane = k - planes_.first;
        const std::ptrdiff_t site = lattice_.site(i, j, plane);
        for (int c = 0; c < 8; ++c)
          if (is_own(plane + (c >> 2))) particle_[std::size_t(site + lattice_.corner(c))] = 0;
      }
  for (std::size_t part = 0; part < parts_.size(); ++part)
    mass_of_cells_ += parts_[part].density * filled[part] * cell_volume();
  for (std::ptrdiff_t site = lattice_.plane * own_.first; site < lattice_.plane * own_.last; ++site)
    if (int& particle = particle_[std::size_t(site)]; particle == 0) {
      particle = int(site_of_.size());
      site_of_.push_back(site);
    }
}

namespace {

/// Whether there is a particle amid 27 cells, at the lower corner of the one in the middle.
bool touches_cell(const std::array<std::uint32_t, 27>& cells) {
  for (int cell = 0; cell < 27; ++cell)
    if (is_in(cells_of_corner[0], cell) && cells[std::size_t(cell)] != 0) return true;
  return false;
}

}  // namespace

/// Each rank goes through all sites, so that kinds are everywhere the same.
void Body::classify_sites() {
  kind_.assign(std::size_t(lattice_.size), 0);
  // The set contains numbers of neighbourhoods, which lie in a row: of a mesh's surface there are many.
  std::vector<Neighbourhood> kinds{{}};  // kind 0: nothing
  add_kind(kinds.front());
  const auto hash = [&](std::uint32_t kind) { return HashCells()(kinds[kind]); };
  const auto equal = [&](std::uint32_t a, std::uint32_t b) { return kinds[a] == kinds[b]; };
  std::unordered_set<std::uint32_t, decltype(hash), decltype(equal)> known({0}, 16, hash, equal);
  // All springs of a site touch its own cell's faces at the particle or lie in it; masses of the other
  // corners matter to dampers alone.
  const bool by_mass = config_.any_part([](const Part& part) {
    return part.damping.law == Damping::Law::ratio || part.damping.law == Damping::Law::thesis;
  });
  const std::uint32_t relevant = by_mass ? (1U << 27U) - 1 : cells_of_corner[0];
  const VoxelGrid& voxels = config_.voxels;
  for (int k = 0; k <= voxels.nz(); ++k)
    for (int j = 0; j <= voxels.ny(); ++j) {
      Neighbourhood cells{};
      const auto add_column = [&](int i) {  // moves on along x
        for (std::size_t row = 0; row < 9; ++row) {
          std::copy_n(&cells[3 * row + 1], 2, &cells[3 * row]);
          cells[3 * row + 2] = content(i, j + int(row) % 3 - 1, k + int(row) / 3 - 1);
        }
      };
      add_column(0);
      const int plane = k - planes_.first;
      for (int i = 0; i <= voxels.nx(); ++i) {
        add_column(i + 1);
        if (is_own(plane) ? particle(lattice_.site(i, j, plane)) < 0 : !touches_cell(cells)) continue;
        Neighbourhood& key = kinds.emplace_back();
        for (int cell = 0; cell < 27; ++cell)
          if (is_in(relevant, cell)) key[std::size_t(cell)] = cells[std::size_t(cell)];
        const auto [kind, is_new] = known.insert(std::uint32_t(kinds.size() - 1));
        if (is_new)
          add_kind(key);
        else
          kinds.pop_back();
        if (is_here(plane)) kind_[std::size_t(lattice_.site(i, j, plane))] = *kind;
      }
    }
  weights_.shrink_to_fit();
  dampings_.shrink_to_fit();
  ranks_.add_in_order(springs_, [&] { for_each_spring([&](auto&&...) { ++springs_; }); });
}

/// A particle in empty octants has mass by the floor b alone.
void Body::check_masses() const {
  for (const std::ptrdiff_t site : site_of_)
    if (!(weights_at(site).mass > 0))
      throw InputError("a particle has no mass: give its cells more, or fill_blend_mass above 0");
}

void Body::add_weights() {
  if (config_.weights.empty()) return;
  weight_.assign(std::size_t(lattice_.size), 0);
  for (const Weight& weight : config_.weights) {
    const std::vector<std::ptrdiff_t> sites = select(weight.box.lower, weight.box.upper);
    std::size_t count = 0;
    ranks_.add_in_order(count, [&] { count += sites.size(); });
    for (const std::ptrdiff_t site : sites) weight_[std::size_t(site)] += weight.mass / double(count);
    if (count > 0) all_weights_ += weight.mass;
  }
}

double Body::interior_stiffness(std::size_t slot) const {
  return in_topology(config_.topology, slot)
             ? interior_.spring[static_cast<std::size_t>(spring_slots[slot].kind)]
             : 0;
}

Body::Shares Body::shares_of(const Neighbourhood& cells, int part) const {
  constexpr std::array<double, 3> cells_of_interior_spring{4, 2, 1};
  constexpr std::size_t own = 13;
  Shares shares;
  for (int cell = 0; cell < 27; ++cell) {
    if (cells[std::size_t(cell)] == 0) continue;
    for (const auto& [of_part, fill] : content_of(cells[std::size_t(cell)])) {
      if (of_part != part) continue;
      const double share = mean_of(fill.octant);
      if (cell == own) shares.cell += share;
      for (std::size_t s = 0; s < spring_slots.size(); ++s) {
        if (!is_in(cells_of_slot[s], cell)) continue;
        const auto [a, b, kind] = spring_slots[s];
        shares.spring[s] +=
            blend(filled_at(fill, corner_in(cell, a), corner_in(cell, b)), springs_floor_, share);
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
      shares.spring[s] /= cells_of_interior_spring[static_cast<std::size_t>(spring_slots[s].kind)];
  }
  return shares;
}

/// What no part has, has the share as its weight: it multiplies zero.
void Body::add_weights_of(const Shares& shares, std::size_t part, SiteWeights& w) const {
  const Constants& k = constants_[part];
  const auto over = [](double of_part, double interior) { return interior == 0 ? 1 : of_part / interior; };
  for (std::size_t group = 0; group < slot_of_group.size(); ++group) {
    const std::size_t s = slot_of_group[group];
    const auto kind = static_cast<std::size_t>(spring_slots[s].kind);
    w.spring[group] += shares.spring[s] * over(k.spring[kind], interior_.spring[kind]);
  }
  w.volume += shares.cell * over(k.volume, interior_.volume);
  w.fold_guard += shares.cell * over(k.fold_guard, interior_.fold_guard);
  w.fill += shares.cell;
}

void Body::add_kind(const Neighbourhood& cells) {
  constexpr std::size_t own = 13;
  SiteWeights w;
  std::vector<Shares> shares;  // by part
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    shares.push_back(shares_of(cells, int(part)));
    add_weights_of(shares.back(), part, w);
    w.mass += mass_of_full_corner(part) * shares.back().corner[0];
  }
  w.content = cells[own];
  weights_.push_back(w);
  if (!damping_time_) dampings_.push_back(dampings_of(shares));
}

/// Of the kind that is the last so far.
std::array<double, spring_slots.size()> Body::dampings_of(const std::vector<Shares>& shares) const {
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
      dampings[s] += of_part / k *
                     parts_[part].damping.coefficient(k, mass[std::size_t(a)], mass[std::size_t(b)],
                                                      rest_length(kind), constants_[part].shear_modulus);
    }
  }
  return dampings;
}

SiteElements Body::elements(std::uint32_t kind) const {
  const SiteWeights& w = weights_[kind];
  SiteElements e{.volume = w.volume * interior_.volume, .fold_guard = w.fold_guard * interior_.fold_guard};
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    e.stiffness[s] = stiffness(kind, s);
    e.damping[s] = damping_time_ ? *damping_time_ * e.stiffness[s] : dampings_[kind][s];
  }
  return e;
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

}  // namespace mss
