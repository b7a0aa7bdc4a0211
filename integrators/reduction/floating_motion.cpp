#include "integrators/reduction/floating_motion.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace mss {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Pairs of axes in the order of `first_`.
constexpr std::array<std::array<int, 2>, 6> axes{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

/// sum m u_a w_b by pairs of columns of two sets of displacements.
MatrixXd weighted(const VectorXd& masses, const MatrixXd& u, int a, const MatrixXd& w, int b) {
  const Index particles = u.rows() / 3;
  return u.middleRows(a * particles, particles).transpose() * masses.head(particles).asDiagonal() *
         w.middleRows(b * particles, particles);
}

}  // namespace

FloatingMotion::FloatingMotion(const SolidSystem<double>& system, const State<double>& rest,
                               const ReducedShapes& shapes, OuterForces outer)
    : rows_(system),
      particles_(rows_.count() / 3),
      panels_(shapes.shapes),
      drawn_(shapes.shapes),
      squares_(shapes.squares),
      damping_(shapes.damping),
      zero_(VectorXd::Zero(panels_.padded_rows())),
      mass_(system.total_mass()),
      outer_(std::move(outer)),
      scratch_(rest),
      force_(system.size()),
      forces_(zero_),
      rates_(VectorXd::Zero(shapes.count())),
      rows_out_(zero_),
      shifts_(zero_) {
  Field<double> masses(system.size());
  for (const std::ptrdiff_t site : system.particles()) masses.set(site, Vec3::Constant(system.mass(site)));
  masses_ = rows_.from(masses, panels_.padded_rows());
  at_.q = at_.p = rates_;
  arms_ = centred(rest.x, at_.centre);
  drawn_arms_ = moved_ = arms_.cast<float>();
  const Index r = shapes.count();
  const MatrixXd arms = arms_.head(rows_.count());
  MatrixXd of_shape(9 * r, r), of_rates(3 * r, r);
  for (std::size_t pair = 0; pair < axes.size(); ++pair) {
    const auto [a, b] = axes[pair];
    const MatrixXd squared = weighted(masses_, shapes.shapes, a, shapes.shapes, b);
    of_shape.middleRows(Index(pair) * r, r) = a == b ? squared : MatrixXd(squared + squared.transpose());
    first_[pair] = weighted(masses_, arms, a, shapes.shapes, b).row(0);
    if (a != b) first_[pair] += weighted(masses_, arms, b, shapes.shapes, a).row(0);
    inertia_[pair] = weighted(masses_, arms, a, arms, b)(0, 0);
  }
  for (int c = 0; c < 3; ++c) {
    const MatrixXd product = weighted(masses_, shapes.shapes, (c + 1) % 3, shapes.shapes, (c + 2) % 3);
    // (A_c q)_k = sum m (u(q) x U_k)_c
    of_rates.middleRows(c * r, r) = (product - product.transpose()).transpose();
  }
  of_shape.bottomRows(3 * r) = of_rates;
  of_shape_ = ShapePanels(of_shape);
  of_rates_ = ShapePanels(of_rates);
  zero_of_shape_ = shape_out_ = VectorXd::Zero(of_shape_.padded_rows());
  zero_of_rates_ = rates_out_ = VectorXd::Zero(of_rates_.padded_rows());
}

/// Well within the limit of 2.8: what is that fast is damped by a tenth a step.
double FloatingMotion::longest_step() const { return std::min(1.8 / fastest(), outer_.longest_step); }

void FloatingMotion::Moving::add(double dt, const Moving& rates) {
  q += dt * rates.q;
  p += dt * rates.p;
  turn += dt * rates.turn;
  centre += dt * rates.centre;
  velocity += dt * rates.velocity;
  angular_momentum += dt * rates.angular_momentum;
}

VectorXd FloatingMotion::centred(const Field<double>& field, Vec3& mean) const {
  VectorXd rows = rows_.from(field, panels_.padded_rows());
  for (int axis = 0; axis < 3; ++axis) {
    auto values = rows.segment(axis * particles_, particles_);
    mean[axis] = values.dot(masses_.head(particles_)) / mass_;
    values.array() -= mean[axis];
  }
  return rows;
}

VectorXd FloatingMotion::turned(const Matrix3d& r, const VectorXd& rows) const {
  VectorXd result = VectorXd::Zero(rows.size());
  turn(r, rows, Vec3::Zero(), result);
  return result;
}

/// In one pass, because this is most of what drawing costs beside the shapes.
void FloatingMotion::turn(const Matrix3d& r, const VectorXd& rows, const Vec3& offset, VectorXd& out) const {
  const double *x = rows.data(), *y = x + particles_, *z = y + particles_;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = r(axis, 0), b = r(axis, 1), c = r(axis, 2), d = offset[axis];
    double* to = out.data() + axis * particles_;
    for (Index i = 0; i < particles_; ++i) to[i] = a * x[i] + b * y[i] + c * z[i] + d;
  }
}

/// The rotation that makes the sum of m c x R^T arms vanish: the polar factor of sum m arms c^T.
Matrix3d FloatingMotion::frame_of(const VectorXd& arms) const {
  Matrix3d sum;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      sum(a, b) = weighted(masses_, arms.head(rows_.count()), a, arms_.head(rows_.count()), b)(0, 0);
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 signs = Vec3::Ones();
  signs[2] = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1 : 1;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

void FloatingMotion::take(const State<double>& state) {
  t_ = state.t;
  const VectorXd arms = centred(state.x, at_.centre), speeds = centred(state.v, at_.velocity);
  const Matrix3d frame = frame_of(arms);
  at_.turn = Eigen::Quaterniond(frame).coeffs();
  at_.angular_momentum.setZero();
  for (Index i = 0; i < particles_; ++i) {
    const Vec3 arm(arms[i], arms[particles_ + i], arms[2 * particles_ + i]),
        speed(speeds[i], speeds[particles_ + i], speeds[2 * particles_ + i]);
    at_.angular_momentum += masses_[i] * arm.cross(speed);
  }
  panels_.project(masses_.cwiseProduct(turned(frame.transpose(), arms) - arms_), at_.q);
  panels_.project(masses_.cwiseProduct(turned(frame.transpose(), speeds)), at_.p);
  find_velocities();
}

void FloatingMotion::find_inertia() {
  const Index r = at_.q.size();
  of_shape_.expand(zero_of_shape_, at_.q, shape_out_);
  std::array<double, 6> s{};
  for (std::size_t pair = 0; pair < axes.size(); ++pair) {
    now_.change[pair] = first_[pair] + shape_out_.segment(Index(pair) * r, r);
    const double sum = at_.q.dot(first_[pair] + now_.change[pair]);
    s[pair] = inertia_[pair] + (pair < 3 ? sum : sum / 2);
  }
  for (int c = 0; c < 3; ++c) now_.b[std::size_t(c)] = shape_out_.segment((6 + c) * r, r);
  const double trace = s[0] + s[1] + s[2];
  now_.moment << trace - s[0], -s[3], -s[4], -s[3], trace - s[1], -s[5], -s[4], -s[5], trace - s[2];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) now_.moment(a, b) -= now_.b[std::size_t(a)].dot(now_.b[std::size_t(b)]);
}

void FloatingMotion::find_velocities() {
  frame_ = Eigen::Quaterniond(at_.turn).normalized().toRotationMatrix();
  find_inertia();
  Vec3 rest = frame_.transpose() * at_.angular_momentum;
  for (int c = 0; c < 3; ++c) rest[c] -= now_.b[std::size_t(c)].dot(at_.p);
  spin_ = now_.moment.inverse() * rest;
  rates_ = at_.p;
  for (int c = 0; c < 3; ++c) rates_ -= spin_[c] * now_.b[std::size_t(c)];
}

FloatingMotion::Moving FloatingMotion::rates_at(double t) {
  const Index r = at_.q.size();
  find_velocities();
  of_rates_.expand(zero_of_rates_, rates_, rates_out_);
  Moving rates{.q = rates_, .p = -squares_.cwiseProduct(at_.q) - damping_.cwiseProduct(rates_)};
  const double square = spin_.squaredNorm();
  for (std::size_t pair = 0; pair < axes.size(); ++pair) {
    const auto [a, b] = axes[pair];
    rates.p -= (spin_[a] * spin_[b] - (a == b ? square : 0)) * now_.change[pair];
  }
  for (int c = 0; c < 3; ++c) rates.p -= spin_[c] * rates_out_.segment(c * r, r);
  const Eigen::Quaterniond spin(0, spin_[0] / 2, spin_[1] / 2, spin_[2] / 2);
  rates.turn = (Eigen::Quaterniond(at_.turn) * spin).coeffs();
  rates.centre = at_.velocity;
  add_outer(t, rates);
  return rates;
}

Vec3 FloatingMotion::sum_of(const VectorXd& forces) const {
  Vec3 sum;
  for (int axis = 0; axis < 3; ++axis) sum[axis] = forces.segment(axis * particles_, particles_).sum();
  return sum;
}

/// Gravity alone moves the body as a whole.
void FloatingMotion::add_outer(double t, Moving& rates) {
  if (!knows_force_ || outer_.change()) {
    if (outer_.depend_on_state) give(scratch_);
    outer_.at(t, scratch_, force_);
    rows_.read(force_, forces_);
    total_force_ = sum_of(forces_);
    knows_force_ = true;
  }
  rates.velocity = total_force_ / mass_;
  if (outer_.turns) turn_by_forces(rates);
}

void FloatingMotion::turn_by_forces(Moving& rates) {
  panels_.expand(arms_, at_.q, shifts_);
  const VectorXd arms = turned(frame_, shifts_);
  for (Index i = 0; i < particles_; ++i) {
    const Vec3 arm(arms[i], arms[particles_ + i], arms[2 * particles_ + i]),
        f(forces_[i], forces_[particles_ + i], forces_[2 * particles_ + i]);
    rates.angular_momentum += arm.cross(f);
  }
  VectorXd pulls(at_.q.size());
  panels_.project(turned(frame_.transpose(), forces_), pulls);
  rates.p += pulls;
}

bool FloatingMotion::step(double dt, long steps) {
  for (long n = 0; n < steps; ++n) {
    const Moving begin = at_;
    const Moving first = rates_at(t_);
    at_.add(dt / 2, first);
    const Moving second = rates_at(t_ + dt / 2);
    at_ = begin;
    at_.add(dt / 2, second);
    const Moving third = rates_at(t_ + dt / 2);
    at_ = begin;
    at_.add(dt, third);
    const Moving fourth = rates_at(t_ + dt);
    at_ = begin;
    at_.add(dt / 6, first);
    at_.add(dt / 3, second);
    at_.add(dt / 3, third);
    at_.add(dt / 6, fourth);
    at_.turn.normalize();
    t_ += dt;
  }
  find_velocities();
  return at_.q.allFinite() && at_.p.allFinite() && frame_.allFinite();
}

void FloatingMotion::draw(Field<double>& x) const {
  drawn_.expand(drawn_arms_, at_.q.cast<float>(), moved_);
  rows_.write_turned(frame_, moved_, at_.centre, x);
}

void FloatingMotion::give(State<double>& state) const {
  state.t = t_;
  panels_.expand(arms_, at_.q, shifts_);
  turn(frame_, shifts_, at_.centre, rows_out_);
  rows_.write(rows_out_, state.x);
  VectorXd speeds = VectorXd::Zero(panels_.padded_rows());
  panels_.expand(zero_, rates_, speeds);
  const auto part = [&](VectorXd& rows, int axis) { return rows.segment(axis * particles_, particles_); };
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    part(speeds, axis) += spin_[next] * part(shifts_, last) - spin_[last] * part(shifts_, next);
  }
  turn(frame_, speeds, at_.velocity, rows_out_);
  rows_.write(rows_out_, state.v);
}

double FloatingMotion::stored_energy(const Field<double>& x) {
  Vec3 centre;
  const VectorXd arms = centred(x, centre);
  VectorXd q(at_.q.size());
  panels_.project(masses_.cwiseProduct(turned(frame_of(arms).transpose(), arms) - arms_), q);
  return 0.5 * q.cwiseAbs2().dot(squares_);
}

void FloatingMotion::remember(Record& record) {
  record.keep(t_, at_.turn, at_.centre, at_.velocity, at_.angular_momentum);
  for (VectorXd* numbers : {&at_.q, &at_.p})
    record.keep_values(std::span(numbers->data(), std::size_t(numbers->size())));
  if (record.reads()) find_velocities();
}

}  // namespace mss
