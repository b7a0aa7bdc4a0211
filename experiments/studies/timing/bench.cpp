// mss_bench: one update of a full cube by every kernel that this processor supports, by Algorithm 1 and by
// the plain loop; an implicit step and its parts; modes. Google Benchmark's own options apply, as in
// --benchmark_filter=sweep/x86-64-v3 or --benchmark_format=json.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/linear/cholmod.hpp"
#include "integrators/linear/constant_matrix.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/linear/rest_cycle.hpp"
#include "reference/algorithm1.hpp"
#include "reference/plain_loop.hpp"

namespace mss::studies::timing {

namespace {

const Vec3 gravity(0, 0, TimingWorkload::gravity);

void count_springs(benchmark::State& bench, std::size_t springs) {
  bench.counters["time_per_spring"] = benchmark::Counter(
      double(springs), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

int cells(const benchmark::State& bench) { return int(bench.range(0)); }
int threads(const benchmark::State& bench) { return int(bench.range(1)); }

/// The kernel's place in sweep_kernels() is part of the type because Google Benchmark takes plain functions.
template <class Real, std::size_t kernel, bool guarded>
void sweep(benchmark::State& bench) {
  BodyConfig config = timing_cube(cells(bench));
  config.fold_guard = guarded ? default_fold_guard : 0;
  const Body body(config);
  SpringSystem<Real> system(body, {.gravity = gravity},
                            {threads(bench), runnable_copies<SweepKernel<Real>>()[kernel].name});
  State<Real> state = system.rest_state();
  const double dt = TimingWorkload::dt;
  while (bench.KeepRunning()) system.kick_drift({.kick_before = dt, .drift_new = dt}, dt, 1, state);
  count_springs(bench, body.spring_count());
}

void algorithm1(benchmark::State& bench) {
  reference::Algorithm1 model(timing_cube(cells(bench)), gravity, threads(bench));
  while (bench.KeepRunning()) model.step(TimingWorkload::dt);
  count_springs(bench, model.springs().size());
}

void plain_loop(benchmark::State& bench) {
  const reference::Algorithm1 model(timing_cube(cells(bench)), gravity, 1);
  reference::PlainLoop<double> loop(model);
  while (bench.KeepRunning()) loop.step(TimingWorkload::dt);
  count_springs(bench, model.springs().size());
}

/// A stretched cube with an implicit step of 1/60 s, larger than its longest period, as in a game.
struct ImplicitCase {
  explicit ImplicitCase(int n, int threads)
      : body(timing_cube(n)),
        system(body, {.gravity = gravity}, {.threads = threads}),
        state(stretched_state(system, TimingWorkload::stretch)) {}
  static constexpr double dt = 1.0 / 60;
  static constexpr TangentCoefficients sum{
      .mass = 1, .damping = dt, .stiffness = dt * dt, .kind = Tangent::projected};
  Body body;
  SpringSystem<double> system;
  State<double> state;
};

void implicit_step(benchmark::State& bench) {
  ImplicitCase c(cells(bench), threads(bench));
  const auto method = find_integrator("backward_euler_linear").make<double>({.dt = ImplicitCase::dt});
  Work work;
  method->advance(c.system, c.state, ImplicitCase::dt, work);  // analyses the pattern
  while (bench.KeepRunning()) method->advance(c.system, c.state, c.state.t + ImplicitCase::dt, work);
  bench.counters["factorisations"] = double(work.factorisations) / double(work.steps);
}

/// Five iterations of L-BFGS in place of the linear solve.
void lbfgs_step(benchmark::State& bench) {
  ImplicitCase c(cells(bench), threads(bench));
  const auto method =
      find_integrator("backward_euler")
          .make<double>({.dt = ImplicitCase::dt, .nonlinear_solver = "lbfgs", .iterations = 5});
  Work work;
  while (bench.KeepRunning()) method->advance(c.system, c.state, c.state.t + ImplicitCase::dt, work);
  bench.counters["forces"] = double(work.force_evaluations) / double(work.steps);
}

/// The cycle at rest of quasi-Newton methods.
void rest_cycle(benchmark::State& bench) {
  ImplicitCase c(cells(bench), threads(bench));
  RestCycle cycle(c.system, "bench");
  Field<double> rhs(c.system.size()), solution(c.system.size());
  c.system.force(0, c.state.x, c.state.v, rhs);
  cycle.prepare(ImplicitCase::sum);
  cycle.place(c.state.x);
  while (bench.KeepRunning()) cycle.solve(rhs, 1, {}, solution);
}

/// The constant matrix of `separable`: three right-hand sides.
void separable_solve(benchmark::State& bench) {
  ImplicitCase c(cells(bench), threads(bench));
  const auto solver = separable_solver(c.body, c.system);
  Field<double> rhs(c.system.size()), solution(c.system.size());
  c.system.force(0, c.state.x, c.state.v, rhs);
  solver->prepare(bounding_matrix(c.body, 1, ImplicitCase::dt, ImplicitCase::dt * ImplicitCase::dt));
  while (bench.KeepRunning()) solver->solve(c.system, rhs, solution);
}

void factor_and_solve(benchmark::State& bench) {
  ImplicitCase c(cells(bench), threads(bench));
  SparseMatrix matrix = c.system.tangents()->pattern();
  c.system.tangents()->values(0, c.state.x, c.state.v, ImplicitCase::sum, matrix);
  Cholesky cholesky;
  cholesky.factor(matrix);
  const Eigen::VectorXd rhs = Eigen::VectorXd::Ones(matrix.rows());
  Eigen::VectorXd solution(matrix.rows());
  while (bench.KeepRunning()) {
    cholesky.factor(matrix);
    cholesky.solve(rhs, solution);
  }
}

/// Ten modes of a free cube: which search is faster says where slowest_modes() changes from one to the other.
template <ModeSearch search>
void modes(benchmark::State& bench) {
  ImplicitCase c(cells(bench), threads(bench));
  const State<double> rest = c.system.undeformed_state();
  Work work;
  while (bench.KeepRunning()) slowest_modes(c.system, rest, 10, work, search);
}

/// Conjugate gradients to 1e-6, with a force as right-hand side; their preparation is not timed.
template <bool matrix_free>
void conjugate_gradients(benchmark::State& bench) {
  ImplicitCase c(cells(bench), threads(bench));
  const auto solver = find_linear_solver(matrix_free ? "matrix_free" : "pcg").make(1e-6);
  Field<double> rhs(c.system.size()), solution(c.system.size());
  c.system.force(0, c.state.x, c.state.v, rhs);
  Work work;
  solver->prepare(c.system, 0, c.state.x, c.state.v, ImplicitCase::sum, work);
  while (bench.KeepRunning()) solver->solve(rhs, solution, work);
  bench.counters["iterations"] = double(work.products) / double(work.linear_solves);
}

void add(const std::string& name, void (*function)(benchmark::State&),
         const std::vector<std::int64_t>& thread_counts,
         const std::vector<std::int64_t>& sizes = {7, 20, 50}) {
  benchmark::RegisterBenchmark(name.c_str(), function)
      ->ArgNames({"n", "threads"})
      ->ArgsProduct({sizes, thread_counts})
      ->Unit(benchmark::kMicrosecond)
      ->UseRealTime();
}

template <class Real, std::size_t... kernel>
void add_sweeps(const char* precision, const std::vector<std::int64_t>& thread_counts,
                std::index_sequence<kernel...>) {
  const auto add_one = [&](const char* name, std::size_t place, void (*function)(benchmark::State&)) {
    const auto& kernels = runnable_copies<SweepKernel<Real>>();
    if (place < kernels.size())
      add(fmt::format("{}/{}/{}", name, kernels[place].name, precision), function, thread_counts);
  };
  (add_one("sweep", kernel, sweep<Real, kernel, false>), ...);
  (add_one("guarded_sweep", kernel, sweep<Real, kernel, true>), ...);
}

}  // namespace

}  // namespace mss::studies::timing

int main(int argc, char** argv) {
  using namespace mss;
  using namespace mss::studies::timing;
  std::vector<std::int64_t> thread_counts{1};
  if (available_cores() > 1) thread_counts.push_back(available_cores());
  constexpr std::make_index_sequence<3> kernels{};  // as many as are ever compiled
  add_sweeps<double>("double", thread_counts, kernels);
  add_sweeps<float>("single", thread_counts, kernels);
  add("algorithm_1", algorithm1, thread_counts);
  add("plain_loop", plain_loop, {1});
  add("implicit/step", implicit_step, {1}, {7, 10, 20});
  add("implicit/lbfgs_step", lbfgs_step, thread_counts, {7, 10, 20});
  add("implicit/rest_cycle", rest_cycle, thread_counts, {7, 10, 20});
  add("implicit/separable_solve", separable_solve, thread_counts, {7, 10, 20});
  add("implicit/factor_and_solve", factor_and_solve, {1}, {7, 10, 15});
  add("implicit/pcg", conjugate_gradients<false>, {1}, {7, 10, 20});
  add("implicit/matrix_free", conjugate_gradients<true>, thread_counts, {7, 10, 20});
  add("modes/factored", modes<ModeSearch::factored>, {1}, {7, 11, 15, 20});
  add("modes/multigrid", modes<ModeSearch::multigrid>, {1}, {7, 11, 15, 20, 28});
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::AddCustomContext("mss", program_version());
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
