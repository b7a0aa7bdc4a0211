// Who is cheapest at every point of `mss regimes`, and where theory expects explicit steps to stop being it.
#include <algorithm>
#include <cmath>
#include <optional>

#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/regimes/regimes.hpp"

namespace mss::studies::regimes {

namespace {

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
    table.add({p.cells, p.damping_ratio, p.young, demand.name, std::string(), no_value, label_of(Kind::none),
               no_value, std::string(), std::string(), no_value, 0,
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
             next ? asked.number(*next, "seconds") / seconds : no_value,
             next && is_tie(asked, *winner, *next) ? 1 : 0,
             std::string(next ? "ok" : "no other kind met it in time")});
}

/// Rows of a resolution and damping.
Table rows_of(const Table& table, double cells, double ratio) {
  return table.where("cells", cells).where("damping_ratio", ratio);
}

/// Least seconds of a frame that stays stable by a method for any step; NaN if none is.
double cheapest_frame(const Table& runs, double young, int frames) {
  const Table motion = runs.where("young", young).where("what", "motion");
  const auto row = quickest(motion, 1, [](Kind kind) { return kind != Kind::explicit_steps; });
  return row ? motion.number(*row, "seconds") / frames : no_value;
}

/// Where the safe explicit steps of a frame take as long as the cheapest frame of a method for any step.
double predicted_modulus(const Table& points, const Table& runs, int frames) {
  std::vector<double> moduli = points.distinct_numbers("young"), log_moduli, log_ratios;
  std::sort(moduli.begin(), moduli.end());
  for (const double young : moduli) {
    const Table point = points.where("young", young);
    const double steps = frame / point.number(0, "safe_dt"), any = cheapest_frame(runs, young, frames);
    if (std::isnan(any)) continue;
    log_moduli.push_back(std::log(young));
    log_ratios.push_back(std::log(steps * point.number(0, "explicit_step_seconds") / any));
  }
  return crossing(log_moduli, log_ratios);
}

/// Between the first point, in ascending order, where explicit steps are not the cheapest and that before it.
double measured_modulus(const Table& cheapest) {
  const Table stable = cheapest.where("demand", "stable");
  std::vector<double> moduli = stable.distinct_numbers("young");
  std::sort(moduli.begin(), moduli.end());
  double last_explicit = no_value;
  for (const double young : moduli) {
    const std::string kind = stable.where("young", young).text(0, "kind");
    if (kind == label_of(Kind::none)) continue;
    if (kind != label_of(Kind::explicit_steps)) return std::sqrt(last_explicit * young);
    last_explicit = young;
  }
  return no_value;
}

}  // namespace

double crossing(const std::vector<double>& log_moduli, const std::vector<double>& log_ratios) {
  if (log_ratios.empty()) return no_value;
  if (log_ratios.front() >= 0) return std::exp(log_moduli.front() - 2 * log_ratios.front());
  for (std::size_t i = 1; i < log_ratios.size(); ++i)
    if (log_ratios[i] >= 0) {
      const double share = -log_ratios[i - 1] / (log_ratios[i] - log_ratios[i - 1]);
      return std::exp(log_moduli[i - 1] + share * (log_moduli[i] - log_moduli[i - 1]));
    }
  return std::exp(log_moduli.back() - 2 * log_ratios.back());
}

double worst_factor(const Table& boundaries) {
  double worst = no_value;
  for (std::size_t r = 0; r < boundaries.size(); ++r)
    if (const double factor = boundaries.number(r, "factor"); std::isfinite(factor))
      worst = std::fmax(worst, std::max(factor, 1 / factor));
  return worst;
}

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
  return {"explicit", "linear systems", "quasi-Newton", "quasi-Newton, order 2", "xpbd", "vbd", "none"};
}

const std::vector<Demand>& demands() {
  static const std::vector<Demand> all{{"stable", "stable", false, 1},
                                       {"motion_10", "motion 10 %", false, 0.1},
                                       {"motion_1", "motion 1 %", false, 0.01},
                                       {"motion_0.1", "motion 0.1 %", false, 0.001},
                                       {"rest_1", "rest 1 %", true, 0.01}};
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
  Table table(
      {{"cells"}, {"damping_ratio"}, {"predicted", "Pa"}, {"measured", "Pa"}, {"factor"}, {"status"}});
  for (const double cells : points.distinct_numbers("cells"))
    for (const double ratio : points.where("cells", cells).distinct_numbers("damping_ratio")) {
      const double predicted =
          predicted_modulus(rows_of(points, cells, ratio), rows_of(runs, cells, ratio), frames);
      const double measured = measured_modulus(rows_of(cheapest, cells, ratio));
      table.add({int(cells), ratio, predicted, measured, measured / predicted,
                 std::string(std::isnan(predicted)  ? "no method for any step stays stable"
                             : std::isnan(measured) ? "no change among the moduli tried"
                                                    : "ok")});
    }
  return table;
}

}  // namespace mss::studies::regimes
