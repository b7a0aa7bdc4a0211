// Who is cheapest at every point of `mss regimes`, and where theory expects explicit steps to stop being it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "experiments/harness/measure.hpp"
#include "experiments/studies/regimes/regimes.hpp"

namespace mss::studies::regimes {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Differences of medians below this factor are noise.
constexpr double tie_factor = 1.1;

/// The row that meets an error in the least time, among those of a kind that `allowed` accepts.
template <class Allowed>
std::optional<std::size_t> quickest(const Table& runs, double error, Allowed&& allowed) {
  std::optional<std::size_t> best;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (runs.text(r, "status") != "ok" || !(runs.number(r, "error") <= error)) continue;
    if (!allowed(kind_of(runs.text(r, "method")))) continue;
    if (!best || runs.number(r, "seconds") < runs.number(*best, "seconds")) best = r;
  }
  return best;
}

bool is_tie(const Table& runs, std::size_t winner, std::size_t next) {
  return runs.number(next, "q1") <= runs.number(winner, "q3") ||
         runs.number(next, "seconds") <= tie_factor * runs.number(winner, "seconds");
}

const std::vector<std::string>& labels() {
  static const std::vector<std::string> all = kind_labels();
  return all;
}
std::string label_of(Kind kind) { return labels()[std::size_t(kind)]; }

void add_row(const RegimePoint& p, const Demand& demand, const Table& runs, Table& table) {
  const Table asked = runs.where("what", demand.at_rest ? "rest" : "motion");
  const auto winner = quickest(asked, demand.error, [](Kind) { return true; });
  if (!winner) {
    table.add({p.cells, p.damping_ratio, p.young, demand.name, std::string(), none, label_of(Kind::none),
               none, std::string(), std::string(), none, 0,
               std::string(asked.size() == 0 ? "no reference" : "nothing that was tried met it")});
    return;
  }
  const Kind kind = kind_of(asked.text(*winner, "method"));
  const auto next = quickest(asked, demand.error, [&](Kind other) { return other != kind; });
  const double seconds = asked.number(*winner, "seconds");
  table.add({p.cells, p.damping_ratio, p.young, demand.name, asked.text(*winner, "method"),
             asked.number(*winner, "steps_or_tolerance"), label_of(kind), seconds,
             next ? asked.text(*next, "method") : std::string(),
             next ? label_of(kind_of(asked.text(*next, "method"))) : std::string(),
             next ? asked.number(*next, "seconds") / seconds : none,
             next && is_tie(asked, *winner, *next) ? 1 : 0,
             std::string(next ? "ok" : "no other kind met it")});
}

/// Rows of a resolution and damping.
Table rows_of(const Table& table, double cells, double ratio) {
  return table.where("cells", cells).where("damping_ratio", ratio);
}

/// Least seconds of a frame that stays stable by a method for any step: the median over moduli.
double cheapest_frame(const Table& runs, double frames) {
  std::vector<double> seconds;
  for (const double young : runs.distinct_numbers("young")) {
    const Table motion = runs.where("young", young).where("what", "motion");
    if (const auto row = quickest(motion, 1, [](Kind kind) { return kind != Kind::explicit_steps; }))
      seconds.push_back(motion.number(*row, "seconds") / frames);
  }
  return quartiles(seconds).median;
}

/// The safe step is inverse to the square root of the modulus.
double predicted_modulus(const Table& points, double frame_seconds) {
  std::vector<double> moduli;
  for (std::size_t r = 0; r < points.size(); ++r) {
    const double steps = frame_seconds / points.number(r, "explicit_step_seconds");
    moduli.push_back(points.number(r, "young") * std::pow(steps * points.number(r, "safe_dt") / frame, 2));
  }
  return quartiles(moduli).median;
}

/// Between the last point where explicit steps are the cheapest and the first where they are not.
double measured_modulus(const Table& cheapest) {
  double last_explicit = 0, first_other = infinity;
  for (std::size_t r = 0; r < cheapest.size(); ++r) {
    if (cheapest.text(r, "demand") != "stable") continue;
    const double young = cheapest.number(r, "young");
    const bool is_explicit = cheapest.text(r, "kind") == label_of(Kind::explicit_steps);
    if (is_explicit)
      last_explicit = std::max(last_explicit, young);
    else if (cheapest.text(r, "kind") != label_of(Kind::none))
      first_other = std::min(first_other, young);
  }
  return last_explicit > 0 && std::isfinite(first_other) ? std::sqrt(last_explicit * first_other) : none;
}

}  // namespace

Kind kind_of(const std::string& method) {
  const std::string family = family_of(method);
  if (family == "xpbd") return Kind::projections;
  if (family == "vbd") return Kind::descents;
  const IntegratorInfo& info = find_integrator(method);
  if (!info.implicit) return Kind::explicit_steps;
  if (info.nonlinear_solver.empty()) return Kind::linear_systems;
  return info.order_undamped > 1 ? Kind::second_order : Kind::quasi_newton;
}

std::vector<std::string> kind_labels() {
  return {"explicit",
          "implicit, linear systems",
          "quasi-Newton, order 1",
          "quasi-Newton, order 2",
          "xpbd",
          "vbd",
          "none meets it"};
}

const std::vector<Demand>& demands() {
  static const std::vector<Demand> all{{"stable", "stays stable", false, 1},
                                       {"motion_10", "motion to 10 %", false, 0.1},
                                       {"motion_1", "motion to 1 %", false, 0.01},
                                       {"motion_0.1", "motion to 0.1 %", false, 0.001},
                                       {"rest_1", "rest to 1 %", true, 0.01}};
  return all;
}

Table cheapest_methods(const Table& runs) {
  Table table({{"cells"},
               {"damping_ratio"},
               {"young", "Pa"},
               {"demand"},
               {"method"},
               {"steps_or_tolerance"},
               {"kind"},
               {"seconds", "s"},
               {"runner_up"},
               {"runner_up_kind"},
               {"factor"},
               {"tie"},
               {"status"}});
  for (const double cells : runs.distinct_numbers("cells"))
    for (const double ratio : runs.where("cells", cells).distinct_numbers("damping_ratio")) {
      const Table row = rows_of(runs, cells, ratio);
      for (const double young : row.distinct_numbers("young"))
        for (const Demand& demand : demands())
          add_row({int(cells), ratio, young}, demand, row.where("young", young), table);
    }
  return table;
}

Table boundaries(const Table& points, const Table& runs, const Table& cheapest, int frames) {
  Table table({{"cells"},
               {"damping_ratio"},
               {"frame_seconds", "s"},
               {"predicted", "Pa"},
               {"measured", "Pa"},
               {"factor"},
               {"status"}});
  for (const double cells : points.distinct_numbers("cells"))
    for (const double ratio : points.where("cells", cells).distinct_numbers("damping_ratio")) {
      const double seconds = cheapest_frame(rows_of(runs, cells, ratio), frames);
      const double predicted = predicted_modulus(rows_of(points, cells, ratio), seconds);
      const double measured = measured_modulus(rows_of(cheapest, cells, ratio));
      table.add({int(cells), ratio, seconds, predicted, measured, measured / predicted,
                 std::string(std::isnan(predicted)  ? "no method for any step stays stable"
                             : std::isnan(measured) ? "no change among the moduli tried"
                                                    : "ok")});
    }
  return table;
}

}  // namespace mss::studies::regimes
