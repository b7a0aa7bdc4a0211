#include "integrators/device/xpbd_steps.hpp"

#include <algorithm>
#include <map>

namespace mss {

namespace {

/// What the constraints of a cell, or of a site with springs, depend on beside the step: the kind of its
/// elements, and the inverse masses of the corners that these move [1/kg], 0 of those held along all axes.
struct CellKind {
  std::uint32_t elements = 0;
  std::uint32_t moves = 0;  ///< corners, a bit each
  std::array<double, 8> mobility{};

  friend bool operator<(const CellKind& a, const CellKind& b) {
    return std::tie(a.elements, a.moves, a.mobility) < std::tie(b.elements, b.moves, b.mobility);
  }
};

std::uint32_t moved_corners(const SiteElements& e) {
  std::uint32_t corners = e.volume != 0 ? 255 : 0;
  for (std::size_t s = 0; s < spring_slots.size(); ++s)
    if (e.stiffness[s] != 0 || e.damping[s] != 0)
      corners |= 1U << spring_slots[s].a | 1U << spring_slots[s].b;
  return corners;
}

CellKind kind_at(const Body& body, const HeldSites& held, std::uint32_t moves, std::ptrdiff_t site) {
  CellKind kind{.elements = body.kind(site), .moves = moves};
  for (int c = 0; c < 8; ++c)
    if ((kind.moves >> c & 1) != 0) {
      const std::ptrdiff_t corner = site + body.lattice().corner(c);
      kind.mobility[std::size_t(c)] = held.free_axes(corner).isZero(0) ? 0 : 1 / body.mass(corner);
    }
  return kind;
}

/// A row of the table in core/device/shaders/xpbd.glsl, see Projection in
/// integrators/position_based/xpbd_kernel.hpp.
template <class Real>
void append_constraints(const Body& body, const CellKind& kind, double dt, std::vector<Real>& table) {
  const SiteElements e = body.kinds().elements(kind.elements);
  const auto mobility = [&](int corner) { return kind.mobility[std::size_t(corner)]; };
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    const double stiffness = e.stiffness[s] * dt * dt, damping = e.damping[s] * dt;
    const double g =
        1 / ((stiffness + damping) * (mobility(spring_slots[s].a) + mobility(spring_slots[s].b)) + 1);
    for (const double value : {stiffness * g, damping * g, g}) table.push_back(static_cast<Real>(value));
  }
  table.push_back(static_cast<Real>(e.volume * dt * dt / body.cell_volume()));
}

/// By kind of site.
std::vector<std::uint32_t> moved_corners_of_kinds(const SiteKinds& kinds) {
  std::vector<std::uint32_t> moves;
  for (std::uint32_t kind = 0; kind < kinds.size(); ++kind)
    moves.push_back(moved_corners(kinds.elements(kind)));
  return moves;
}

std::vector<std::ptrdiff_t> sites_with_constraints(const Body& body,
                                                   const std::vector<std::uint32_t>& moves) {
  std::vector<std::ptrdiff_t> sites;
  for (std::ptrdiff_t site = 0; site < body.lattice().sites; ++site)
    if (moves[body.kind(site)] != 0) sites.push_back(site);
  return sites;
}

}  // namespace

template <class Real>
XpbdSteps<Real>::XpbdSteps(const IntegratorOptions& options)
    : DisplacedSteps<Real>(options.dt, std::max(1, options.iterations)),
      keeps_multipliers_(options.iterations > 1) {}

template <class Real>
void XpbdSteps<Real>::begin(DeviceSystem<Real>& system) {
  DisplacedSteps<Real>::begin(system);
  const Body& body = system.springs().body();
  const std::vector<std::uint32_t> moves = moved_corners_of_kinds(body.kinds());
  const SitesByColour& cells = cells_.emplace(body.lattice(), sites_with_constraints(body, moves));
  std::map<CellKind, std::uint32_t> rows;
  std::vector<Real> table;
  std::vector<std::uint32_t> list;
  for (const std::ptrdiff_t site : cells.sites) {
    const CellKind kind = kind_at(body, system.springs().held(), moves[body.kind(site)], site);
    const auto [row, is_new] = rows.try_emplace(kind, std::uint32_t(rows.size()));
    if (is_new) append_constraints(body, kind, this->dt(), table);
    list.push_back(std::uint32_t(site));
    list.push_back(row->second * 256 + kind.moves);
  }
  cell_list_ = memory_of(system.shared_device(), list);
  constraints_ = memory_of(system.shared_device(), table);
  constexpr std::ptrdiff_t constraints_per_cell = 14;
  if (keeps_multipliers_)
    multipliers_ = DeviceMemory(system.shared_device(), std::ptrdiff_t(sizeof(Real)) * constraints_per_cell *
                                                            std::ptrdiff_t(cells.sites.size()));
}

template <class Real>
void XpbdSteps<Real>::displace(DeviceSystem<Real>& system, double t) {
  this->displacement(system, t, {}).run(system.sites());
}

template <class Real>
void XpbdSteps<Real>::begin_passes(DeviceSystem<Real>&) {
  if (keeps_multipliers_) multipliers_.clear();
}

template <class Real>
void XpbdSteps<Real>::pass(DeviceSystem<Real>& system) {
  const std::vector<std::string> words =
      keeps_multipliers_ ? std::vector<std::string>{"KEEP"} : std::vector<std::string>{};
  for (int colour = 0; colour < SitesByColour::colours; ++colour) {
    ShaderProgram& program = system.program(words, {"neighbours", "xpbd"});
    program.set("first_cell", cells_->first[std::size_t(colour)])
        .set("cell_count", int(cells_->sites.size()));
    program.bind(0, system.x()).bind(1, cell_list_).bind(2, constraints_).bind(3, this->u());
    if (keeps_multipliers_) program.bind(4, multipliers_);
    program.run(cells_->count(colour));
    if (auto* contact = this->contact()) contact->project(system, this->dt(), colour, this->u());
  }
}

template class XpbdSteps<float>;
template class XpbdSteps<double>;

}  // namespace mss
