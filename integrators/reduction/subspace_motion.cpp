#include "integrators/reduction/subspace_motion.hpp"

#include <algorithm>
#include <cmath>

namespace mss {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

Eigen::MatrixXd divided(const Eigen::MatrixXd& shapes, const VectorXd& stretch) {
  return shapes * stretch.cwiseInverse().asDiagonal();
}

}  // namespace

SubspaceMotion::SubspaceMotion(const System<double>& system, const State<double>& rest,
                               const ReducedShapes& shapes, OuterForces outer, const VectorXd& stretch)
    : squares_(shapes.squares.cwiseQuotient(stretch.cwiseAbs2())),
      damping_(shapes.damping.cwiseQuotient(stretch.cwiseAbs2())),
      q_(VectorXd::Zero(shapes.count())),
      rates_(q_),
      rows_(system),
      stretch_(stretch),
      panels_(divided(shapes.shapes, stretch)),
      drawn_(divided(shapes.shapes, stretch)),
      zero_of_drawn_(Eigen::VectorXf::Zero(drawn_.padded_rows())),
      moved_(zero_of_drawn_),
      rest_(rows_.from(rest.x, panels_.padded_rows())),
      zero_(VectorXd::Zero(panels_.padded_rows())),
      outer_(std::move(outer)),
      pull_(shapes.count()),
      forces_(zero_),
      scratch_(rest),
      force_(system.size()),
      rows_out_(zero_) {
  Field<double> masses(system.size());
  for (const std::ptrdiff_t site : system.particles()) masses.set(site, Vec3::Constant(system.mass(site)));
  masses_ = rows_.from(masses, panels_.padded_rows());
}

void SubspaceMotion::place(const VectorXd& q, VectorXd& rows) const { panels_.expand(rest_, q, rows); }

void SubspaceMotion::move(const VectorXd&, const VectorXd& rates, VectorXd& rows) const {
  panels_.expand(zero_, rates, rows);
}

VectorXd SubspaceMotion::nearest_rates(const VectorXd&, const VectorXd& v) const {
  VectorXd rates(q_.size());
  panels_.project(masses_.cwiseProduct(v), rates);
  return rates.cwiseProduct(stretch_.cwiseAbs2());
}

VectorXd SubspaceMotion::nearest(const VectorXd& x) const {
  return SubspaceMotion::nearest_rates(q_, x - rest_);
}

void SubspaceMotion::pull(const VectorXd&, const VectorXd& forces, VectorXd& pulls) const {
  panels_.project(forces, pulls);
}

double SubspaceMotion::norm(const VectorXd& rows) const { return std::sqrt(masses_.dot(rows.cwiseAbs2())); }

void SubspaceMotion::take(const State<double>& state) {
  const VectorXd x = rows_.from(state.x, panels_.padded_rows()),
                 v = rows_.from(state.v, panels_.padded_rows());
  t_ = state.t;
  q_ = nearest(x);
  rates_ = nearest_rates(q_, v);
  place(q_, rows_out_);
  const double moved = norm(x - rest_), moves = norm(v);
  if (moved > 0) lost_ = std::max(lost_, norm(x - rows_out_) / moved);
  move(q_, rates_, rows_out_);
  if (moves > 0) lost_ = std::max(lost_, norm(v - rows_out_) / moves);
  restart();
}

VectorXd SubspaceMotion::coordinates_at(const Field<double>& x) const {
  const VectorXd positions = rows_.from(x, panels_.padded_rows());
  place(q_, rows_out_);
  constexpr double same = 1e-12;
  return norm(positions - rows_out_) <= same * norm(positions) ? q_ : nearest(positions);
}

void SubspaceMotion::draw(Field<double>& x) const {
  drawn_.expand(zero_of_drawn_, q_.cast<float>(), moved_);
  rows_.write_sum(rest_, moved_, x);
}

void SubspaceMotion::give(State<double>& state) const {
  state.t = t_;
  place(q_, rows_out_);
  rows_.write(rows_out_, state.x);
  move(q_, rates_, rows_out_);
  rows_.write(rows_out_, state.v);
}

const VectorXd& SubspaceMotion::outer_pull(double t, const VectorXd& q, const VectorXd& rates) {
  const bool same_forces = knows_pull_ && !outer_.change();
  if (same_forces && (!pulls_change() || outer_.nothing)) return pull_;
  if (!same_forces) {
    if (outer_.depend_on_state) {
      place(q, rows_out_);
      rows_.write(rows_out_, scratch_.x);
      move(q, rates, rows_out_);
      rows_.write(rows_out_, scratch_.v);
    }
    outer_.at(t, scratch_, force_);
    rows_.read(force_, forces_);
    knows_pull_ = true;
  }
  pull(q, forces_, pull_);
  return pull_;
}

void SubspaceMotion::remember(Record& record) {
  record.keep(t_);
  for (VectorXd* numbers : {&q_, &rates_})
    record.keep_values(std::span(numbers->data(), std::size_t(numbers->size())));
  if (record.reads()) restart();
}

ModalMotion::ModalMotion(const System<double>& system, const State<double>& rest, const ReducedShapes& shapes,
                         OuterForces outer)
    : SubspaceMotion(system, rest, shapes, std::move(outer), VectorXd::Ones(shapes.count())) {}

/// What changes is taken from the middle of a step.
double ModalMotion::longest_step() const {
  if (outer().change()) return std::min(outer().longest_step, 0.5 / fastest());
  if (pulls_change() && !outer().nothing) return 0.5 / std::sqrt(squares_.minCoeff());
  return std::numeric_limits<double>::infinity();
}

/// The exponential of [0 1 0; -omega^2 -d 1; 0 0 0] dt.
void ModalMotion::propagate_over(double dt) {
  const Index r = q_.size();
  for (Eigen::ArrayXd* array : {&q_q_, &q_v_, &q_p_, &v_q_, &v_v_, &v_p_}) array->resize(r);
  for (Index j = 0; j < r; ++j) {
    const double half = damping_[j] / 2, square = squares_[j] - half * half,
                 root = std::sqrt(std::abs(square));
    double even = std::exp(-half * dt), odd = even * dt;  // times exp(-half dt)
    if (square > 0) {
      odd = even * std::sin(root * dt) / root;
      even *= std::cos(root * dt);
    } else if (root > 0) {
      const double slow = std::exp((root - half) * dt), fast = std::exp(-(root + half) * dt);
      even = (slow + fast) / 2;
      odd = (slow - fast) / (2 * root);
    }
    q_q_[j] = even + half * odd;
    q_v_[j] = odd;
    v_q_[j] = -squares_[j] * odd;
    v_v_[j] = even - half * odd;
    q_p_[j] = (1 - q_q_[j]) / squares_[j];
    v_p_[j] = odd;
  }
  dt_ = dt;
}

bool ModalMotion::step(double dt, long steps) {
  if (dt != dt_) propagate_over(dt);
  const bool varies = outer().change() || (pulls_change() && !outer().nothing);
  const VectorXd* p = varies ? nullptr : &outer_pull(t_, q_, rates_);
  for (long n = 0; n < steps; ++n) {
    if (varies) p = &outer_pull(t_ + dt / 2, q_ + dt / 2 * rates_, rates_);
    before_ = q_.array();
    q_.array() = q_q_ * before_ + q_v_ * rates_.array() + q_p_ * p->array();
    rates_.array() = v_q_ * before_ + v_v_ * rates_.array() + v_p_ * p->array();
    t_ += dt;
  }
  return q_.allFinite() && rates_.allFinite();
}

double ModalMotion::stored_energy(const Field<double>& x) {
  return 0.5 * coordinates_at(x).cwiseAbs2().dot(squares_);
}

}  // namespace mss
