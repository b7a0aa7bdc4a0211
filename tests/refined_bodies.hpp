#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/refinement/refined_body.hpp"
#include "tests/random_bodies.hpp"

namespace mss::testing {

/// A box in cells, from the lower corner of a body.
inline RefinedBox box_of_cells(const BodyConfig& body, const Vec3& lower, const Vec3& upper, int levels) {
  return {{body.origin + body.cell_size * lower, body.origin + body.cell_size * upper}, levels};
}

/// A body with smaller cells in boxes of its cells.
struct RefinedCase {
  std::string name;
  BodyConfig config;
  std::vector<RefinedBox> boxes;

  RefinedBody make() const { return {config, refinement_of(config, boxes)}; }
};

/// One size beside another and three sizes; of several parts, of which one's viscosity goes with the size of
/// its cells; a body with holes; smaller cells apart from each other, and everywhere.
inline std::vector<RefinedCase> refined_cases() {
  const BodyConfig block = test_config(VoxelGrid::box(5, 4, 4));
  BodyConfig parts = block, holes = block, pieces = block;
  add_parts(parts);
  for (const int part : {0, 1, 2}) parts.contents.push_back({{part, CellFill::even(part == 1 ? 0.5F : 1)}});
  for (int cell = 0; cell < 5 * 4 * 4; ++cell) parts.content_of.push_back(std::uint32_t(cell / 7 % 3));
  for (const auto& [i, j, k] : {std::array{1, 1, 1}, std::array{3, 2, 0}, std::array{4, 3, 3}})
    holes.voxels.set(i, j, k, false);
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j) pieces.voxels.set(2, j, k, false);
  const auto box = [&](const Vec3& lower, const Vec3& upper, int levels = 1) {
    return box_of_cells(block, lower, upper, levels);
  };
  return {{"half", block, {box({0, 0, 0}, {2, 4, 4})}},
          {"corner", block, {box({0, 0, 0}, {1, 1, 1}, 2), box({1, 1, 1}, {3, 3, 2})}},
          {"parts", parts, {box({1, 0, 0}, {3, 3, 2}), box({2, 0, 1}, {3, 1, 2}, 2)}},
          {"holes", holes, {box({0, 0, 0}, {2, 2, 2}), box({4, 3, 2}, {5, 4, 3})}},
          {"pieces", pieces, {box({0, 0, 0}, {2, 4, 4}, 2)}},
          {"everywhere", block, {box({0, 0, 0}, {5, 4, 4}), box({2, 1, 1}, {3, 3, 3}, 2)}}};
}

}  // namespace mss::testing
