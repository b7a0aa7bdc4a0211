// What a picture in small cells needs of a lattice in large ones: row by row, first across, then along x.
#include "experiments/studies/reduce/drawing.hpp"

#include <algorithm>

namespace mss::studies::reduce {

Trilinear::Trilinear(const Body& coarse, const Body& fine)
    : coarse_(coarse.lattice()), fine_(fine.lattice()), row_(std::size_t(coarse_.row)) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (int i = 0; i <= fine_.cells[axis]; ++i) {
      const double at = double(i) * coarse_.cells[axis] / fine_.cells[axis];
      const int lower = std::min(int(at + 1e-9), coarse_.cells[axis] - 1);
      between_[axis].push_back({lower, at - lower});
    }
  for (const Between& x : between_[0]) lower_.push_back(x.lower), share_.push_back(x.share);
}

void Trilinear::draw(const Field<double>& coarse, Field<double>& x) {
  const std::ptrdiff_t count = fine_.row;
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k <= fine_.cells[2]; ++k)
      for (int j = 0; j <= fine_.cells[1]; ++j) {
        const Between &y = between_[1][std::size_t(j)], &z = between_[2][std::size_t(k)];
        const double* below = coarse.axis(axis) + coarse_.site(0, y.lower, z.lower);
        const double* above = below + coarse_.plane;
        const double far = y.share * (1 - z.share), up = (1 - y.share) * z.share, both = y.share * z.share,
                     near = (1 - y.share) * (1 - z.share);
        double* row = row_.data();
        for (std::ptrdiff_t i = 0; i < coarse_.row; ++i)
          row[i] =
              near * below[i] + far * below[i + coarse_.row] + up * above[i] + both * above[i + coarse_.row];
        double* out = x.axis(axis) + fine_.site(0, j, k);
        for (std::ptrdiff_t i = 0; i < count; ++i) {
          const double* from = row + lower_[std::size_t(i)];
          out[i] = from[0] + share_[std::size_t(i)] * (from[1] - from[0]);
        }
      }
}

}  // namespace mss::studies::reduce
