#pragma once

#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "integrators/linear/rest_cycle.hpp"
#include "integrators/nonlinear/curvature_pairs.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

class BoundedSystem;

/// What a quasi-Newton method's directions are made of.
struct Directions {
  int pairs = 0;
  bool conjugate = false;  ///< of a pair only the step
  bool additive = false;   ///< by lattices side by side
};

/// Quasi-Newton methods for implicit stages: quasi_newton.cpp has their formulas, and begins and ends stages;
/// quasi_newton_step.cpp has an iteration, quasi_newton_contact.cpp what planes change in it.
class QuasiNewton final : public NonlinearSolver {
 public:
  QuasiNewton(const IntegratorOptions& options, std::string name, Directions directions);
  ~QuasiNewton() override;

  Status solve(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work) override;
  void end_step(const StepTaken& step, State<double>& state, Field<double>* a) override;
  void remember(System<double>& system, Record& record) override;

 private:
  using Sums = std::array<double, 2 * (most_pairs + 1) + 1>;

  /// When a stage is solved.
  struct Goal {
    double good = 0;    ///< |g| that will do
    double target = 0;  ///< |g| at which iterations end at once
    double enough = 0;  ///< the same of |p|
    int most = 0;       ///< iterations
  };

  // The stage.
  void begin(System<double>& system);
  Status prepare(const ImplicitStage& stage, Work& work);
  Status solve_stage(System<double>& plain, const ImplicitStage& stage, State<double>& state, Work& work);
  void begin_stage(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  Goal goal_of(const System<double>& system, const ImplicitStage& stage, const State<double>& state) const;
  Status iterate(System<double>& system, const ImplicitStage& stage, State<double>& state, const Goal& goal,
                 Work& work);
  void guess(System<double>& system, const ImplicitStage& stage, State<double>& state);
  void turn_cycle(const State<double>& state);
  void turn_stiffly(const State<double>& state);
  void forget_steps();

  // An iteration.
  template <class Part>
  Sums sum_over_parts(System<double>& system, Part&& part);
  void move(System<double>& system, const ImplicitStage& stage, State<double>& state, double length);
  void evaluate(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  void measure_gradient(System<double>& system);
  void choose_step(System<double>& system, Work& work);
  void take_products(System<double>& system);
  void take_pair(PairProducts& sg, PairProducts& ug, double zg);
  bool search(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  void improve_length(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  void go_back(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);

  // Contact.
  void make_bounded(System<double>& system);
  void begin_contact(State<double>& state);
  bool take_step(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  void leave_out_held(System<double>& system, const State<double>& state);
  bool update_contact(System<double>& system, State<double>& state, double good);
  double follow_pressure(double good);
  bool knows_push() const;
  void put_in_front(System<double>& system, const ImplicitStage& stage, State<double>& state);

  std::string name_;
  Directions directions_;
  int iterations_;  ///< given, or 0: until the stage is solved
  std::unique_ptr<RestCycle> cycle_;
  TangentCoefficients matrix_;
  Field<double> mass_;  ///< 0 where there is no unknown
  Field<double> gradient_, z_, z_before_;
  Field<double> x_end_;  ///< of a step that conserves energy
  CurvaturePairs pairs_;
  PairProducts sg_, ug_;             ///< with g where the last step began
  double zg_ = 0;                    ///< the same
  double slope_ = 0;                 ///< p.g there; the step p is pairs_.s[pairs_.count]
  double size_ = 0;                  ///< |p|
  double length_ = 0;                ///< of the step taken, in p; 0: none that a pair can be made of
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
  bool settled_ = true;          ///< whether g is that of a function which has not changed in the last step
  double norm_at_pressure_ = 0;  ///< |g| when friction followed the pressure last
  int since_pressure_ = 0;       ///< iterations
  int changes_ = 0;              ///< of what planes hold, in this stage
  double norm_at_change_ = 0;    ///< |g| after the last of them
};

}  // namespace mss
