// Quasi-Newton methods for implicit stages. In place of the tangent's inverse they take B, a V-cycle on the
// springs' tangent at rest between the particles' rotations (rest_cycle.hpp). With the gradient
// g = M (v - v_base) - gamma f:
//   projective  v' = v - B g: a constant matrix for every stage, as projective dynamics has one. Liu,
//               Bargteil, O'Brien and Kavan, ACM TOG 32 (2013) 214;
//   lbfgs       v' = v - H g, with H the BFGS update of B by the last two steps s and changes y of g. Liu,
//               Bouaziz and Kavan, ACM TOG 36 (2017) 23; Nocedal and Wright, Numerical Optimization, ch. 7.
//   nonlinear_cg  the same with one pair, of which only s is used: conjugate directions, v' = v - a p, p = B
//   g -
//               (y.B g / y.s) s (Hestenes and Stiefel's formula), with a second force where the first shows
//               that a = 1 is far off. Wang et al., MAS-PNCG, 2024, took a multilevel additive Schwarz
//               preconditioner;
//   additive_cg   with B as such a one: the V-cycle's smoothers on all lattices side by side, without
//   products
//               between them (Bramble, Pasciak and Xu, Math. Comp. 55 (1990) 1).
// An iteration costs a force evaluation and a V-cycle, and keeps the linear momentum of the stage. Iterations
// begin where the body would be if gravity alone changed its velocity, along axes in which nothing holds it.
//
// H g is a sum of z = B g, the steps s and the changes u = B y of z; y itself is not stored. L-BFGS's two
// loops run over coefficients, from products of s and u with the gradients g and g' about a step:
//   s_i.y = s_i.g' - s_i.g,   y_i.B y = u_i.g' - u_i.g.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/error.hpp"
#include "core/springs/solid_system.hpp"
#include "integrators/linear/rest_cycle.hpp"
#include "integrators/linear/unknowns.hpp"
#include "integrators/linear/vector_kernels.hpp"
#include "integrators/nonlinear/bounded_system.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

/// Of the gradient, to that before the first iteration; and where energy is to be conserved, or until so many
/// iterations have not halved it.
constexpr double tolerance = 1e-10, rounding = 1e-15;
constexpr int most_idle = 4;

constexpr int most_iterations = 2000;
constexpr int most_with_contact = 200;  ///< friction may turn in circles: then Newton's method takes over
constexpr int most_halvings = 12;

/// The V-cycle turns with the body after so many iterations that have moved it by that share of a cell, rms.
constexpr int turned_every = 8;
constexpr double share_of_cell = 0.1;
constexpr double shortest_trusted = 0.2;  ///< of steps: after shorter ones pieces turn as wholes

/// Of what is left to solve, to what planes push with: then that is known, and friction follows it.
constexpr double trusted = 0.3;

/// Iterations in a stage that look for what planes hold, beside those given.
constexpr int most_in_search = 200;

/// After so many changes of what planes hold in a stage the rest is solved, to that share of what it was,
/// before there is another one: then they cannot go round in circles.
constexpr int most_hasty_changes = 12;
constexpr double solved = 1e-3;

/// Where friction acts, which has no energy, so that no step may seem short enough.
constexpr int most_halvings_sliding = 6;

/// Of conjugate directions: of the slope at the beginning of a step, what is left at its end; and by how much
/// a step may become longer.
constexpr double steep_enough = 0.2, longest_length = 4;

/// Moves below this share of the coordinates are rounding.
constexpr double negligible = 1e-14;

constexpr int most_pairs = 2;

/// A step is a pair if s.y exceeds this share of -s.g.
constexpr double least_curvature = 1e-3;

/// Products of a vector with every step, and with every change of z.
using Products = Eigen::Matrix<double, most_pairs + 1, 1>;

/// Steps s and changes u of z, oldest first. One place more than pairs: the newest is written before the
/// oldest is given up.
struct Pairs {
  int kept = most_pairs, count = 0;
  std::array<Field<double>, most_pairs + 1> s, u;
  Eigen::Matrix<double, most_pairs + 1, most_pairs + 1> sy, uy;  ///< (older, newer); (i, i) too

  /// Takes s[count] and u[count] as a pair, with its products.
  void push(const Products& s_with_y, const Products& u_with_y);
  /// Coefficients of s and u in H g - z, from products with g.
  void expand(const Products& sg, const Products& ug, Products& of_s, Products& of_u) const;
  /// The same of the conjugate direction to the last step.
  void conjugate(const Products& ug, Products& of_s, Products& of_u) const;
};

void Pairs::push(const Products& s_with_y, const Products& u_with_y) {
  sy.col(count) = s_with_y;
  uy.col(count) = u_with_y;
  if (++count <= kept) return;
  --count;
  std::rotate(s.begin(), s.begin() + 1, s.begin() + kept + 1);
  std::rotate(u.begin(), u.begin() + 1, u.begin() + kept + 1);
  sy.topLeftCorner<most_pairs, most_pairs>() = sy.bottomRightCorner<most_pairs, most_pairs>().eval();
  uy.topLeftCorner<most_pairs, most_pairs>() = uy.bottomRightCorner<most_pairs, most_pairs>().eval();
}

void Pairs::expand(const Products& sg, const Products& ug, Products& of_s, Products& of_u) const {
  of_s.setZero();
  of_u.setZero();
  for (int i = count - 1; i >= 0; --i) {  // q = g + sum of_u y
    double sq = sg[i];
    for (int j = i + 1; j < count; ++j) sq += of_u[j] * sy(i, j);
    of_u[i] = -sq / sy(i, i);
  }
  for (int i = 0; i < count; ++i) {  // A^-1 q + sum of_s s
    double yr = ug[i];
    for (int j = 0; j < count; ++j) yr += of_u[j] * uy(std::min(i, j), std::max(i, j));
    for (int j = 0; j < i; ++j) yr += of_s[j] * sy(j, i);
    of_s[i] = -of_u[i] - yr / sy(i, i);
  }
}

void Pairs::conjugate(const Products& ug, Products& of_s, Products& of_u) const {
  of_s.setZero();
  of_u.setZero();
  if (count > 0) of_s[count - 1] = -ug[count - 1] / sy(count - 1, count - 1);
}

/// Coordinates that one thread works on at a time: what it reads twice stays in the first-level cache. Sums
/// over them do not depend on the number of threads.
constexpr std::ptrdiff_t part_size = 1024;
constexpr std::ptrdiff_t parts_together = 8;  ///< some 2 us

/// What directions are made of.
struct Directions {
  int pairs = 0;
  bool conjugate = false;  ///< of a pair only the step
  bool additive = false;   ///< by lattices side by side
};

class QuasiNewton final : public NonlinearSolver {
 public:
  QuasiNewton(const IntegratorOptions& options, std::string name, Directions directions)
      : name_(std::move(name)),
        directions_(directions),
        pairs_kept_(directions.pairs),
        iterations_(options.iterations),
        newton_(std::make_unique<Newton>(options)) {}

  Status solve(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work) override;
  void end_step(const StepTaken& step, State<double>& state, Field<double>* a) override {
    if (bounded_) bounded_->end_step(step, state, a);
  }
  void remember(System<double>& system, Record& record) override;

 private:
  using Sums = std::array<double, 2 * (most_pairs + 1) + 1>;

  Status solve_stage(System<double>& plain, const ImplicitStage& stage, State<double>& state, Work& work);
  void begin(System<double>& system);
  Status prepare(const ImplicitStage& stage, Work& work);
  template <class Part>
  Sums sum_over_parts(System<double>& system, Part&& part);
  void move(System<double>& system, const ImplicitStage& stage, State<double>& state, double length);
  void evaluate(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  void choose_step(System<double>& system, Work& work);
  void take_products(System<double>& system);
  void forget(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  void improve_length(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  bool search(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  void measure_gradient(System<double>& system);
  void leave_out_held(System<double>& system, const State<double>& state);
  bool take_step(System<double>& system, const ImplicitStage& stage, State<double>& state, bool settled,
                 Work& work);
  void make_bounded(System<double>& system);
  void guess(System<double>& system, const ImplicitStage& stage, State<double>& state);
  void turn_cycle(const State<double>& state);
  void turn_stiffly(const State<double>& state);
  void begin_contact(State<double>& state);
  bool update_contact(System<double>& system, State<double>& state, double good);

  std::string name_;
  Directions directions_;
  int pairs_kept_;
  int iterations_;
  std::unique_ptr<RestCycle> cycle_;
  TangentCoefficients matrix_;
  Field<double> mass_;  ///< 0 where there is no unknown
  Field<double> gradient_, z_, z_before_;
  Field<double> x_end_;  ///< of a step that conserves energy
  Pairs pairs_;
  Products sg_, ug_;                 ///< with g where the last step began
  double zg_ = 0;                    ///< the same
  double slope_ = 0;                 ///< p.g there; the step p is pairs_.s[pairs_.count]
  double size_ = 0;                  ///< |p|
  double length_ = 0;                ///< of the step taken, in p; 0: none yet
  bool stiff_ = false;               ///< whether pieces turn as wholes in this stage
  double travelled_ = 0;             ///< length_ |p| since the V-cycle turned
  double norm_ = 0, slope_now_ = 0;  ///< |g| and p.g at the end of the step
  std::vector<Sums> sums_;

  std::shared_ptr<BoundedSystem> bounded_;  ///< the system where it has bounds
  std::unique_ptr<Newton> newton_;          ///< solves stages there whose contacts do not settle
  Field<double> guess_;                     ///< with which they began
  Field<double> impulse_;                   ///< there, minus the gradient with what holds particles
  Field<double> jump_;                      ///< and the part of a step that takes them to their planes
  bool jumps_ = false;
  double norm_at_pressure_ = 0;  ///< |g| when friction followed the pressure last
  int since_pressure_ = 0;       ///< iterations
  int changes_ = 0;              ///< of what planes hold, in this stage
  double norm_at_change_ = 0;    ///< |g| after the last of them
};

/// Whether the energy of its springs has no lower bound.
bool is_unbounded(const System<double>& system) {
  const SolidSystem<double>* solid = system.solid();
  return solid && (system.springs() || solid->refined_body()) &&
         solid->levels().front().body.config().has_negative_volume_stiffness();
}

void QuasiNewton::begin(System<double>& system) {
  if (is_unbounded(system))
    throw InputError(fmt::format(
        "nonlinear_solver \"{}\" minimises an energy, which has no lower bound where the volume stiffness is "
        "negative, as Poisson's ratio below 1/4 makes it; take \"newton\"",
        name_));
  pairs_.kept = pairs_kept_;
  cycle_ = std::make_unique<RestCycle>(system, name_, directions_.additive ? Cycle::additive : Cycle::v);
  const Field<double> mask = mask_of_unknowns(system);
  for (Field<double>* field : {&mass_, &gradient_, &z_, &z_before_}) *field = Field<double>(system.size());
  for (int i = 0; i <= pairs_kept_; ++i) {
    pairs_.s[std::size_t(i)] = Field<double>(system.size());
    if (pairs_kept_ > 0) pairs_.u[std::size_t(i)] = Field<double>(system.size());
  }
  for (const std::ptrdiff_t site : system.particles()) mass_.set(site, system.mass(site) * mask.at(site));
  sums_.resize(std::size_t((mass_.size() + part_size - 1) / part_size));
}

Status QuasiNewton::prepare(const ImplicitStage& stage, Work& work) {
  const TangentCoefficients matrix{
      .mass = 1, .damping = stage.force_velocity ? 0 : stage.gamma, .stiffness = stage.gamma * stage.gamma_x};
  if (matrix == matrix_) return Status::ok;
  matrix_ = matrix;
  ++work.factorisations;
  return cycle_->prepare(matrix_);
}

/// Adds up part(first, count, sums) of all coordinates, always in the same order.
template <class Part>
QuasiNewton::Sums QuasiNewton::sum_over_parts(System<double>& system, Part&& part) {
  parallel_in_groups(system, std::ptrdiff_t(sums_.size()), parts_together, [&](std::ptrdiff_t i) {
    sums_[std::size_t(i)] = {};
    part(i * part_size, std::min(part_size, mass_.size() - i * part_size), sums_[std::size_t(i)]);
  });
  Sums total{};
  for (const Sums& sums : sums_)
    for (std::size_t i = 0; i < total.size(); ++i) total[i] += sums[i];
  return total;
}

const double* from(const Field<double>& field, std::ptrdiff_t first) { return field.axis(0) + first; }
double* from(Field<double>& field, std::ptrdiff_t first) { return field.axis(0) + first; }

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

/// The gradient with friction, without what holds particles.
void QuasiNewton::leave_out_held(System<double>& system, const State<double>& state) {
  gradient_.array() = impulse_.array();
  bounded_->add_friction(state.v, gradient_);
  gradient_.array() = -gradient_.array();
  system.clear_prescribed(gradient_);
  measure_gradient(system);
}

/// Solves for z; makes the last step a pair, if there was one along which the gradient grew; writes the next
/// step to pairs_.s[pairs_.count].
void QuasiNewton::choose_step(System<double>& system, Work& work) {
  std::swap(z_, z_before_);
  if (jumps_) jump_.array() = -jump_.array();  // the step is -z
  cycle_->solve(gradient_, norm_, jumps_ ? jump_ : Field<double>(), z_);
  ++work.linear_solves;
  take_products(system);
  Products of_s, of_u;
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

void QuasiNewton::take_products(System<double>& system) {
  const int count = pairs_.count;
  const bool candidate = length_ > 0 && pairs_kept_ > 0;
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
  Products sg = Products::Zero(), ug = Products::Zero();
  for (int i = 0; i < products; ++i) {
    sg[i] = sums[2 * std::size_t(i)];
    ug[i] = sums[2 * std::size_t(i) + 1];
  }
  const double zg = sums.back();
  if (candidate) {
    sg_[count] = length_ * slope_;
    ug_[count] = zg - ug[count] - zg_;  // z.g - z'.g = g'.z' - u.g' - z.g, as A is symmetric
    const Products sy = sg - sg_, uy = ug - ug_;
    if (sy[count] > least_curvature * std::abs(sg_[count])) {
      pairs_.push(sy, uy);
      if (pairs_.count == count) {  // the oldest is gone
        sg.head<most_pairs>() = sg.tail<most_pairs>().eval();
        ug.head<most_pairs>() = ug.tail<most_pairs>().eval();
      }
    }
  }
  sg_ = sg;
  ug_ = ug;
  zg_ = zg;
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
void QuasiNewton::forget(System<double>& system, const ImplicitStage& stage, State<double>& state,
                         Work& work) {
  move(system, stage, state, -length_);
  pairs_.count = 0;
  length_ = 0;
  evaluate(system, stage, state, work);
}

/// A jump to planes, and the first step after what planes hold has changed, are taken whole.
bool QuasiNewton::take_step(System<double>& system, const ImplicitStage& stage, State<double>& state,
                            bool settled, Work& work) {
  if (!jumps_ && settled) return search(system, stage, state, work);
  move(system, stage, state, 1);
  length_ = 0;
  evaluate(system, stage, state, work);
  return std::isfinite(norm_);
}

void QuasiNewton::make_bounded(System<double>& system) {
  bounded_ = std::make_shared<BoundedSystem>(system);
  jump_ = impulse_ = gradient_;
}

/// Pairs and rotations are of one stage; what lasts is the matrix, and what planes hold.
void QuasiNewton::remember(System<double>& system, Record& record) {
  bool has_matrix = cycle_ != nullptr, has_bounds = bounded_ != nullptr;
  record.keep(has_matrix, has_bounds);
  if (!has_matrix) return;
  record.keep(matrix_.mass, matrix_.damping, matrix_.stiffness);
  if (record.reads()) {
    begin(system);
    cycle_->prepare(matrix_);
    if (has_bounds) make_bounded(system);
  }
  if (has_bounds) record.keep(*bounded_);
}

/// What gravity makes of the velocity until the stage's time, where nothing holds the body: then iterations
/// that are cut short keep its fall.
void QuasiNewton::guess(System<double>& system, const ImplicitStage& stage, State<double>& state) {
  cycle_->add_where_free((stage.t - state.t) * system.solid()->gravity(), state.v);
  cycle_->bend_paths(*stage.x_base, stage.gamma_x, state.v);
}

/// In long searches the body turns far from where they began.
void QuasiNewton::turn_cycle(const State<double>& state) {
  cycle_->place(state.x);
  pairs_.count = 0;
  length_ = 0;
  travelled_ = 0;
}

/// Where particles' rotations differ too much for such long steps.
void QuasiNewton::turn_stiffly(const State<double>& state) {
  cycle_->place_stiffly(state.x);
  pairs_.count = 0;
  length_ = 0;
  stiff_ = true;
}

void QuasiNewton::begin_contact(State<double>& state) {
  jumps_ = bounded_->jump(state.v, jump_);
  norm_at_pressure_ = std::numeric_limits<double>::infinity();
  since_pressure_ = 0;
  changes_ = 0;
}

/// Changes what planes hold after a step, and friction once the rest is solved for that of before: if it
/// followed every iteration, sliding would diverge. True if the rest is a function that has not changed.
bool QuasiNewton::update_contact(System<double>& system, State<double>& state, double good) {
  const bool jumped = jumps_;
  if (changes_ >= most_hasty_changes && norm_ > std::max(good, solved * norm_at_change_)) {
    jumps_ = bounded_->jump(state.v, jump_);
    if (jumps_) pairs_.count = 0;
    return !jumped && !jumps_;
  }
  const bool changed = bounded_->update(impulse_, state.v, norm_);
  ++since_pressure_;
  double friction = 0;
  if (bounded_->slides() && (norm_ < trusted * std::min(norm_at_pressure_, bounded_->push()) ||
                             norm_ <= good || since_pressure_ >= 15)) {
    friction = bounded_->follow_pressure();
    norm_at_pressure_ = std::max(norm_, friction);
    since_pressure_ = 0;
  }
  if (changed || friction > good) cycle_->hold(bounded_->held(state.v));
  jumps_ = bounded_->jump(state.v, jump_);
  if (!changed && !jumps_ && friction <= good) return !jumped;
  pairs_.count = 0;
  length_ = 0;
  leave_out_held(system, state);
  ++changes_;
  norm_at_change_ = norm_;
  return false;
}

Status QuasiNewton::solve(System<double>& system, const ImplicitStage& stage, State<double>& state,
                          Work& work) {
  if (system.bounds()) guess_ = state.v;
  const Status status = solve_stage(system, stage, state, work);
  if (!bounded_) return status;
  if (status == Status::ok) {
    bounded_->end_stage(stage, impulse_);
    return status;
  }
  if (iterations_ > 0 || stage.force_velocity) return status;  // searches for an equilibrium begin anew
  state.v = guess_;
  bounded_->let_go();
  return newton_->solve_for(bounded_, system, stage, state, work);
}

Status QuasiNewton::solve_stage(System<double>& plain, const ImplicitStage& stage, State<double>& state,
                                Work& work) {
  if (!cycle_) begin(plain);
  if (const Status status = prepare(stage, work); status != Status::ok) return status;
  if (plain.bounds() && !bounded_) make_bounded(plain);
  System<double>& system = bounded_ ? *bounded_ : plain;
  if (bounded_) {
    bounded_->begin(stage);
    cycle_->hold(bounded_->held(state.v));
  }
  guess(plain, stage, state);
  if (bounded_) begin_contact(state);
  pairs_.count = 0;
  length_ = 0;
  state.x.array() = stage.x_base->array() + stage.gamma_x * state.v.array();
  system.constrain(stage.t, state.x, state.v);
  cycle_->place(state.x);
  evaluate(system, stage, state, work);
  if (!std::isfinite(norm_)) return Status::non_finite;
  const double good = std::max(tolerance * norm_, bounded_ ? contact_tolerance * bounded_->scale() : 0);
  const double target = iterations_ > 0 ? 0 : stage.conserve_from ? rounding * norm_ : good;
  const int most = iterations_ > 0 ? iterations_ : bounded_ ? most_with_contact : most_iterations;
  const double coordinates = std::sqrt(3 * double(system.particles().size()));
  const double enough =
      coordinates * std::max(stage.enough, negligible * state.x.array().abs().maxCoeff()) / stage.gamma_x;
  const double far = coordinates * share_of_cell * plain.solid()->cell_size();
  int turned_at = 0;
  travelled_ = 0;
  stiff_ = false;
  bool settled = !bounded_;
  int count = 0;  // of those that a given number of iterations means: after contacts and pressures are known
  for (int all = 0, idle = 0; count < most && all < most + most_in_search && (norm_ > target || !settled);
       ++all) {
    if (!stiff_ && all >= turned_at + turned_every && stage.gamma_x * travelled_ > far) {
      turn_cycle(state);
      turned_at = all;
    }
    choose_step(system, work);
    const double before = norm_;
    const bool small = size_ <= enough;
    if (!take_step(system, stage, state, settled, work)) {
      if (settled && (small || before <= good)) return Status::ok;
      const bool had_pairs = pairs_.count > 0;
      if (!had_pairs && stiff_) return Status::newton_stalled;
      forget(system, stage, state, work);
      if (!had_pairs) turn_stiffly(state);
      continue;
    }
    if (!stiff_ && length_ > 0 && length_ < shortest_trusted) turn_stiffly(state);
    if (bounded_) {
      settled = update_contact(system, state, good);
      if (!settled) continue;
    }
    if (!bounded_ || bounded_->touching() == 0 || norm_ < trusted * bounded_->push()) ++count;
    travelled_ += length_ * size_;
    idle = norm_ <= good && norm_ > before / 2 ? idle + 1 : 0;
    if (small || idle == most_idle) return Status::ok;
  }
  if (iterations_ > 0 && bounded_) {
    jump_ = state.v;
    bounded_->put_in_front(state.v);
    impulse_.array() -= mass_.array() * (state.v.array() - jump_.array());
    state.x.array() = stage.x_base->array() + stage.gamma_x * state.v.array();
    system.constrain(stage.t, state.x, state.v);
  }
  return (settled && norm_ <= good) || iterations_ > 0 ? Status::ok : Status::newton_stalled;
}

}  // namespace

NonlinearSolverInfo projective() {
  return {.name = "projective",
          .summary =
              "quasi-Newton with a V-cycle on the tangent at rest, turned with the body: convergence linear",
          .make = [](const IntegratorOptions& o) {
            return std::make_unique<QuasiNewton>(o, "projective", Directions{});
          }};
}

NonlinearSolverInfo lbfgs() {
  return {.name = "lbfgs",
          .summary = "L-BFGS on that V-cycle, two pairs: a few iterations of some seven explicit steps each",
          .make = [](const IntegratorOptions& o) {
            return std::make_unique<QuasiNewton>(o, "lbfgs", Directions{.pairs = most_pairs});
          }};
}

NonlinearSolverInfo nonlinear_cg() {
  return {
      .name = "nonlinear_cg",
      .summary = "nonlinear conjugate gradients with that V-cycle: as lbfgs, with one pair and a line search",
      .make = [](const IntegratorOptions& o) {
        return std::make_unique<QuasiNewton>(o, "nonlinear_cg", Directions{.pairs = 1, .conjugate = true});
      }};
}

NonlinearSolverInfo additive_cg() {
  return {.name = "additive_cg",
          .summary = "the same with an additive cycle, after MAS-PNCG: cheaper iterations, and many more",
          .make = [](const IntegratorOptions& o) {
            return std::make_unique<QuasiNewton>(o, "additive_cg",
                                                 Directions{.pairs = 1, .conjugate = true, .additive = true});
          }};
}

}  // namespace mss
