// Who is cheapest at every point of `mss regimes`, and where theory expects explicit steps to stop being it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/bench_scenes.hpp"
#include "experiments/studies/regimes/regimes.hpp"

namespace mss::studies::regimes {

namespace {

/// Differences of medians below this factor are noise.
constexpr double tie_factor = 1.1;

/// Whether a run meets a demand: within bounds, and with its error.
bool meets(const Table& runs, std::size_t r, const Demand& demand) {
  return runs.text(r, "status") == "ok" && runs.text(r, "bounds") == within_bounds &&
         (std::isinf(demand.error) || runs.number(r, "error") <= demand.error);
}

/// The row that meets a demand in the least time, among those that `allowed` accepts.
template <class Allowed>
std::optional<std::size_t> quickest(const Table& runs, const Demand& demand, Allowed&& allowed) {
  std::optional<std::size_t> best;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (!meets(runs, r, demand) || !allowed(r)) continue;
    if (!best || runs.number(r, "seconds") < runs.number(*best, "seconds")) best = r;
  }
  return best;
}

/// Why a demand has no answer.
std::string unanswered(const Table& asked, const Demand& demand) {
  if (asked.size() == 0) return "no reference";
  return certainty * asked.number(0, "uncertainty") > demand.error ? uncertain
                                                                   : "nothing that was tried met it";
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

std::vector<Cell> cells_of_point(const RegimePoint& p) {
  return {p.scene, p.cells, p.damping_ratio, p.young};
}

/// Method, setting, steps and kind of a run, and its time with quartiles; none: nothing.
std::vector<Cell> cells_of_run(const Table& runs, std::optional<std::size_t> r) {
  if (!r) return {std::string(), std::string(), no_value, label_of(Kind::none), no_value, no_value, no_value};
  return {runs.text(*r, "method"),
          runs.text(*r, "setting"),
          runs.number(*r, "steps_or_tolerance"),
          label_of(kind_of(runs.text(*r, "method"))),
          runs.number(*r, "seconds"),
          runs.number(*r, "q1"),
          runs.number(*r, "q3")};
}

void append(std::vector<Cell>& row, std::vector<Cell> more) {
  std::move(more.begin(), more.end(), std::back_inserter(row));
}

void add_row(const RegimePoint& p, const Demand& demand, const Table& runs, Table& table) {
  const Table asked = runs.where("what", demand.at_rest ? "rest" : "motion");
  std::optional<std::size_t> winner, next;
  const std::string unanswered_why = unanswered(asked, demand);
  if (unanswered_why == "nothing that was tried met it")
    winner = quickest(asked, demand, [](std::size_t) { return true; });
  if (winner) {
    const Kind kind = kind_of(asked.text(*winner, "method"));
    next = quickest(asked, demand, [&](std::size_t r) { return kind_of(asked.text(r, "method")) != kind; });
  }
  std::vector<Cell> row = cells_of_point(p);
  row.emplace_back(demand.name);
  append(row, cells_of_run(asked, winner));
  row.emplace_back(winner ? asked.number(*winner, "error") : no_value);
  append(row, cells_of_run(asked, next));
  row.emplace_back(next ? asked.number(*next, "seconds") / asked.number(*winner, "seconds") : no_value);
  row.emplace_back(next && is_tie(asked, *winner, *next) ? 1 : 0);
  row.emplace_back(!winner ? unanswered_why : std::string(next ? "ok" : "no other kind met it in time"));
  table.add(std::move(row));
}

/// Steps, setting and number of iterations of a run, in words.
std::string choice_of(const Table& runs, std::size_t r) {
  std::string text =
      fmt::format("{}, {:g} a frame", runs.text(r, "method"), runs.number(r, "steps_or_tolerance"));
  if (!runs.text(r, "setting").empty()) text += ", " + runs.text(r, "setting");
  return text;
}

void add_families(const RegimePoint& p, const Demand& demand, const Table& runs, Table& table) {
  const Table asked = runs.where("what", "motion");
  if (demand.at_rest || asked.size() == 0 || certainty * asked.number(0, "uncertainty") > demand.error)
    return;
  std::vector<std::string> families;
  for (std::size_t r = 0; r < asked.size(); ++r)
    if (const std::string family = family_of(asked.text(r, "method"));
        kind_of(family) != Kind::explicit_steps &&
        std::find(families.begin(), families.end(), family) == families.end())
      families.push_back(family);
  for (const std::string& family : families) {
    const auto is_of_it = [&](std::size_t r) { return family_of(asked.text(r, "method")) == family; };
    const auto tuned = quickest(asked, demand, is_of_it),
               untuned = quickest(asked, demand, [&](std::size_t r) {
                 return is_of_it(r) && asked.number(r, "untuned") == 1;
               });
    std::vector<Cell> row = cells_of_point(p);
    const auto seconds = [&](const auto& r) { return r ? asked.number(*r, "seconds") : no_value; };
    const auto error = [&](const auto& r) { return r ? asked.number(*r, "error") : no_value; };
    const auto choice = [&](const auto& r) { return r ? choice_of(asked, *r) : std::string(); };
    append(row, {demand.name, family, choice(tuned), seconds(tuned), error(tuned), choice(untuned),
                 seconds(untuned), error(untuned), seconds(untuned) / seconds(tuned),
                 std::string(untuned ? "ok"
                             : tuned ? "met by what is tuned alone"
                                     : "not met in time")});
    table.add(std::move(row));
  }
}

/// Calls use(point, its rows) for every point of a table.
template <class Use>
void for_each_point(const Table& runs, Use&& use) {
  for (const std::string& scene : runs.distinct("scene")) {
    const Table of_scene = runs.where("scene", scene);
    for (const double cells : of_scene.distinct_numbers("cells"))
      for (const double ratio : of_scene.where("cells", cells).distinct_numbers("damping_ratio")) {
        const Table row = of_scene.where("cells", cells).where("damping_ratio", ratio);
        for (const double young : row.distinct_numbers("young"))
          use(RegimePoint{scene, int(cells), ratio, young}, row.where("young", young));
      }
  }
}

/// Rows of a scene, resolution and damping.
Table rows_of(const Table& table, const std::string& scene, double cells, double ratio) {
  return table.where("scene", scene).where("cells", cells).where("damping_ratio", ratio);
}

/// Least seconds of a frame that stays stable by a method for any step; NaN if none is.
double cheapest_frame(const Table& runs, double young, double frames) {
  const Table motion = runs.where("young", young).where("what", "motion");
  const auto row = quickest(motion, demands().front(), [&](std::size_t r) {
    return kind_of(motion.text(r, "method")) != Kind::explicit_steps;
  });
  return row ? motion.number(*row, "seconds") / frames : no_value;
}

/// Where the safe explicit steps of a frame take as long as the cheapest frame of a method for any step.
double predicted_modulus(const Table& points, const Table& runs) {
  std::vector<double> moduli = points.distinct_numbers("young"), log_moduli, log_ratios;
  std::sort(moduli.begin(), moduli.end());
  for (const double young : moduli) {
    const Table point = points.where("young", young);
    const double steps = frame / point.number(0, "safe_dt"),
                 any = cheapest_frame(runs, young, point.number(0, "frames"));
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
  static const std::vector<Demand> all{{"stable", "stable", false, std::numeric_limits<double>::infinity()},
                                       {"motion_10", "motion 10 %", false, 0.1},
                                       {"motion_1", "motion 1 %", false, 0.01},
                                       {"motion_0.1", "motion 0.1 %", false, 0.001},
                                       {"rest_1", "rest 1 %", true, 0.01}};
  return all;
}

Table cheapest_methods(const Table& runs) {
  Table table({{"scene"},
               {"cells"},
               {"damping_ratio"},
               {"young", "Pa"},
               {"demand"},
               {"method"},
               {"setting"},
               {"steps_or_tolerance"},
               {"kind"},
               {"seconds", "s"},
               {"q1", "s"},
               {"q3", "s"},
               {"error"},
               {"runner_up"},
               {"runner_up_setting"},
               {"runner_up_steps_or_tolerance"},
               {"runner_up_kind"},
               {"runner_up_seconds", "s"},
               {"runner_up_q1", "s"},
               {"runner_up_q3", "s"},
               {"factor"},
               {"tie"},
               {"status"}});
  for_each_point(runs, [&](const RegimePoint& point, const Table& of_point) {
    for (const Demand& demand : demands())
      if (!demand.at_rest || find_bench_scene(point.scene).is_held()) add_row(point, demand, of_point, table);
  });
  return table;
}

Table tuned_families(const Table& runs) {
  Table table({{"scene"},
               {"cells"},
               {"damping_ratio"},
               {"young", "Pa"},
               {"demand"},
               {"family"},
               {"tuned"},
               {"seconds", "s"},
               {"error"},
               {"untuned"},
               {"untuned_seconds", "s"},
               {"untuned_error"},
               {"gain"},
               {"status"}});
  for_each_point(runs, [&](const RegimePoint& point, const Table& of_point) {
    for (const Demand& demand : demands()) add_families(point, demand, of_point, table);
  });
  return table;
}

Table boundaries(const Table& points, const Table& runs, const Table& cheapest) {
  Table table({{"scene"},
               {"cells"},
               {"damping_ratio"},
               {"predicted", "Pa"},
               {"measured", "Pa"},
               {"factor"},
               {"status"}});
  for (const std::string& scene : points.distinct("scene"))
    for (const double cells : points.where("scene", scene).distinct_numbers("cells"))
      for (const double ratio :
           points.where("scene", scene).where("cells", cells).distinct_numbers("damping_ratio")) {
        const double predicted =
            predicted_modulus(rows_of(points, scene, cells, ratio), rows_of(runs, scene, cells, ratio));
        const double measured = measured_modulus(rows_of(cheapest, scene, cells, ratio));
        table.add({scene, int(cells), ratio, predicted, measured, measured / predicted,
                   std::string(std::isnan(predicted)  ? "no method for any step stays stable"
                               : std::isnan(measured) ? "no change among the moduli tried"
                                                      : "ok")});
      }
  return table;
}

}  // namespace mss::studies::regimes
