// A step of other programs' soft bodies beside ours.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/spring_system.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "integrators/fixed_step.hpp"
#include "reference/bullet_cube.hpp"

namespace mss::studies::timing {

namespace {

using Workload = TimingWorkload;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double peer_step = 1.0 / 60;  ///< [s]; a step takes as long whatever it is

/// Our step with a number of threads.
struct Ours {
  Ours(const Body& body, int threads)
      : system(body, {.gravity = Vec3(0, 0, Workload::gravity)}, {.threads = threads}),
        integrator(find_integrator("semi_implicit_euler").make<double>({.dt = Workload::dt})),
        state(stretched_state(system, Workload::stretch)) {}
  double take(long steps) {
    return seconds_of(
        [&] { integrator->advance(system, state, state.t + double(steps) * Workload::dt, work); });
  }
  SpringSystem<double> system;
  std::unique_ptr<Integrator<double>> integrator;
  State<double> state;
  Work work;
};

/// False if stopped.
bool add_row(int n, const PeerTimingConfig& config, const Progress& progress, Table& table) {
  const Body body(timing_cube(n));
  reference::BulletCube bullet(body, Vec3(0, 0, Workload::gravity));
  const auto take_peer = [&](long steps) {
    return seconds_of([&] {
      for (long i = 0; i < steps; ++i) bullet.step(peer_step);
    });
  };
  std::vector<std::unique_ptr<Ours>> ours;
  for (const int threads : config.threads) ours.push_back(std::make_unique<Ours>(body, threads));
  std::vector<long> steps;
  steps.reserve(ours.size());
  for (const auto& one : ours)
    steps.push_back(std::max(steps_between_checks, sample_length(config.sample_seconds, [&](long count) {
                                                     return one->take(count);
                                                   }).steps));
  const long peer_steps = sample_length(config.sample_seconds, take_peer).steps;
  const auto samples = measure_interleaved(config.repetitions, ours.size() + 1, progress, [&](std::size_t i) {
    return i < ours.size() ? ours[i]->take(steps[i]) / double(steps[i])
                           : take_peer(peer_steps) / double(peer_steps);
  });
  if (progress.stopped()) return false;
  std::size_t best = 0;
  for (std::size_t i = 1; i < ours.size(); ++i)
    if (quartiles(samples[i]).median < quartiles(samples[best]).median) best = i;
  const Quartiles peer = quartiles(samples.back()), ratio = quartiles_of_ratio(samples.back(), samples[best]);
  const bool finite = bullet.position(0).allFinite();
  table.add({"Bullet", reference::BulletCube::version(), n, peer.median, peer.q1, peer.q3,
             quartiles(samples[best]).median, config.threads[best], ratio.median, ratio.q1, ratio.q3,
             std::string(to_string(finite ? Status::ok : Status::non_finite))});
  return true;
}

}  // namespace

Table measure_peers(const PeerTimingConfig& config, Progress& progress) {
  Table table({{"program"},
               {"version"},
               {"cells"},
               {"seconds_per_step", "s"},
               {"q1", "s"},
               {"q3", "s"},
               {"our_seconds_per_step", "s"},
               {"our_threads"},
               {"over_ours"},
               {"over_ours_q1"},
               {"over_ours_q3"},
               {"status"}});
  if (reference::BulletCube::version().empty()) {
    table.add({"Bullet", "", 0, none, none, none, none, 0, none, none, none, "not installed"});
    return table;
  }
  for (const int n : config.cells) {
    progress.report(0.99, fmt::format("Bullet, {} cells per edge", n));
    if (!add_row(n, config, progress, table)) break;
  }
  return table;
}

std::string peers_text(const Table& table) {
  std::string text;
  for (std::size_t r = 0; r < table.size(); ++r)
    text += table.text(r, "status") == "not installed"
                ? fmt::format("{}: not installed\n", table.text(r, "program"))
                : fmt::format("{} {}, n = {}: a step takes {:.3g} ms, {:.1f} times ours\n",
                              table.text(r, "program"), table.text(r, "version"), table.number(r, "cells"),
                              1e3 * table.number(r, "seconds_per_step"), table.number(r, "over_ours"));
  return text;
}

}  // namespace mss::studies::timing
