#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/system/system.hpp"

namespace mss {

class Record;

/// How an advance ended. Everything but `ok` is a result too: tables and charts show it.
enum class Status {
  ok,
  non_finite,             ///< a position or velocity became infinite or not a number
  newton_stalled,         ///< an implicit step found no solution
  not_positive_definite,  ///< a linear system could not be factored
  linear_stalled,         ///< an iterative linear solver did not reach its tolerance
  step_limit,             ///< the allowed number of steps did not suffice
  tolerance_missed,       ///< no step however small met the tolerance
  device_lost,            ///< a device stopped working
  interrupted             ///< the user stopped it
};

/// The status as tables and files spell it.
std::string_view to_string(Status status);

/// What an advance cost, counted rather than timed.
struct Work {
  std::int64_t steps = 0;
  std::int64_t force_evaluations = 0;
  std::int64_t jacobians = 0;
  std::int64_t factorisations = 0;
  std::int64_t linear_solves = 0;
  std::int64_t products = 0;  ///< of a tangent and a vector

  Work& operator+=(const Work& other);
  /// See core/base/record.hpp.
  void remember(Record& record);
};

/// When planes of the laws `impulse` and `thesis` act on what a method moves.
enum class Collisions {
  after_steps,
  inside_steps,  ///< as System::bounds() has them: methods that find forces where steps end
  never
};

/// A time-stepping method.
template <class Real>
class Integrator {
 public:
  Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;
  virtual ~Integrator() = default;

  /// Takes `state` towards t_end [s] and adds to `work`. Methods of fixed step take whole steps only and stop
  /// at the one nearest to t_end, so that a trajectory does not depend on how often it is sampled; adaptive
  /// methods stop at t_end. On failure the state is the last one computed. Throws InputError where the method
  /// cannot serve the system, see check().
  Status advance(System<Real>& system, State<Real>& state, double t_end, Work& work) {
    check(system);
    return do_advance(system, state, t_end, work);
  }

  /// Throws InputError, in words for users, where the method would move the system wrongly: what it meets
  /// contradicts the facts in the registry, see IntegratorInfo::make().
  void check(System<Real>& system) const {
    if (check_) check_(system);
  }

  /// When planes act on what it moves.
  Collisions collisions() const { return collisions_; }

  /// Where it takes its steps; empty: on the processor.
  virtual std::string device() const { return {}; }
  /// Of all advances, how long states were carried between the processor and that device [s].
  virtual double transfer_seconds() const { return 0; }

  /// Discards all history. Call it after editing a state, before the next advance.
  virtual void reset() {}

  /// Keeps the history in a record, or takes it from one (core/base/record.hpp), between two advances of the
  /// system: with it and the state another process goes on. What is not kept must follow from these, bit for
  /// bit, unless IntegratorInfo::exact_restart is false.
  virtual void remember(System<Real>& system, Record& record) {
    static_cast<void>(system), static_cast<void>(record);
  }

 private:
  friend struct IntegratorInfo;

  virtual Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) = 0;

  Collisions collisions_ = Collisions::after_steps;
  std::function<void(System<Real>&)> check_;  ///< empty: of a method outside the registry
};

/// What a user may set about a method.
struct IntegratorOptions {
  double dt = 1e-3;  ///< step of fixed-step methods, first step of adaptive ones; 0: they choose it [s]
  std::string linear_solver = "automatic";  ///< of implicit methods
  Tangent tangent = Tangent::elastic;  ///< of implicit methods; projected where the elastic is indefinite
  double linear_tolerance = 1e-10;     ///< of iterative linear solvers: residual over right-hand side
  double spectral_radius = 0.9;        ///< of generalized_alpha, at infinite steps; from 0 to 1
  double tolerance = 1e-6;             ///< of adaptive methods: local error over the scales below
  std::string nonlinear_solver = "newton";  ///< of implicit methods and `static`
  int iterations =
      0;  ///< of it, in every stage; 0: as many as its tolerance needs; passes of xpbd, vbd; 0: one
  double chebyshev_radius =
      0;                       ///< of vbd, Chebyshev's: spectral radius of a pass, from 0 to below 1; 0: none
  int region_width = 2;        ///< of shape_matching, in cells; 0: one region
  double alpha = 1;            ///< of shape_matching: share of the way to the goal, from 0 to 1
  std::string device = "cpu";  ///< that takes the steps, of `mss list devices`
  double length_scale = 1;     ///< of positions [m]
  double speed_scale = 1;      ///< of velocities [m/s]
  long most_steps = 10000000;  ///< adaptive methods may take in one advance, or until its next event
};

/// Largest step [s] up to which a method is stable on the test equation x'' = -omega^2 x - damping x'; 0 if
/// it is at none. Sharp: the next larger step is unstable.
using StabilityLimit = double (*)(double omega, double damping);

/// The limit of methods that are stable iff omega^2 dt^2 + 2 damping dt < 4.
double central_limit(double omega, double damping);

/// The limit of methods that multiply a solution y = exp(lambda t) of the test equation by R(lambda dt) in a
/// step, R(z) = sum of coefficients[k] z^k: the largest step up to which |R| <= 1 for both roots lambda.
/// Coefficients as IntegratorInfo::polynomial has them, those of Runge-Kutta methods in order of z.
double polynomial_limit(const std::vector<double>& coefficients, double omega, double damping);

/// Part of a step, in shares of it: x += drift dt v, then v += kick dt a.
struct DriftKick {
  double drift, kick;
};

/// The limit of methods whose steps are these parts, one after the other: the largest step up to which every
/// shorter one leaves the test equation bounded.
double splitting_limit(const std::vector<DriftKick>& parts, double omega, double damping);

/// How a method advances time.
enum class Stepping {
  fixed,       ///< in steps of dt
  adaptive,    ///< in steps it chooses by a tolerance
  reduced,     ///< by the few coordinates of a reduced body, see ReducedMotion, to which it is tied
  equilibrium  ///< not at all: it finds where a body would be at rest at the end time
};

/// Who solves the linear systems of an implicit method.
enum class LinearAlgebra {
  chosen,       ///< `linear_solver`
  own_factors,  ///< the method, by factors of a matrix
  own_products  ///< the method, by products with it
};

/// Facts about a method. Tests measure that they are true.
struct IntegratorInfo {
  std::string name;
  std::string summary;  ///< one line for `mss list`
  Stepping stepping = Stepping::fixed;
  int order_undamped = 1;  ///< of positions at a fixed time; of methods of fixed step
  int order_damped = 1;
  bool implicit = false;
  Collisions collisions = Collisions::after_steps;
  LinearAlgebra linear_algebra = LinearAlgebra::chosen;
  /// Asks for forces of materials that relax within its steps alone, and tells where these end (StepMemory);
  /// at most of second order, as forces then are.
  bool relaxes = false;
  bool local_steps = false;   ///< has one force a step, v += dt a, x += dt v: LocalSteps can take its place
  bool iterates = false;      ///< as often as `iterations` says
  bool symplectic = false;    ///< without damping
  bool energy_exact = false;  ///< without damping; needs a discrete gradient
  bool springs_only = false;  ///< steps bodies of springs in its own way; no other model, and no forces
  bool has_modulus = true;    ///< false: not the motion of a material, however small the step
  /// Goes on from what remember() keeps with the same bits as if it had not stopped; false: within its
  /// tolerance, because it begins anew.
  bool exact_restart = true;
  StabilityLimit limit = nullptr;  ///< nullptr: stable for any step
  /// Undamped motions grow just beyond the limit, where w dt is nearly pi, and no more at steps a percent
  /// longer: no search through steps finds that, but a body has many frequencies, and some meet it.
  bool resonant_limit = false;
  /// Of one-step methods that take x' = z x / dt to R(z) x: coefficients of R, ascending. Empty: others.
  std::vector<double> polynomial = {};
  /// Of a method that splits a step into drifts and kicks, one after the other.
  std::vector<DriftKick> splitting = {};

  /// Of a method that is another one of the registry but for how it is computed: that one's name, and what
  /// differs. Counts of methods leave it out.
  std::string variant_of = {};
  std::string variation = {};

  std::string nonlinear_solver = {};  ///< of a variant that has its own
  /// Endings of its name that experiments try as methods of their own, see find_integrator().
  std::vector<std::string> variants = {};

  /// Whether it moves particles one by one.
  bool moves_particles() const { return stepping == Stepping::fixed || stepping == Stepping::adaptive; }

  /// Whether it moves bodies of springs only.
  bool needs_springs() const { return energy_exact || springs_only; }

  /// Whether a step begins with what outer forces, those of penalty planes among them, do to free particles.
  bool steps_after_outer_forces() const { return springs_only || !has_modulus; }

  /// The method, which checks every system that it meets against these facts.
  template <class Real>
  std::unique_ptr<Integrator<Real>> make(const IntegratorOptions& options) const;

  /// The same steps taken on a device, see integrators/device/; empty: they are not.
  std::function<std::unique_ptr<Integrator<float>>(const IntegratorOptions&)> make_single_on_device = {};
  std::function<std::unique_ptr<Integrator<double>>(const IntegratorOptions&)> make_double_on_device = {};

  /// Empty: the method computes in double precision only.
  std::function<std::unique_ptr<Integrator<float>>(const IntegratorOptions&)> make_single = {};
  std::function<std::unique_ptr<Integrator<double>>(const IntegratorOptions&)> make_double = {};
};

/// All methods, in the order they are listed and charted.
const std::vector<IntegratorInfo>& integrators();

/// The method of that name. Its variants METHOD:N, METHOD/SOLVER and METHOD/SOLVER:N iterate N times, in that
/// nonlinear solver, whatever the options say: "vbd:5", "backward_euler/lbfgs:5". Throws InputError that
/// names the nearest known one, or says why there is no such variant.
const IntegratorInfo& find_integrator(std::string_view name);

/// The method without its number of iterations: methods that differ in it only are a family.
std::string family_of(std::string_view name);

}  // namespace mss
