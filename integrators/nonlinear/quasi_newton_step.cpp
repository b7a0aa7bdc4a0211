// An iteration of a quasi-Newton method: a direction, and how far to go along it.
#include <algorithm>
#include <cmath>

#include "integrators/linear/vector_kernels.hpp"
#include "integrators/nonlinear/bounded_system.hpp"
#include "integrators/nonlinear/quasi_newton.hpp"

namespace mss {

namespace {

constexpr int most_halvings = 12;

/// Where friction acts, which has no energy, so that no step may seem short enough.
constexpr int most_halvings_sliding = 6;

/// Of conjugate directions: of the slope at the beginning of a step, what is left at its end; and by how much
/// a step may become longer.
constexpr double steep_enough = 0.2, longest_length = 4;

/// A step is a pair if s.y exceeds this share of -s.g.
constexpr double least_curvature = 1e-3;

/// Coordinates that one thread works on at a time: what it reads twice stays in the first-level cache. Sums
/// over them do not depend on the number of threads.
constexpr std::ptrdiff_t part_size = 1024;
constexpr std::ptrdiff_t parts_together = 8;  ///< some 2 us

const double* from(const Field<double>& field, std::ptrdiff_t first) { return field.axis(0) + first; }
double* from(Field<double>& field, std::ptrdiff_t first) { return field.axis(0) + first; }

}  // namespace

/// Adds up part(first, count, sums) of all coordinates, always in the same order.
template <class Part>
QuasiNewton::Sums QuasiNewton::sum_over_parts(System<double>& system, Part&& part) {
  sums_.resize(std::size_t((mass_.size() + part_size - 1) / part_size));
  parallel_in_groups(system, std::ptrdiff_t(sums_.size()), parts_together, [&](std::ptrdiff_t i) {
    sums_[std::size_t(i)] = {};
    part(i * part_size, std::min(part_size, mass_.size() - i * part_size), sums_[std::size_t(i)]);
  });
  Sums total{};
  for (const Sums& sums : sums_)
    for (std::size_t i = 0; i < total.size(); ++i) total[i] += sums[i];
  return total;
}

/// Moves the body along p, and prescribed coordinates to where they belong.
void QuasiNewton::move(System<double>& system, const ImplicitStage& stage, State<double>& state,
                       double length) {
  const Field<double>& p = pairs_.s[std::size_t(pairs_.count)];
  sum_over_parts(system, [&](std::ptrdiff_t first, std::ptrdiff_t n, Sums&) {
    fastest_copy<VectorKernels>().move(length, from(p, first), stage.gamma_x, from(*stage.x_base, first),
                                       from(state.v, first), from(state.x, first), n);
  });
  system.constrain(stage.t, state.x, state.v);
}

/// The gradient where the body is, its norm, and p.g.
void QuasiNewton::evaluate(System<double>& system, const ImplicitStage& stage, State<double>& state,
                           Work& work) {
  stage_force(system, stage, state, x_end_, gradient_);
  ++work.force_evaluations;
  sum_over_parts(system, [&](std::ptrdiff_t first, std::ptrdiff_t n, Sums&) {
    fastest_copy<VectorKernels>().gradient(from(mass_, first), from(state.v, first),
                                           from(*stage.v_base, first), stage.gamma, from(gradient_, first),
                                           n);
  });
  if (bounded_) {
    impulse_.array() = -gradient_.array();
    return leave_out_held(system, state);
  }
  measure_gradient(system);
}

void QuasiNewton::measure_gradient(System<double>& system) {
  const Field<double>& p = pairs_.s[std::size_t(pairs_.count)];
  const Sums sums = sum_over_parts(system, [&](std::ptrdiff_t first, std::ptrdiff_t n, Sums& sum) {
    const double* g = from(gradient_, first);
    sum[0] = fastest_copy<VectorKernels>().dot(g, g, n);
    sum[1] = fastest_copy<VectorKernels>().dot(g, from(p, first), n);
  });
  norm_ = std::sqrt(sums[0]);
  slope_now_ = sums[1];
}

/// Solves for z; makes the last step a pair, if there was one along which the gradient grew; writes the next
/// step to pairs_.s[pairs_.count].
void QuasiNewton::choose_step(System<double>& system, Work& work) {
  std::swap(z_, z_before_);
  if (jumps_) jump_.array() = -jump_.array();  // the step is -z
  cycle_->solve(gradient_, norm_, jumps_ ? jump_ : Field<double>(), z_);
  ++work.linear_solves;
  take_products(system);
  PairProducts of_s, of_u;
  if (directions_.conjugate)
    pairs_.conjugate(ug_, of_s, of_u);
  else
    pairs_.expand(sg_, ug_, of_s, of_u);
  slope_ = -zg_ - of_s.dot(sg_) - of_u.dot(ug_);
  if (!(slope_ < 0)) {  // uphill, by rounding
    pairs_.count = 0;
    slope_ = -zg_;
  }
  const int count = pairs_.count;
  Field<double>& p = pairs_.s[std::size_t(count)];
  const Sums sums = sum_over_parts(system, [&](std::ptrdiff_t first, std::ptrdiff_t n, Sums& sum) {
    double* out = from(p, first);
    std::fill_n(out, n, 0.0);
    fastest_copy<VectorKernels>().add(-1, from(z_, first), out, n);
    for (int i = 0; i < count; ++i) {
      fastest_copy<VectorKernels>().add(-of_s[i], from(pairs_.s[std::size_t(i)], first), out, n);
      fastest_copy<VectorKernels>().add(-of_u[i], from(pairs_.u[std::size_t(i)], first), out, n);
    }
    sum[0] = fastest_copy<VectorKernels>().dot(out, out, n);
  });
  size_ = std::sqrt(sums[0]);
}

/// Products with g of z, of all pairs and of the last step, which may become one.
void QuasiNewton::take_products(System<double>& system) {
  const int count = pairs_.count;
  const bool candidate = length_ > 0 && pairs_.kept > 0;
  const int products = candidate ? count + 1 : count;
  const Sums sums = sum_over_parts(system, [&](std::ptrdiff_t first, std::ptrdiff_t n, Sums& sum) {
    const double* g = from(gradient_, first);
    if (candidate) {
      double* s = from(pairs_.s[std::size_t(count)], first);
      double* u = from(pairs_.u[std::size_t(count)], first);
      const double *z = from(z_, first), *before = from(z_before_, first);
      for (std::ptrdiff_t i = 0; i < n; ++i) u[i] = z[i] - before[i];
      if (length_ != 1)
        for (std::ptrdiff_t i = 0; i < n; ++i) s[i] *= length_;
    }
    for (std::size_t i = 0; i < std::size_t(products); ++i) {
      sum[2 * i] = fastest_copy<VectorKernels>().dot(from(pairs_.s[i], first), g, n);
      sum[2 * i + 1] = fastest_copy<VectorKernels>().dot(from(pairs_.u[i], first), g, n);
    }
    sum.back() = fastest_copy<VectorKernels>().dot(from(z_, first), g, n);
  });
  PairProducts sg = PairProducts::Zero(), ug = PairProducts::Zero();
  for (int i = 0; i < products; ++i) {
    sg[i] = sums[2 * std::size_t(i)];
    ug[i] = sums[2 * std::size_t(i) + 1];
  }
  if (candidate) take_pair(sg, ug, sums.back());
  sg_ = sg;
  ug_ = ug;
  zg_ = sums.back();
}

/// Makes the last step a pair if the gradient grew along it; sg, ug and zg are products with what it is now.
void QuasiNewton::take_pair(PairProducts& sg, PairProducts& ug, double zg) {
  const int count = pairs_.count;
  sg_[count] = length_ * slope_;
  ug_[count] = zg - ug[count] - zg_;  // z.g - z'.g = g'.z' - u.g' - z.g, as B is symmetric
  const PairProducts sy = sg - sg_, uy = ug - ug_;
  if (!(sy[count] > least_curvature * std::abs(sg_[count]))) return;
  pairs_.push(sy, uy);
  if (pairs_.count > count) return;
  sg.head<most_pairs>() = sg.tail<most_pairs>().eval();  // the oldest is gone
  ug.head<most_pairs>() = ug.tail<most_pairs>().eval();
}

bool QuasiNewton::search(System<double>& system, const ImplicitStage& stage, State<double>& state,
                         Work& work) {
  length_ = 0;
  for (int halvings = 0; halvings <= most_halvings; ++halvings) {
    const double length = std::ldexp(1.0, -halvings);
    move(system, stage, state, length - length_);
    length_ = length;
    evaluate(system, stage, state, work);
    if (std::isfinite(norm_) && slope_now_ <= -slope_ / 2) {
      if (directions_.conjugate && halvings == 0) improve_length(system, stage, state, work);
      return true;
    }
    if (bounded_ && halvings == most_halvings_sliding) return std::isfinite(norm_);
  }
  return false;
}

/// Goes on to where the slope would be zero if it were linear.
void QuasiNewton::improve_length(System<double>& system, const ImplicitStage& stage, State<double>& state,
                                 Work& work) {
  const double length = slope_ / (slope_ - slope_now_);
  if (std::abs(slope_now_) <= steep_enough * std::abs(slope_) || !(length > 0)) return;
  const double to = std::min(length, longest_length);
  move(system, stage, state, to - length_);
  length_ = to;
  evaluate(system, stage, state, work);
}

/// Goes back to where the last step began, to go on from there without pairs.
void QuasiNewton::go_back(System<double>& system, const ImplicitStage& stage, State<double>& state,
                          Work& work) {
  move(system, stage, state, -length_);
  forget_steps();
  evaluate(system, stage, state, work);
}

}  // namespace mss
