#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace mss {

/// A spring assigned to the cell at a site, as a pair of that cell's corners (c = bx + 2 by + 4 bz).
struct SpringSlot {
  enum class Class : std::uint8_t { edge, face, body };
  int a;
  int b;
  Class kind;
};

/// The thirteen springs per site: every spring of a body lies in exactly one slot of exactly one site.
inline constexpr std::array<SpringSlot, 13> spring_slots{{
    {0, 1, SpringSlot::Class::edge},
    {0, 2, SpringSlot::Class::edge},
    {0, 4, SpringSlot::Class::edge},
    {0, 3, SpringSlot::Class::face},  // the diagonals that `one_diagonal` keeps
    {0, 5, SpringSlot::Class::face},
    {0, 6, SpringSlot::Class::face},
    {1, 2, SpringSlot::Class::face},
    {1, 4, SpringSlot::Class::face},
    {2, 4, SpringSlot::Class::face},
    {0, 7, SpringSlot::Class::body},
    {1, 6, SpringSlot::Class::body},
    {2, 5, SpringSlot::Class::body},
    {3, 4, SpringSlot::Class::body},
}};

/// Rest length of a spring over the edge of its cell.
constexpr double length_over_edge(SpringSlot::Class kind) {
  constexpr std::array<double, 3> factors{1.0, 1.4142135623730951, 1.7320508075688772};
  return factors[static_cast<std::size_t>(kind)];
}

/// How many cells share an interior spring.
constexpr int cells_at_interior(SpringSlot::Class kind) {
  constexpr std::array<int, 3> cells{4, 2, 1};
  return cells[static_cast<std::size_t>(kind)];
}

/// Springs of a site that the same cells share have equal weights: the three edges, the diagonals of the
/// three faces, and the body diagonals. Of each group a slot.
inline constexpr int spring_groups = 7;
inline constexpr std::array<std::uint8_t, spring_groups> slot_of_group{0, 1, 2, 3, 4, 5, 9};

inline constexpr std::array<std::uint8_t, spring_slots.size()> group_of_slot{0, 1, 2, 3, 4, 5, 3,
                                                                             4, 5, 6, 6, 6, 6};

}  // namespace mss
