// Quasi-Newton methods for implicit stages. In place of the tangent's inverse they take B, a V-cycle on the
// springs' tangent at rest between the particles' rotations (rest_cycle.hpp). With the gradient
// g = M (v - v_base) - gamma f:
//   projective    v' = v - B g: a constant matrix for every stage, as projective dynamics has one. Liu,
//                 Bargteil, O'Brien and Kavan, ACM TOG 32 (2013) 214;
//   lbfgs         v' = v - H g, with H the BFGS update of B by the last two steps s and changes y of g
//                 (curvature_pairs.hpp). Liu, Bouaziz and Kavan, ACM TOG 36 (2017) 23;
//   nonlinear_cg  the same with one pair, of which only s is used: conjugate directions, v' = v - a p with
//                 p = B g - (y.B g / y.s) s (Hestenes and Stiefel's formula), and a second force where the
//                 first shows that a = 1 is far off. Wang et al., MAS-PNCG, 2024, took a multilevel additive
//                 Schwarz preconditioner;
//   additive_cg   with B as such a one: the V-cycle's smoothers on all lattices side by side, without
//                 products between them (Bramble, Pasciak and Xu, Math. Comp. 55 (1990) 1).
// An iteration costs a force evaluation and a V-cycle, and keeps the linear momentum of the stage. Iterations
// begin where the body would be if gravity alone changed its velocity, along axes in which nothing holds it.
#include "integrators/nonlinear/quasi_newton.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"
#include "core/springs/solid_system.hpp"
#include "integrators/linear/unknowns.hpp"
#include "integrators/nonlinear/bounded_system.hpp"

namespace mss {

namespace {

/// Of the gradient, to that before the first iteration; and where energy is to be conserved, or until so many
/// iterations have not halved it.
constexpr double tolerance = 1e-10, rounding = 1e-15;
constexpr int most_idle = 4;

constexpr int most_iterations = 2000;
constexpr int most_with_contact = 200;  ///< friction may turn in circles: then Newton's method takes over

/// Iterations in a stage that look for what planes hold, beside those given.
constexpr int most_in_search = 200;

/// The V-cycle turns with the body after so many iterations that have moved it by that share of a cell, rms.
constexpr int turned_every = 8;
constexpr double share_of_cell = 0.1;
constexpr double shortest_trusted = 0.2;  ///< of steps: after shorter ones pieces turn as wholes

/// Moves below this share of the coordinates are rounding.
constexpr double negligible = 1e-14;

/// What a norm over all coordinates is, to their root mean square.
double norm_to_rms(const System<double>& system) { return std::sqrt(3 * double(system.particles().size())); }

}  // namespace

QuasiNewton::QuasiNewton(const IntegratorOptions& options, std::string name, Directions directions)
    : name_(std::move(name)),
      directions_(directions),
      iterations_(options.iterations),
      newton_(std::make_unique<Newton>(options)) {}

QuasiNewton::~QuasiNewton() = default;

namespace {

/// Whether the energy of its springs has no lower bound.
bool is_unbounded(const System<double>& system) {
  const SolidSystem<double>* solid = system.solid();
  return solid && (system.springs() || solid->refined_body()) &&
         solid->levels().front().body.config().has_negative_volume_stiffness();
}

}  // namespace

void QuasiNewton::begin(System<double>& system) {
  if (is_unbounded(system))
    throw InputError(fmt::format(
        "nonlinear_solver \"{}\" minimises an energy, which has no lower bound where the volume stiffness is "
        "negative, as Poisson's ratio below 1/4 makes it; take \"newton\"",
        name_));
  pairs_.kept = directions_.pairs;
  cycle_ = std::make_unique<RestCycle>(system, name_, directions_.additive ? Cycle::additive : Cycle::v);
  const Field<double> mask = mask_of_unknowns(system);
  for (Field<double>* field : {&mass_, &gradient_, &z_, &z_before_}) *field = Field<double>(system.size());
  for (int i = 0; i <= pairs_.kept; ++i) {
    pairs_.s[std::size_t(i)] = Field<double>(system.size());
    if (pairs_.kept > 0) pairs_.u[std::size_t(i)] = Field<double>(system.size());
  }
  for (const std::ptrdiff_t site : system.particles()) mass_.set(site, system.mass(site) * mask.at(site));
}

Status QuasiNewton::prepare(const ImplicitStage& stage, Work& work) {
  const TangentCoefficients matrix{
      .mass = 1, .damping = stage.force_velocity ? 0 : stage.gamma, .stiffness = stage.gamma * stage.gamma_x};
  if (matrix == matrix_) return Status::ok;
  matrix_ = matrix;
  ++work.factorisations;
  return cycle_->prepare(matrix_);
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

void QuasiNewton::forget_steps() {
  pairs_.count = 0;
  length_ = 0;
}

/// In long searches the body turns far from where they began.
void QuasiNewton::turn_cycle(const State<double>& state) {
  cycle_->place(state.x);
  forget_steps();
  travelled_ = 0;
}

/// Where particles' rotations differ too much for such long steps.
void QuasiNewton::turn_stiffly(const State<double>& state) {
  cycle_->place_stiffly(state.x);
  forget_steps();
  stiff_ = true;
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
  begin_stage(system, stage, state, work);
  if (!std::isfinite(norm_)) return Status::non_finite;
  return iterate(system, stage, state, goal_of(system, stage, state), work);
}

void QuasiNewton::begin_stage(System<double>& system, const ImplicitStage& stage, State<double>& state,
                              Work& work) {
  if (bounded_) {
    bounded_->begin(stage);
    cycle_->hold(bounded_->held(state.v));
  }
  guess(system, stage, state);
  settled_ = !bounded_;
  if (bounded_) begin_contact(state);
  forget_steps();
  travelled_ = 0;
  stiff_ = false;
  state.x.array() = stage.x_base->array() + stage.gamma_x * state.v.array();
  system.constrain(stage.t, state.x, state.v);
  cycle_->place(state.x);
  evaluate(system, stage, state, work);
}

/// By what is left to solve before the first iteration.
QuasiNewton::Goal QuasiNewton::goal_of(const System<double>& system, const ImplicitStage& stage,
                                       const State<double>& state) const {
  Goal goal{.good = tolerance * norm_, .most = bounded_ ? most_with_contact : most_iterations};
  if (bounded_) goal.good = std::max(goal.good, contact_tolerance * bounded_->scale());
  goal.target = stage.conserve_from ? rounding * norm_ : goal.good;
  if (iterations_ > 0) {
    goal.target = 0;
    goal.most = iterations_;
  }
  const double negligible_move = negligible * state.x.array().abs().maxCoeff();
  goal.enough = norm_to_rms(system) * std::max(stage.enough, negligible_move) / stage.gamma_x;
  return goal;
}

Status QuasiNewton::iterate(System<double>& system, const ImplicitStage& stage, State<double>& state,
                            const Goal& goal, Work& work) {
  const double far = norm_to_rms(system) * share_of_cell * system.solid()->cell_size();
  int counted = 0;  // of the iterations given: those after contacts and pressures are known
  for (int all = 0, turned_at = 0, idle = 0;
       counted < goal.most && all < goal.most + most_in_search && (norm_ > goal.target || !settled_); ++all) {
    if (!stiff_ && all >= turned_at + turned_every && stage.gamma_x * travelled_ > far) {
      turn_cycle(state);
      turned_at = all;
    }
    choose_step(system, work);
    const double before = norm_;
    const bool small = size_ <= goal.enough;
    if (!take_step(system, stage, state, work)) {
      if (settled_ && (small || before <= goal.good)) return Status::ok;
      const bool had_pairs = pairs_.count > 0;
      if (!had_pairs && stiff_) return Status::newton_stalled;
      go_back(system, stage, state, work);
      if (!had_pairs) turn_stiffly(state);
      continue;
    }
    if (!stiff_ && length_ > 0 && length_ < shortest_trusted) turn_stiffly(state);
    if (bounded_) settled_ = update_contact(system, state, goal.good);
    if (!settled_) continue;
    if (knows_push()) ++counted;
    travelled_ += length_ * size_;
    idle = norm_ <= goal.good && norm_ > before / 2 ? idle + 1 : 0;
    if (small || idle == most_idle) return Status::ok;
  }
  if (iterations_ > 0 && bounded_) put_in_front(system, stage, state);
  return (settled_ && norm_ <= goal.good) || iterations_ > 0 ? Status::ok : Status::newton_stalled;
}

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
