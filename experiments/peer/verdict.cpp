#include "experiments/peer/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "experiments/simulation/expectation.hpp"

namespace mss::peer {

namespace {

/// What every result has to meet, limits or not.
constexpr const char *samples_check = "samples", *held_check = "held";

std::string percent_of(double share) { return fmt::format("{:.3g} %", 100 * share); }
std::string metres(double length) { return fmt::format("{:.3g} m", length); }
std::string milliseconds(double time) { return fmt::format("{:.3g} ms a frame", time); }

CheckState met_if(bool is_met) { return is_met ? CheckState::met : CheckState::missed; }

/// A limit, what it limits, and how both are written.
struct Limited {
  const char* name;
  std::optional<double> Limits::*limit;
  double (*value)(const Score&);
  bool (*applies)(const Scale&);
  const char* missing;  ///< why a scene may not have it
  std::string (*text)(double);
};

const std::vector<Limited>& limited() {
  constexpr auto always = [](const Scale&) { return true; };
  static const std::vector<Limited> all{
      {"error", &Limits::error, [](const Score& s) { return s.error; }, always, "", percent_of},
      {"volume", &Limits::volume, [](const Score& s) { return s.volume_drift; }, always, "", percent_of},
      {"momentum", &Limits::momentum, [](const Score& s) { return s.momentum_drift; },
       [](const Scale& s) { return s.has_momentum; }, "its body is held, or touches a plane at once",
       percent_of},
      {"spin", &Limits::spin, [](const Score& s) { return s.spin_drift; },
       [](const Scale& s) { return s.has_spin; }, "its body does not turn freely", percent_of},
      {"energy", &Limits::energy, [](const Score& s) { return std::max(s.energy_gain, s.energy_loss); },
       [](const Scale& s) { return s.has_energy; }, "its model has none", percent_of},
      {"penetration", &Limits::penetration, [](const Score& s) { return s.penetration; },
       [](const Scale& s) { return s.has_planes; }, "it has no planes", metres},
      {"cost", &Limits::cpu_ms, [](const Score& s) { return s.cpu_ms; }, always, "", milliseconds}};
  return all;
}

/// The last sample, with velocities in any case: by the parabola through the last three.
State<double> end_of(const Result& result) {
  State<double> end = result.samples.back();
  const std::size_t n = result.samples.size();
  if (result.has_velocities || n < 2) return end;
  const double h = end.t - result.samples[n - 2].t;
  end.v.array() = (end.x.array() - result.samples[n - 2].x.array()) / h;
  if (n > 2)
    end.v.array() +=
        (end.x.array() - 2 * result.samples[n - 2].x.array() + result.samples[n - 3].x.array()) / (2 * h);
  return end;
}

/// Deviations from one of the scene's expectations at a state.
std::vector<Deviation> deviations(const Exchange& exchange, const Expectation& expectation,
                                  const State<double>& end) {
  Scene scene = exchange.scene;
  scene.expectations = {expectation};
  return compare_with_expectations(scene, scene_end_of(scene, *exchange.system, end));
}

/// Empty, or why samples cannot be compared with an expectation.
std::string not_comparable(const Exchange& exchange, const Expectation& expectation) {
  const Scene& scene = exchange.scene;
  constexpr double rounding = 1e-6;
  if (!follows_from_state(scene, expectation.quantity)) return "samples do not show it";
  if (std::abs(exchange.times.back() - scene.solve.duration) > rounding * exchange.spacing)
    return fmt::format("the last sample is at {:.6g} s, the scene ends at {:.6g} s", exchange.times.back(),
                       scene.solve.duration);
  const std::vector<Deviation> wrong = deviations(exchange, expectation, exchange.reference.back());
  return wrong.empty() ? "" : "the reference misses it: " + to_string(wrong.front(), "should be");
}

void add_expectations(const Exchange& exchange, const Result& result, std::vector<Check>& checks) {
  for (const Expectation& e : exchange.scene.expectations) {
    const std::string name = "expect " + e.quantity;
    if (const std::string why = not_comparable(exchange, e); !why.empty()) {
      checks.push_back({name, CheckState::not_checked, fmt::format("{} ({})", e.quantity, why)});
      continue;
    }
    const std::vector<Deviation> wrong = deviations(exchange, e, end_of(result));
    checks.push_back(
        {name, met_if(wrong.empty()),
         wrong.empty() ? e.quantity + " as the scene expects" : to_string(wrong.front(), "should be")});
  }
}

Check check_of(const Limited& l, double value, double most) {
  if (l.limit == &Limits::cpu_ms && value == 0)
    return {l.name, CheckState::missed, fmt::format("gives no processor time, at most {}", l.text(most))};
  return {l.name, met_if(value <= most),
          fmt::format("{} {}, at most {}", l.name, l.text(value), l.text(most))};
}

}  // namespace

void check_limits(const Limits& limits, const Judge& judge) {
  for (const Limited& l : limited())
    if (limits.*l.limit && !l.applies(judge.scale()))
      throw InputError(fmt::format("--{} is for scenes that have it, and {} has not: {}; leave it out",
                                   l.name, judge.exchange().scene.name, l.missing));
}

std::vector<Check> checks_of(const Judge& judge, const Result& result, const Score& score,
                             const Limits& limits) {
  std::vector<Check> checks{{samples_check, met_if(score.stable), score.status}};
  if (!score.stable) return checks;
  constexpr double held_share = 1e-3;  // of a cell
  if (const double most = held_share * judge.exchange().scene.body.cell_size; judge.scale().has_holds)
    checks.push_back(
        {held_check, met_if(score.held_drift <= most),
         fmt::format("held particles move by {}, at most {}", metres(score.held_drift), metres(most))});
  for (const Limited& l : limited())
    if (const std::optional<double>& most = limits.*l.limit)
      checks.push_back(check_of(l, l.value(score), *most));
  add_expectations(judge.exchange(), result, checks);
  return checks;
}

bool is_missed(const std::vector<Check>& checks) {
  return std::any_of(checks.begin(), checks.end(),
                     [](const Check& check) { return check.state == CheckState::missed; });
}

std::string verdict_of(const std::vector<Check>& checks) {
  if (is_missed(checks)) return "missed";
  const bool compared = std::any_of(checks.begin(), checks.end(), [](const Check& check) {
    return check.state == CheckState::met && check.name != samples_check && check.name != held_check;
  });
  return compared ? "met" : "complete";
}

std::string in_words(const std::vector<Check>& checks, CheckState state) {
  std::string words;
  for (const Check& check : checks)
    if (check.state == state) words += (words.empty() ? "" : "; ") + check.words;
  return words;
}

}  // namespace mss::peer
