#include "integrators/reduction/cubic_motion.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

namespace mss {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Place of a pair a >= b in the order of loops.
int pair_place(int a, int b) { return a * (a + 1) / 2 + b; }
/// Place of a triple a >= b >= c.
int triple_place(int a, int b, int c) { return a * (a + 1) * (a + 2) / 6 + b * (b + 1) / 2 + c; }

/// Adds up sum c y y^T, y the numbers (linear, then quadratic) of one expression in q: E = z^T S z / 2 with
/// z = (q_a; q_a q_b for a >= b).
class Squares {
 public:
  explicit Squares(int coordinates)
      : r_(coordinates), rows_(chunk, r_ + r_ * (r_ + 1) / 2), sum_(rows_.cols(), rows_.cols()) {
    sum_.setZero();
  }

  /// The expression linear.q + q.quadratic q, the matrix symmetric, its square times `weight`.
  template <class Linear, class Quadratic>
  void add(double weight, const Linear& linear, const Quadratic& quadratic) {
    if ((weight < 0) != (sign_ < 0)) flush();
    sign_ = weight < 0 ? -1 : 1;
    const double root = std::sqrt(std::abs(weight));
    auto row = rows_.row(used_);
    for (int a = 0; a < r_; ++a) {
      row[a] = root * linear(a);
      for (int b = 0; b <= a; ++b) row[r_ + pair_place(a, b)] = root * (a == b ? 1 : 2) * quadratic(a, b);
    }
    if (++used_ == chunk) flush();
  }
  const MatrixXd& sum() {
    flush();
    return sum_;
  }

 private:
  static constexpr Index chunk = 512;
  void flush() {
    const auto used = rows_.topRows(used_);
    sum_.noalias() += sign_ * (used.transpose() * used);
    used_ = 0;
  }

  int r_;
  Index used_ = 0;
  double sign_ = 1;  ///< of the rows' weights
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows_;
  MatrixXd sum_;
};

void add_springs(const Body& body, const MatrixXd& shapes, Squares& squares) {
  const Index particles = shapes.rows() / 3;
  Eigen::Matrix<double, 3, Eigen::Dynamic> change(3, shapes.cols());
  body.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double k, double) {
    const double length = body.rest_length(slot.kind), square = length * length;
    const Vec3 d = body.rest_position(b) - body.rest_position(a);
    const Index i = body.particle(a), j = body.particle(b);
    for (int axis = 0; axis < 3; ++axis)
      change.row(axis) = shapes.row(axis * particles + j) - shapes.row(axis * particles + i);
    const VectorXd linear = change.transpose() * d;
    // (|d + U q|^2 - L0^2)^2 k / (8 L0^2) = k / (2 L0^2) (d.U q + |U q|^2 / 2)^2
    squares.add(
        k / square, [&](int s) { return linear[s]; },
        [&](int s, int t) { return change.col(s).dot(change.col(t)) / 2; });
  });
}

void add_cells(const Body& body, const MatrixXd& shapes, Squares& squares) {
  const Index particles = shapes.rows() / 3;
  const double size = body.config().cell_size;
  Eigen::Matrix<double, 9, Eigen::Dynamic> gradient(9, shapes.cols());
  body.for_each_cell([&](std::ptrdiff_t site) {
    const double volume = body.elements_at(site).volume;
    if (volume == 0) return;
    gradient.setZero();
    for (int corner = 0; corner < 8; ++corner) {
      const Index p = body.particle(site + body.lattice().corner(corner));
      for (int along = 0; along < 3; ++along)
        for (int axis = 0; axis < 3; ++axis)
          gradient.row(3 * along + axis) +=
              corner_sign(corner, along) / (4 * size) * shapes.row(axis * particles + p);
    }
    // tr e = div u + |grad u|^2 / 2
    squares.add(
        volume * body.cell_volume(), [&](int s) { return gradient(0, s) + gradient(4, s) + gradient(8, s); },
        [&](int s, int t) { return gradient.col(s).dot(gradient.col(t)) / 2; });
  });
}

}  // namespace

PolynomialForce::PolynomialForce(const Body& body, const MatrixXd& shapes) {
  const int r = int(shapes.cols());
  Squares squares(r);
  add_springs(body, shapes, squares);
  add_cells(body, shapes, squares);
  polynomial_.coordinates = r;
  polynomial_.padded = r > 4 * coordinate_padding
                           ? most_coordinates
                           : (r + coordinate_padding - 1) / coordinate_padding * coordinate_padding;
  set_coefficients(squares.sum(), r);
}

/// From E = z^T S z / 2 to the derivative of each of its monomials by each of their coordinates.
void PolynomialForce::set_coefficients(const MatrixXd& squares, int r) {
  const auto padded = std::size_t(polynomial_.padded);
  linear_.assign(std::size_t(r) * padded, 0);
  quadratic_.assign(std::size_t(pair_place(r, 0)) * padded, 0);
  cubic_.assign(std::size_t(triple_place(r, 0, 0)) * padded, 0);
  std::vector<std::vector<int>> factors;  // of each number of z
  for (int a = 0; a < r; ++a) factors.push_back({a});
  for (int a = 0; a < r; ++a)
    for (int b = 0; b <= a; ++b) factors.push_back({a, b});
  const auto row_of = [&](const std::vector<int>& rest) -> double* {
    if (rest.size() == 1) return &linear_[std::size_t(rest[0]) * padded];
    if (rest.size() == 2) return &quadratic_[std::size_t(pair_place(rest[0], rest[1])) * padded];
    return &cubic_[std::size_t(triple_place(rest[0], rest[1], rest[2])) * padded];
  };
  std::vector<int> all, rest;
  for (std::size_t i = 0; i < factors.size(); ++i)
    for (std::size_t j = 0; j < factors.size(); ++j) {
      all = factors[i];
      all.insert(all.end(), factors[j].begin(), factors[j].end());
      std::sort(all.begin(), all.end(), std::greater<>());
      for (std::size_t k = 0; k < all.size(); ++k) {
        rest = all;
        rest.erase(rest.begin() + std::ptrdiff_t(k));
        row_of(rest)[all[k]] += squares(Index(i), Index(j)) / 2;
      }
    }
  polynomial_.linear = linear_.data();
  polynomial_.quadratic = quadratic_.data();
  polynomial_.cubic = cubic_.data();
}

/// The integral of the gradient from 0 to q, which two of Gauss's points give exactly.
double PolynomialForce::energy(const VectorXd& q) const {
  VectorXd gradient_at(padded());
  double sum = 0;
  for (const double share : {0.5 - std::sqrt(3.0) / 6, 0.5 + std::sqrt(3.0) / 6}) {
    gradient(share * q, gradient_at);
    sum += gradient_at.head(q.size()).dot(q) / 2;
  }
  return sum;
}

VectorXd mass_scaling(const VectorXd& squares) {
  constexpr double most = 30;
  return (squares / squares[0]).cwiseSqrt().cwiseMax(most) / most;
}

CubicMotion::CubicMotion(const System<double>& system, const Body& body, const State<double>& rest,
                         const ReducedShapes& shapes, OuterForces outer)
    : SubspaceMotion(system, rest, shapes, std::move(outer), mass_scaling(shapes.squares)),
      force_(body, shapes.shapes * mass_scaling(shapes.squares).cwiseInverse().asDiagonal()),
      viscous_time_(shapes.damping[0] / shapes.squares[0]),
      acceleration_(shapes.count()),
      gradient_(force_.padded()),
      gradient_before_(force_.padded()),
      gradient_beside_(force_.padded()),
      fastest_direction_(VectorXd::Unit(shapes.count(), shapes.count() - 1)) {}

/// Of leapfrog with viscous forces half a step late, omega^2 dt^2 + 2 tau omega^2 dt < 4.
double CubicMotion::stable_step(double square) const {
  return -viscous_time_ + std::sqrt(viscous_time_ * viscous_time_ + 4 / square);
}

double CubicMotion::longest_step() const {
  return std::min(0.9 * stable_step(squares_.maxCoeff()), outer().longest_step);
}

/// Large motions stiffen the body. Power iteration for the fastest motion about q, which goes on from call to
/// call: in how many parts a step is to be taken.
long CubicMotion::parts_of_step(double dt) {
  double square = 0;
  for (int i = 0; i < 2; ++i) {
    const double size = 1e-6 * (1 + q_.norm());
    force_.gradient(q_ + size * fastest_direction_, gradient_beside_);
    const VectorXd change = (gradient_beside_ - gradient_).head(q_.size()) / size;
    square = change.norm();
    if (!std::isfinite(square) || square == 0) return 1;  // what has diverged is found at the end
    fastest_direction_ = change / square;
  }
  constexpr long most = 64;
  return std::clamp(long(std::ceil(dt / (0.95 * stable_step(square)))), 1L, most);
}

void CubicMotion::accelerate(double dt) {
  gradient_.swap(gradient_before_);
  force_.gradient(q_, gradient_);
  const Index r = q_.size();
  acceleration_ = outer_pull(t_, q_, rates_) - gradient_.head(r) -
                  viscous_time_ / dt * (gradient_.head(r) - gradient_before_.head(r));
}

void CubicMotion::leap(double dt) {
  rates_ += dt / 2 * acceleration_;
  q_ += dt * rates_;
  t_ += dt;
  accelerate(dt);
  rates_ += dt / 2 * acceleration_;
}

bool CubicMotion::step(double dt, long steps) {
  constexpr long steps_between_looks = 4;
  if (!begun_) {
    force_.gradient(q_ - dt * rates_, gradient_);
    accelerate(dt);
    begun_ = true;
  }
  long parts = 1;
  for (long n = 0; n < steps; ++n) {
    if (n % steps_between_looks == 0) parts = parts_of_step(dt);
    for (long part = 0; part < parts; ++part) leap(dt / double(parts));
  }
  return q_.allFinite() && rates_.allFinite();
}

double CubicMotion::stored_energy(const Field<double>& x) { return force_.energy(coordinates_at(x)); }

void CubicMotion::remember(Record& record) {
  SubspaceMotion::remember(record);
  record.keep(begun_);
  for (VectorXd* numbers : {&acceleration_, &gradient_, &fastest_direction_})
    record.keep_values(std::span(numbers->data(), std::size_t(numbers->size())));
}

}  // namespace mss
