#include "integrators/nonlinear/curvature_pairs.hpp"

#include <algorithm>

namespace mss {

void CurvaturePairs::push(const PairProducts& s_with_y, const PairProducts& u_with_y) {
  sy.col(count) = s_with_y;
  uy.col(count) = u_with_y;
  if (++count <= kept) return;
  --count;
  std::rotate(s.begin(), s.begin() + 1, s.begin() + kept + 1);
  std::rotate(u.begin(), u.begin() + 1, u.begin() + kept + 1);
  sy.topLeftCorner<most_pairs, most_pairs>() = sy.bottomRightCorner<most_pairs, most_pairs>().eval();
  uy.topLeftCorner<most_pairs, most_pairs>() = uy.bottomRightCorner<most_pairs, most_pairs>().eval();
}

void CurvaturePairs::expand(const PairProducts& sg, const PairProducts& ug, PairProducts& of_s,
                            PairProducts& of_u) const {
  of_s.setZero();
  of_u.setZero();
  for (int i = count - 1; i >= 0; --i) {  // q = g + sum of_u y
    double sq = sg[i];
    for (int j = i + 1; j < count; ++j) sq += of_u[j] * sy(i, j);
    of_u[i] = -sq / sy(i, i);
  }
  for (int i = 0; i < count; ++i) {  // B q + sum of_s s
    double yr = ug[i];
    for (int j = 0; j < count; ++j) yr += of_u[j] * uy(std::min(i, j), std::max(i, j));
    for (int j = 0; j < i; ++j) yr += of_s[j] * sy(j, i);
    of_s[i] = -of_u[i] - yr / sy(i, i);
  }
}

void CurvaturePairs::conjugate(const PairProducts& ug, PairProducts& of_s, PairProducts& of_u) const {
  of_s.setZero();
  of_u.setZero();
  if (count > 0) of_s[count - 1] = -ug[count - 1] / sy(count - 1, count - 1);
}

}  // namespace mss
