#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/body/body.hpp"

namespace mss {

/// A spring of a cell, as a pair of its corners (c = bx + 2 by + 4 bz), and what the cell has of it.
struct CellSpring {
  int a, b;
  SpringSlot::Class kind;
  double stiffness = 0;  ///< [N/m]; 0 where there is no spring
  double damping = 0;    ///< [kg/s]
};

/// What each cell has of the springs at its corners: 12 edges, 12 face diagonals and 4 body diagonals. All
/// cells together have the body's springs. Of a spring's stiffness a cell has what it gives, see SiteKinds;
/// with Sharing::uniform all that share the spring have as much. Dampers are divided as their springs are.
class CellSprings {
 public:
  static constexpr std::size_t count = 28;
  using Springs = std::array<CellSpring, count>;

  /// The body must outlive these.
  explicit CellSprings(const Body& body);

  /// Of the cell at a site, until the next call.
  const Springs& at(std::ptrdiff_t site);

 private:
  double given(const CellSpring& spring, const CellContent& content) const;
  int cells_that_share(const CellSpring& spring, std::ptrdiff_t site) const;
  void find_given(std::ptrdiff_t site);
  void divide(std::ptrdiff_t site);

  const Body& body_;
  Springs springs_;
  /// Whether cells of equal content have equal springs: then those of the last one are kept.
  bool by_content_;
  std::uint32_t content_ = 0;  ///< of the last cell; 0: there was none
};

}  // namespace mss
