#include "core/body/cell_springs.hpp"

#include "core/body/fill_shares.hpp"

namespace mss {

namespace {

constexpr int axes_between(int a, int b) {
  return corner_bit(a ^ b, 0) + corner_bit(a ^ b, 1) + corner_bit(a ^ b, 2);
}

/// The 28 pairs of corners.
CellSprings::Springs all_springs() {
  CellSprings::Springs all{};
  std::size_t next = 0;
  for (int a = 0; a < 8; ++a)
    for (int b = a + 1; b < 8; ++b)
      all[next++] = {.a = a, .b = b, .kind = static_cast<SpringSlot::Class>(axes_between(a, b) - 1)};
  return all;
}

/// Corner of a cell whose site has the spring between two others.
constexpr int corner_of_owner(int a, int b) { return a & b; }

/// The spring's slot there.
constexpr std::size_t slot_of(int a, int b) {
  const int owner = corner_of_owner(a, b);
  std::size_t slot = 0;
  while (spring_slots[slot].a != (a ^ owner) || spring_slots[slot].b != (b ^ owner)) ++slot;
  return slot;
}

double constant_of(const SpringConstants& springs, SpringSlot::Class kind) {
  switch (kind) {
    case SpringSlot::Class::edge:
      return springs.edge;
    case SpringSlot::Class::face:
      return springs.face;
    default:
      return springs.body;
  }
}

}  // namespace

CellSprings::CellSprings(const Body& body)
    : body_(body),
      springs_(all_springs()),
      by_content_(body.config().sharing == Sharing::weighted && body.kinds().damping_time().has_value()) {}

const CellSprings::Springs& CellSprings::at(std::ptrdiff_t site) {
  const std::uint32_t content = body_.weights_at(site).content;
  if (by_content_ && content == content_) return springs_;
  content_ = content;
  find_given(site);
  if (!by_content_) divide(site);
  return springs_;
}

/// Stiffness that a cell of a content gives a spring which it shares by weight.
double CellSprings::given(const CellSpring& spring, const CellContent& content) const {
  const std::size_t slot = slot_of(spring.a, spring.b);
  if (body_.kinds().interior_stiffness(slot) == 0) return 0;
  double sum = 0;
  for (const auto& [part, fill] : content)
    sum += spring_share(fill, spring.a, spring.b, body_.config().springs_floor()) *
           constant_of(body_.parts()[std::size_t(part)].springs, spring.kind);
  return sum / cells_at_interior(spring.kind);
}

void CellSprings::find_given(std::ptrdiff_t site) {
  const CellContent& content = body_.content_at(site);
  const double seconds = body_.kinds().damping_time().value_or(0);
  for (CellSpring& spring : springs_) {
    spring.stiffness = given(spring, content);
    spring.damping = seconds * spring.stiffness;
  }
}

int CellSprings::cells_that_share(const CellSpring& spring, std::ptrdiff_t site) const {
  const Lattice& lattice = body_.lattice();
  int cells = 0;
  for (int to = 0; to < 8; ++to) {  // axes along which the other cell is beside this one
    if ((to & (spring.a ^ spring.b)) != 0) continue;
    const std::ptrdiff_t other = site + lattice.corner(to & spring.a) - lattice.corner(to & ~spring.a);
    cells += int(other >= 0 && body_.has_cell(other));
  }
  return cells;
}

/// What depends on the cells around: shares of springs with Sharing::uniform, and of dampers.
void CellSprings::divide(std::ptrdiff_t site) {
  std::array<SiteElements, 8> elements;
  for (int c = 0; c < 8; ++c) elements[std::size_t(c)] = body_.elements_at(site + body_.lattice().corner(c));
  for (CellSpring& spring : springs_) {
    const SiteElements& owner = elements[std::size_t(corner_of_owner(spring.a, spring.b))];
    const std::size_t slot = slot_of(spring.a, spring.b);
    const double whole = owner.stiffness[slot];
    if (body_.config().sharing == Sharing::uniform) spring.stiffness = whole / cells_that_share(spring, site);
    spring.damping = whole == 0 ? 0 : owner.damping[slot] * spring.stiffness / whole;
  }
}

}  // namespace mss
