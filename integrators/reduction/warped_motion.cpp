#include "integrators/reduction/warped_motion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace mss {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Functions of t = |theta|^2: R(theta) = I + a K + b K^2 and R~(theta) = I + b K + c K^2, K the cross
/// product with theta; and the derivatives of b and c by t.
struct Rodrigues {
  double a, b, c, db, dc;
};

/// Series up to |theta| = 2, where their last terms are below rounding; closed forms beyond.
Rodrigues rodrigues(double t) {
  if (t > 4) {
    const double angle = std::sqrt(t), sine = std::sin(angle), a = sine / angle,
                 b = (1 - std::cos(angle)) / t, c = (1 - a) / t;
    return {.a = a, .b = b, .c = c, .db = (a - 2 * b) / (2 * t), .dc = (b - 3 * c) / (2 * t)};
  }
  // a = sum (-t)^k / (2k + 1)!, b = sum (-t)^k / (2k + 2)!, c = sum (-t)^k / (2k + 3)!
  Rodrigues r{};
  constexpr int terms = 12;
  double a_k = 1, b_k = 0.5, c_k = 1.0 / 6;
  double power = 1, power_before = 0;
  for (int k = 0; k < terms; ++k) {
    r.a += a_k * power;
    r.b += b_k * power;
    r.c += c_k * power;
    r.db += k * b_k * power_before;
    r.dc += k * c_k * power_before;
    power_before = power;
    power *= t;
    a_k /= -double((2 * k + 2) * (2 * k + 3));
    b_k /= -double((2 * k + 3) * (2 * k + 4));
    c_k /= -double((2 * k + 4) * (2 * k + 5));
  }
  return r;
}

Vec3 at(const VectorXd& rows, Index particles, Index p) {
  return {rows[p], rows[particles + p], rows[2 * particles + p]};
}
void set(VectorXd& rows, Index particles, Index p, const Vec3& value) {
  for (int axis = 0; axis < 3; ++axis) rows[axis * particles + p] = value[axis];
}

/// Particles of a lattice beside others.
class Neighbours {
 public:
  explicit Neighbours(const Body& body) : body_(body) {}

  /// The particle so many sites away along an axis, each step along an edge of a cell; -1 where there is
  /// none.
  int at(std::ptrdiff_t site, int axis, int steps) const {
    const int side = steps < 0 ? -1 : 1;
    for (; steps != 0; steps -= side) {
      const std::ptrdiff_t next = site + side * stride(axis);
      if (!is_edge(side < 0 ? next : site, side < 0 ? site : next, axis)) return -1;
      site = next;
    }
    return body_.particle(site);
  }

  /// The derivative of values by particle along an axis, in cells.
  double difference(const double* values, std::ptrdiff_t site, int axis) const {
    const double here = values[body_.particle(site)];
    const auto value = [&](int steps) { return values[at(site, axis, steps)]; };
    const bool below = at(site, axis, -1) >= 0, above = at(site, axis, 1) >= 0;
    if (below && above) return (value(1) - value(-1)) / 2;
    if (!below && !above) return 0;
    const int side = above ? 1 : -1;
    if (at(site, axis, 2 * side) < 0) return side * (value(side) - here);
    return side * (4 * value(side) - value(2 * side) - 3 * here) / 2;
  }

 private:
  std::ptrdiff_t stride(int axis) const {
    const Lattice& lattice = body_.lattice();
    return axis == 0 ? 1 : axis == 1 ? lattice.row : lattice.plane;
  }

  /// Whether a cell has the edge from a site along an axis: one of the four whose lower corners are there.
  bool is_edge(std::ptrdiff_t lower, std::ptrdiff_t upper, int axis) const {
    const Lattice& lattice = body_.lattice();
    if (lower < 0 || upper >= lattice.sites || body_.particle(lower) < 0 || body_.particle(upper) < 0)
      return false;
    const std::array<int, 3> place = lattice.coordinates(lower);
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    if (place[std::size_t(axis)] >= lattice.cells[std::size_t(axis)]) return false;
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) {
        if (place[std::size_t(b)] < i || place[std::size_t(c)] < j) continue;
        if (body_.has_cell(lower - i * stride(b) - j * stride(c))) return true;
      }
    return false;
  }

  const Body& body_;
};

}  // namespace

MatrixXd half_curls(const Body& body, const MatrixXd& displacements) {
  const Index particles = displacements.rows() / 3;
  const Neighbours neighbours(body);
  MatrixXd curls(displacements.rows(), displacements.cols());
  for (Index column = 0; column < displacements.cols(); ++column) {
    const double* u = displacements.col(column).data();
    for (Index p = 0; p < particles; ++p)
      for (int axis = 0; axis < 3; ++axis) {
        const int next = (axis + 1) % 3, last = (axis + 2) % 3;
        const std::ptrdiff_t site = body.sites()[std::size_t(p)];
        curls(axis * particles + p, column) = (neighbours.difference(u + last * particles, site, next) -
                                               neighbours.difference(u + next * particles, site, last)) /
                                              (2 * body.config().cell_size);
      }
  }
  return curls;
}

WarpedMotion::WarpedMotion(const System<double>& system, const Body& body, const State<double>& rest,
                           const ReducedShapes& shapes, OuterForces outer)
    : ModalMotion(system, rest, shapes, std::move(outer)),
      particles_(shapes.shapes.rows() / 3),
      rotations_(half_curls(body, shapes.shapes)),
      zero_(VectorXd::Zero(rotations_.padded_rows())),
      angles_(zero_),
      shifts_(zero_),
      angle_rates_(zero_),
      shift_rates_(zero_),
      turned_(zero_),
      placed_(zero_) {}

void WarpedMotion::place(const VectorXd& q, VectorXd& rows) const {
  rotations_.expand(zero_, q, angles_);
  panels().expand(zero_, q, shifts_);
  rows = rest_rows();
  for (Index p = 0; p < particles_; ++p) {
    const Vec3 theta = at(angles_, particles_, p), u = at(shifts_, particles_, p);
    const Rodrigues r = rodrigues(theta.squaredNorm());
    const Vec3 once = theta.cross(u);
    set(rows, particles_, p, at(rows, particles_, p) + u + r.b * once + r.c * theta.cross(once));
  }
}

void WarpedMotion::draw(Field<double>& x) const {
  place(q_, placed_);
  rows().write(placed_, x);
}

void WarpedMotion::move(const VectorXd& q, const VectorXd& rates, VectorXd& rows) const {
  rotations_.expand(zero_, q, angles_);
  panels().expand(zero_, q, shifts_);
  rotations_.expand(zero_, rates, angle_rates_);
  panels().expand(zero_, rates, shift_rates_);
  rows.setZero();
  for (Index p = 0; p < particles_; ++p) {
    const Vec3 theta = at(angles_, particles_, p), u = at(shifts_, particles_, p),
               theta_rate = at(angle_rates_, particles_, p), u_rate = at(shift_rates_, particles_, p);
    const Rodrigues r = rodrigues(theta.squaredNorm());
    const double t_rate = 2 * theta.dot(theta_rate);
    const Vec3 once = theta.cross(u), once_rate = theta_rate.cross(u) + theta.cross(u_rate);
    const Vec3 twice = theta.cross(once), twice_rate = theta_rate.cross(once) + theta.cross(once_rate);
    set(rows, particles_, p,
        u_rate + r.b * once_rate + r.c * twice_rate + t_rate * (r.db * once + r.dc * twice));
  }
}

MatrixXd WarpedMotion::jacobian(const VectorXd& q) const {
  MatrixXd columns(panels().padded_rows(), q.size());
  VectorXd column(columns.rows());
  for (Index j = 0; j < q.size(); ++j) {
    move(q, VectorXd::Unit(q.size(), j), column);
    columns.col(j) = column;
  }
  return columns;
}

/// Gauss-Newton, from what a body without rotations would have.
VectorXd WarpedMotion::nearest(const VectorXd& x) const {
  constexpr int most_iterations = 20;
  VectorXd q = SubspaceMotion::nearest(x), placed(x.size());
  for (int i = 0; i < most_iterations; ++i) {
    place(q, placed);
    const MatrixXd change = jacobian(q), weighted = masses().asDiagonal() * change;
    const VectorXd step = (change.transpose() * weighted).ldlt().solve(weighted.transpose() * (x - placed));
    q += step;
    if (step.norm() <= 1e-12 * q.norm()) break;
  }
  return q;
}

VectorXd WarpedMotion::nearest_rates(const VectorXd& q, const VectorXd& v) const {
  const MatrixXd change = jacobian(q), weighted = masses().asDiagonal() * change;
  return (change.transpose() * weighted).ldlt().solve(weighted.transpose() * v);
}

void WarpedMotion::pull(const VectorXd& q, const VectorXd& forces, VectorXd& pulls) const {
  rotations_.expand(zero_, q, angles_);
  turned_.setZero();
  for (Index p = 0; p < particles_; ++p) {
    const Vec3 theta = at(angles_, particles_, p), f = at(forces, particles_, p);
    const Rodrigues r = rodrigues(theta.squaredNorm());
    const Vec3 once = theta.cross(f);
    set(turned_, particles_, p, f - r.a * once + r.b * theta.cross(once));
  }
  panels().project(turned_, pulls);
}

}  // namespace mss
