#include "reference/fem/corotated.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "reference/fem/principal.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;

/// Cofactors: det F times the inverse's transpose.
Matrix3d cofactors(const Matrix3d& f) {
  Matrix3d c;
  for (int i = 0; i < 3; ++i) c.col(i) = f.col((i + 1) % 3).cross(f.col((i + 2) % 3));
  return c;
}

constexpr int most_iterations = 12;
constexpr double near = 1e-8;  ///< its square is rounding

/// The rotation of an F with det F > 0 by Newton's iteration, five steps or so where strains are small
/// (Higham, SIAM J. Sci. Stat. Comput. 7 (1986) 1160); none where it takes many.
std::optional<Matrix3d> nearest_rotation(const Matrix3d& f) {
  Matrix3d r = f;
  for (int i = 0; i < most_iterations; ++i) {
    const Matrix3d cofactor = cofactors(r);
    const double determinant = r.col(0).dot(cofactor.col(0));
    if (!(determinant > 0)) return std::nullopt;
    const Matrix3d next = (r + cofactor / determinant) / 2;
    const double change = (next - r).squaredNorm();
    r = next;
    if (change < near * near) return r;
  }
  return std::nullopt;
}

}  // namespace

Matrix3d rotation_of(const Matrix3d& f) {
  if (const std::optional<Matrix3d> rotation = nearest_rotation(f)) return *rotation;
  const PrincipalFrame frame = principal_frame(f);
  return frame.u * frame.v.transpose();
}

namespace {

/// A matrix at each Gauss point, number by number, so that the points are computed side by side.
struct SideBySide {
  static constexpr std::size_t points = std::tuple_size_v<PointMatrices>;
  using OfPoints = std::array<double, points>;
  std::array<OfPoints, 9> numbers;

  explicit SideBySide(const PointMatrices& matrices) {
    for (std::size_t n = 0; n < 9; ++n)
      for (std::size_t p = 0; p < points; ++p) numbers[n][p] = matrices[p].data()[n];
  }

  /// A step of Newton's iteration for the rotation at every point; returns the largest change's square, not a
  /// number where there is no rotation. As nearest_rotation().
  double step_to_rotation() {
    OfPoints changes;  // columns (a b c), (d e f), (g h i)
    const OfPoints &a = numbers[0], &b = numbers[1], &c = numbers[2], &d = numbers[3], &e = numbers[4],
                   &f = numbers[5], &g = numbers[6], &h = numbers[7], &i = numbers[8];
#pragma omp simd
    for (std::size_t p = 0; p < points; ++p) {
      const double next[9] = {
          e[p] * i[p] - f[p] * h[p], f[p] * g[p] - d[p] * i[p], d[p] * h[p] - e[p] * g[p],
          h[p] * c[p] - i[p] * b[p], i[p] * a[p] - g[p] * c[p], g[p] * b[p] - h[p] * a[p],
          b[p] * f[p] - c[p] * e[p], c[p] * d[p] - a[p] * f[p], a[p] * e[p] - b[p] * d[p]};
      const double determinant = a[p] * next[0] + b[p] * next[1] + c[p] * next[2];
      const double half = determinant > 0 ? 0.5 / determinant : std::numeric_limits<double>::quiet_NaN();
      double change = 0;
      for (std::size_t n = 0; n < 9; ++n) {
        const double before = numbers[n][p], after = 0.5 * before + half * next[n];
        change += (after - before) * (after - before);
        numbers[n][p] = after;
      }
      changes[p] = change;
    }
    double largest = 0;
    for (const double change : changes) {
      if (std::isnan(change)) return change;
      largest = std::max(largest, change);
    }
    return largest;
  }
};

}  // namespace

/// Where Newton's iteration fails at a point, as it does in cells that are inverted, one by one.
PointMatrices rotations_of(const PointMatrices& f) {
  SideBySide r(f);
  double change = 1;
  for (int i = 0; i < most_iterations && change >= near * near; ++i) change = r.step_to_rotation();
  PointMatrices rotations;
  for (std::size_t p = 0; p < f.size(); ++p) {
    if (change < near * near)
      for (std::size_t n = 0; n < 9; ++n) rotations[p].data()[n] = r.numbers[n][p];
    else
      rotations[p] = rotation_of(f[p]);
  }
  return rotations;
}

namespace {

/// Where two stretches sum to zero the rotation is undefined, and so is its derivative.
Matrix9 stiffness_by_axes(const CorotatedStress& m, const Matrix3d& f, bool projected) {
  const PrincipalFrame frame = principal_frame(f);
  const Vec3& s = frame.stretches;
  PrincipalStiffness p{
      2 * m.mu * Matrix3d::Identity() + m.slope * Matrix3d::Ones(), Vec3::Constant(2 * m.mu), {}};
  for (int k = 0; k < 3; ++k) {
    const double sum = s[(k + 1) % 3] + s[(k + 2) % 3];
    const double divisor = std::abs(sum) > 1e-9 ? sum : std::copysign(1e-9, sum);
    p.sums[k] = 2 * m.mu + (2 * (m.constant + m.slope * (s.sum() - 3)) - 4 * m.mu) / divisor;
  }
  return stiffness_matrix(frame, p, projected);
}

}  // namespace

/// The same without principal axes: with T = R^T F, dR = R [w]x where (tr(T) I - T) w_k = <R [e_k]x, dF>, so
/// that dP/dF = 2 mu I + slope vec(R) vec(R)^T + Q (twist - mu I) Q^T, with columns vec(R [e_k]x) in Q and
/// twist = mu I + (constant + slope theta - 2 mu) (tr(T) I - T)^-1, whose eigenvalues are half of dP/dF's.
Matrix9 CorotatedStress::stiffness(const Matrix3d& f, bool projected) const {
  const std::optional<Matrix3d> r = nearest_rotation(f);
  if (!r) return stiffness_by_axes(*this, f, projected);
  const Matrix3d stretch = r->transpose() * f, turn = stretch.trace() * Matrix3d::Identity() - stretch;
  Matrix3d twist = (constant + slope * (stretch.trace() - 3) - 2 * mu) * turn.inverse();
  twist = (twist + twist.transpose()).eval() / 2 + mu * Matrix3d::Identity();
  if (projected && !(twist.llt().info() == Eigen::Success)) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(twist);
    twist = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
            eigen.eigenvectors().transpose();
  }
  twist -= mu * Matrix3d::Identity();
  Eigen::Matrix<double, 9, 3> q = Eigen::Matrix<double, 9, 3>::Zero();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Index i = (k + 1) % 3, j = (k + 2) % 3;  // [e_k]x e_i = e_j, [e_k]x e_j = -e_i
    q.block<3, 1>(3 * i, k) = r->col(j);
    q.block<3, 1>(3 * j, k) = -r->col(i);
  }
  const Eigen::Map<const Eigen::Matrix<double, 9, 1>> as_vector(r->data());
  const Eigen::Matrix<double, 9, 3> turned = q * twist;
  Matrix9 d = slope * as_vector * as_vector.transpose();
  d.noalias() += turned.lazyProduct(q.transpose());
  d.diagonal().array() += 2 * mu;
  return d;
}

}  // namespace mss
