// mss_bench: one update of a full cube by every kernel this processor runs, and by the two baselines. Google
// Benchmark's own options apply, as in --benchmark_filter=sweep/x86-64-v3 or --benchmark_format=json.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "core/spring_system.hpp"
#include "experiments/provenance.hpp"
#include "experiments/timing.hpp"
#include "reference/algorithm1.hpp"
#include "reference/plain_loop.hpp"

namespace mss {

namespace {

const Vec3 gravity(0, 0, TimingWorkload::gravity);

void count_springs(benchmark::State& bench, std::size_t springs) {
  bench.counters["time_per_spring"] = benchmark::Counter(
      double(springs), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

template <class Real>
void sweep(benchmark::State& bench, const std::string& kernel, int threads, int n) {
  const Body body(timing_cube(n));
  SpringSystem<Real> system(body, {.gravity = gravity, .holds = {}, .loads = {}}, {threads, kernel});
  State<Real> state = system.rest_state();
  const double dt = TimingWorkload::dt;
  for (auto _ : bench) system.kick_drift({.kick_before = dt, .drift_new = dt}, dt, 1, state);
  count_springs(bench, body.spring_count());
}

void algorithm1(benchmark::State& bench, int threads, int n) {
  reference::Algorithm1 model(timing_cube(n), gravity, threads);
  for (auto _ : bench) model.step(TimingWorkload::dt);
  count_springs(bench, model.springs().size());
}

void plain_loop(benchmark::State& bench, int n) {
  const reference::Algorithm1 model(timing_cube(n), gravity, 1);
  reference::PlainLoop loop(model);
  for (auto _ : bench) loop.step(TimingWorkload::dt);
  count_springs(bench, model.springs().size());
}

template <class... Arguments>
void add(const std::string& name, Arguments&&... arguments) {
  benchmark::RegisterBenchmark(name.c_str(), std::forward<Arguments>(arguments)...)
      ->Unit(benchmark::kMicrosecond)
      ->UseRealTime();
}

template <class Real>
void add_sweeps(int n, int threads) {
  for (const auto& kernel : sweep_kernels<Real>())
    add(fmt::format("sweep/{}/{}/{}/threads:{}", kernel.name, sizeof(Real) == 4 ? "single" : "double", n,
                    threads),
        sweep<Real>, std::string(kernel.name), threads, n);
}

}  // namespace

}  // namespace mss

int main(int argc, char** argv) {
  using namespace mss;
  for (const int n : {7, 20, 50}) {
    for (const int threads : available_cores() > 1 ? std::vector{1, available_cores()} : std::vector{1}) {
      add_sweeps<double>(n, threads);
      add_sweeps<float>(n, threads);
      add(fmt::format("algorithm_1/{}/threads:{}", n, threads), algorithm1, threads, n);
    }
    add(fmt::format("plain_loop/{}/threads:1", n), plain_loop, n);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::AddCustomContext("mss", program_version());
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
