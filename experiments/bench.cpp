// mss_bench: one update of a full cube by every kernel this processor runs, and by the two baselines. Google
// Benchmark's own options apply, as in --benchmark_filter=sweep/x86-64-v3 or --benchmark_format=json.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstdint>
#include <utility>
#include <vector>

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

int cells(const benchmark::State& bench) { return int(bench.range(0)); }
int threads(const benchmark::State& bench) { return int(bench.range(1)); }

/// The kernel's place in sweep_kernels() is part of the type because Google Benchmark takes plain functions.
template <class Real, std::size_t kernel>
void sweep(benchmark::State& bench) {
  const Body body(timing_cube(cells(bench)));
  SpringSystem<Real> system(body, {.gravity = gravity}, {threads(bench), sweep_kernels<Real>()[kernel].name});
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
  reference::PlainLoop loop(model);
  while (bench.KeepRunning()) loop.step(TimingWorkload::dt);
  count_springs(bench, model.springs().size());
}

void add(const std::string& name, void (*function)(benchmark::State&),
         const std::vector<std::int64_t>& thread_counts) {
  benchmark::RegisterBenchmark(name.c_str(), function)
      ->ArgNames({"n", "threads"})
      ->ArgsProduct({{7, 20, 50}, thread_counts})
      ->Unit(benchmark::kMicrosecond)
      ->UseRealTime();
}

template <class Real, std::size_t... kernel>
void add_sweeps(const char* precision, const std::vector<std::int64_t>& thread_counts,
                std::index_sequence<kernel...>) {
  const auto add_one = [&](std::size_t place, void (*function)(benchmark::State&)) {
    const auto& kernels = sweep_kernels<Real>();
    if (place < kernels.size())
      add(fmt::format("sweep/{}/{}", kernels[place].name, precision), function, thread_counts);
  };
  (add_one(kernel, sweep<Real, kernel>), ...);
}

}  // namespace

}  // namespace mss

int main(int argc, char** argv) {
  using namespace mss;
  std::vector<std::int64_t> thread_counts{1};
  if (available_cores() > 1) thread_counts.push_back(available_cores());
  constexpr std::make_index_sequence<3> kernels{};  // as many as are ever compiled
  add_sweeps<double>("double", thread_counts, kernels);
  add_sweeps<float>("single", thread_counts, kernels);
  add("algorithm_1", algorithm1, thread_counts);
  add("plain_loop", plain_loop, {1});
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::AddCustomContext("mss", program_version());
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
