// Which cells of the problems' bodies are smaller, where no estimate says so.
#include "experiments/studies/refine/maps.hpp"

namespace mss::studies::refine {

RefinementMap split_near(const BodyConfig& body, const std::function<double(const Vec3&)>& distance,
                         int levels) {
  RefinementMap map;
  constexpr double cells = 2;
  const auto split = [&](auto&& self, int depth, const RefinementMap::Cell& cell) -> void {
    const double edge = std::ldexp(body.cell_size, -depth);
    const Vec3 middle = body.origin + edge * (Vec3(cell[0], cell[1], cell[2]) + Vec3::Constant(0.5));
    if (depth == levels || distance(middle) > cells * edge) return;
    map.split(depth, cell);
    for (int c = 0; c < 8; ++c)
      self(self, depth + 1,
           {2 * cell[0] + corner_bit(c, 0), 2 * cell[1] + corner_bit(c, 1), 2 * cell[2] + corner_bit(c, 2)});
  };
  for (int k = 0; k < body.voxels.nz(); ++k)
    for (int j = 0; j < body.voxels.ny(); ++j)
      for (int i = 0; i < body.voxels.nx(); ++i)
        if (body.voxels.at(i, j, k)) split(split, 0, {i, j, k});
  return map;
}

RefinementMap split_surface(const BodyConfig& body) {
  RefinementMap map;
  const VoxelGrid& voxels = body.voxels;
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i) {
        const bool inside = voxels.at(i - 1, j, k) && voxels.at(i + 1, j, k) && voxels.at(i, j - 1, k) &&
                            voxels.at(i, j + 1, k) && voxels.at(i, j, k - 1) && voxels.at(i, j, k + 1);
        if (voxels.at(i, j, k) && !inside) map.split(0, {i, j, k});
      }
  return map;
}

}  // namespace mss::studies::refine
