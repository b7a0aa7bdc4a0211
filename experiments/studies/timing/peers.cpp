// A step of other programs' soft bodies beside ours.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "integrators/fixed_step.hpp"
#include "reference/bullet_cube.hpp"

namespace mss::studies::timing {

namespace {

using Workload = TimingWorkload;

/// Something whose steps are timed.
struct Stepper {
  virtual ~Stepper() = default;
  /// Seconds for that many steps.
  virtual double take(long steps) = 0;
};

/// Our step in one precision with a number of threads.
template <class Real>
struct Ours final : Stepper {
  Ours(const Body& body, int threads)
      : system(body, {.gravity = Vec3(0, 0, Workload::gravity)}, {.threads = threads}),
        integrator(find_integrator("semi_implicit_euler").make<Real>({.dt = Workload::dt})),
        state(stretched_state(system, Workload::stretch)) {}
  double take(long steps) override {
    return seconds_of(
        [&] { integrator->advance(system, state, state.t + double(steps) * Workload::dt, work); });
  }
  SpringSystem<Real> system;
  std::unique_ptr<Integrator<Real>> integrator;
  State<Real> state;
  Work work;
};

struct Bullet final : Stepper {
  explicit Bullet(const Body& body) : cube(body, Vec3(0, 0, Workload::gravity)) {}
  double take(long steps) override {
    return seconds_of([&] {
      for (long i = 0; i < steps; ++i) cube.step(peer_step);
    });
  }
  reference::BulletCube cube;
};

/// What is measured of one size: the peer first, then ours.
struct TimedPeer {
  std::string precision;
  int threads;
  std::unique_ptr<Stepper> stepper;
  long steps;  ///< of a sample
};

std::vector<TimedPeer> subjects_of(const Body& body, std::unique_ptr<Stepper> peer,
                                   const PeerTimingConfig& config) {
  std::vector<TimedPeer> all;
  all.push_back({reference::BulletCube::precision(), 1, std::move(peer), 1});
  for (const int threads : config.threads) {
    all.push_back({"single", threads, std::make_unique<Ours<float>>(body, threads), steps_between_checks});
    all.push_back({"double", threads, std::make_unique<Ours<double>>(body, threads), steps_between_checks});
  }
  for (TimedPeer& s : all) {
    const auto seconds_for = [&](long count) { return s.stepper->take(count); };
    s.steps = std::max(s.steps, sample_length(config.sample_seconds, seconds_for).steps);
  }
  return all;
}

/// False if stopped.
bool add_rows(int n, const PeerTimingConfig& config, const Progress& progress, Table& table) {
  const Body body(timing_cube(n));
  auto peer = std::make_unique<Bullet>(body);
  const Bullet& bullet = *peer;
  const std::vector<TimedPeer> subjects = subjects_of(body, std::move(peer), config);
  const auto samples = measure_interleaved(config.repetitions, subjects.size(), progress, [&](std::size_t i) {
    return subjects[i].stepper->take(subjects[i].steps) / double(subjects[i].steps);
  });
  if (progress.stopped()) return false;
  const auto time = [&](std::size_t i) { return quartiles(samples[i]); };
  const bool finite = bullet.cube.position(0).allFinite();
  for (const char* precision : {"single", "double"}) {
    std::size_t best = 0, alone = 0;  // 0 is the peer
    for (std::size_t i = 1; i < subjects.size(); ++i) {
      if (subjects[i].precision != precision) continue;
      if (best == 0 || time(i).median < time(best).median) best = i;
      if (subjects[i].threads == 1) alone = i;
    }
    const Quartiles ratio = quartiles_of_ratio(samples[0], samples[best]),
                    on_one = quartiles_of_ratio(samples[0], samples[alone]);
    table.add({"Bullet", reference::BulletCube::version(), subjects[0].precision, n, time(0).median,
               time(0).q1, time(0).q3, std::string(precision), time(best).median, subjects[best].threads,
               ratio.median, ratio.q1, ratio.q3,
               std::string(to_string(finite ? Status::ok : Status::non_finite)), time(alone).median,
               on_one.median, on_one.q1, on_one.q3});
  }
  return true;
}

}  // namespace

Table measure_peers(const PeerTimingConfig& config, Progress& progress) {
  Table table({{"program"},
               {"version"},
               {"precision"},
               {"cells"},
               {"seconds_per_step", "s"},
               {"q1", "s"},
               {"q3", "s"},
               {"our_precision"},
               {"our_seconds_per_step", "s"},
               {"our_threads"},
               {"over_ours"},
               {"over_ours_q1"},
               {"over_ours_q3"},
               {"status"},
               {"our_seconds_on_one_thread", "s"},
               {"over_ours_on_one_thread"},
               {"over_ours_on_one_thread_q1"},
               {"over_ours_on_one_thread_q3"}});
  if (reference::BulletCube::version().empty()) {
    table.add({"Bullet", "", "", 0, no_value, no_value, no_value, "", no_value, 0, no_value, no_value,
               no_value, "not installed", no_value, no_value, no_value, no_value});
    return table;
  }
  for (const int n : config.cells) {
    progress.report(0.99, fmt::format("Bullet, {} cells per edge", n));
    if (!add_rows(n, config, progress, table)) break;
  }
  return table;
}

std::string peers_text(const Table& table) {
  std::string text;
  for (std::size_t r = 0; r < table.size(); ++r) {
    if (table.text(r, "status") == "not installed") {
      text += fmt::format("{}: not installed\n", table.text(r, "program"));
      continue;
    }
    const double spread =
        std::max(spread_of(table, r, "over_ours_q1", "over_ours_q3"),
                 spread_of(table, r, "over_ours_on_one_thread_q1", "over_ours_on_one_thread_q3"));
    text +=
        fmt::format("{} {} in {} precision on one thread, n = {}: a step takes ", table.text(r, "program"),
                    table.text(r, "version"), table.text(r, "precision"), table.number(r, "cells"));
    if (spread > widest_quartiles) {
      text += fmt::format("some multiple of ours in {}, withheld: {}\n", table.text(r, "our_precision"),
                          spread_text(spread));
      continue;
    }
    text += fmt::format("{:.3g} ms, {:.1f} times ours in {} on one thread",
                        1e3 * table.number(r, "seconds_per_step"), table.number(r, "over_ours_on_one_thread"),
                        table.text(r, "our_precision"));
    if (const double threads = table.number(r, "our_threads"); threads > 1)
      text += fmt::format(", {:.1f} times on {}", table.number(r, "over_ours"), threads);
    text += '\n';
  }
  return text;
}

}  // namespace mss::studies::timing
