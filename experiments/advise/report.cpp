#include "experiments/advise/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/scene/scene_writer.hpp"
#include "experiments/advise/chart.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/harness/results_folder.hpp"
#include "experiments/harness/statistics.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/output.hpp"
#include "experiments/plot/gnuplot.hpp"

namespace mss::advise {

namespace {

namespace fs = std::filesystem;

/// 0: none.
double required_error(const AdviseRequest& request) { return request.of_stability ? 0 : request.error; }

const std::string& name_of(ErrorOf of) { return error_names()[std::size_t(of)]; }

Table trial_table(const SceneFamily& family, const Advice& advice) {
  Table table({{"cell_size", "m"},
               {"model"},
               {"face_share"},
               {"volume_force"},
               {"precision"},
               {"integrator"},
               {"linear_solver"},
               {"dt", "s"},
               {"tolerance"},
               {"threads"},
               {"error"},
               {"cost", "s/s"},
               {"share_run"},
               {"steps_per_frame"},
               {"min_jacobian"},
               {"max_stretch"},
               {"error_at_half_step"},
               {"contact"},
               {"cost_busiest", "s/s"},
               {"cost_q1", "s/s"},
               {"cost_q3", "s/s"},
               {"match"},
               {"status"}});
  for (const Trial& trial : advice.trials) {
    const Candidate& c = trial.candidate;
    const IntegratorInfo& method = find_integrator(c.integrator);
    const bool adaptive = method.stepping == Stepping::adaptive;
    table.add({family.cell_size(c.level),
               c.model,
               family.is_calibrated() ? c.face_share : no_value,
               std::int64_t(c.volume_force && family.has_volume_force()),
               to_string(c.precision),
               c.integrator,
               method.implicit && !adaptive ? c.linear_solver : "",
               c.dt && !adaptive ? *c.dt : no_value,
               adaptive ? c.tolerance : no_value,
               std::int64_t(c.threads),
               trial.error,
               trial.cost,
               trial.share,
               c.dt && !adaptive ? Cell(std::int64_t(steps_per_frame(*c.dt))) : Cell(no_value),
               trial.min_jacobian,
               trial.max_stretch,
               trial.error_at_half_step,
               family.contacts()[c.contact].name,
               trial.busiest,
               quartiles(trial.costs).q1,
               quartiles(trial.costs).q3,
               c.match ? to_string(*c.match) : "",
               to_string(trial)});
  }
  return table;
}

Table request_table(const SceneFamily& family, const AdviseRequest& request, const Advice& advice) {
  Table table({{"scene"}, {"of"}, {"error"}, {"budget", "s/s"}, {"best"}, {"within_budget"}});
  table.add({family.given().name, name_of(request.of), required_error(request), request.budget.value_or(0),
             std::int64_t(advice.best ? *advice.best + 1 : 0), std::int64_t(advice.within_budget)});
  return table;
}

Table element_table(const SceneFamily& family, const ElementCheck& check) {
  Table table({{"cell_size", "m"},
               {"error"},
               {"uncertainty"},
               {"cost_of_finer", "s/s"},
               {"cost_in_advised_cells", "s/s"},
               {"status"}});
  if (check.level > 0)
    table.add({family.cell_size(check.level), check.error, check.uncertainty, check.cost_of_finer, check.cost,
               std::string("ok")});
  else if (!check.problem.empty())
    table.add({no_value, no_value, no_value, no_value, no_value, check.problem});
  return table;
}

Json meta(const SceneFamily& family, const AdviseRequest& request, const Advice& advice,
          const std::vector<NamedTable>& tables, const Json& origin) {
  Json json{
      {"experiment", "advise"},
      {"scene", family.given().name},
      {"goal", request.of_stability ? "stability" : "error"},
      {"error", request.of_stability ? Json(nullptr) : Json(request.error)},
      {"of", name_of(request.of)},
      {"budget", request.budget ? Json(*request.budget) : Json(nullptr)},
      {"advised", nullptr},
      {"explanation", advice.explanation},
      {"reference",
       {{"cell_size", advice.finest_level > 0 ? Json(family.cell_size(advice.finest_level)) : Json(nullptr)},
        {"uncertainty", advice.finest_level > 0 ? Json(advice.uncertainty) : Json(nullptr)}}},
      {"seconds", advice.seconds}};
  if (advice.best) {
    const Trial& best = advice.trials[*advice.best];
    Json ties = Json::array();
    for (const std::size_t tie : advice.ties) ties.push_back(family.settings(advice.trials[tie].candidate));
    json["advised"] = {{"settings", family.settings(best.candidate)},
                       {"error", best.error},
                       {"error_against_a_finer_reference", advice.checked_error},
                       {"error_against_finite_elements", advice.elements.error},
                       {"min_jacobian", best.min_jacobian},
                       {"max_stretch", best.max_stretch},
                       {"cost", best.cost},
                       {"cost_quartiles", {quartiles(best.costs).q1, quartiles(best.costs).q3}},
                       {"ties", ties},
                       {"within_budget", advice.within_budget},
                       {"matched_cells", advice.about_matched},
                       {"reduced_bodies", advice.about_reduced}};
  }
  json["configuration"] = to_json(family.given());
  json["tables"] = describe_tables(tables);
  json["provenance"] = origin;
  return json;
}

/// An error that nothing may have been there to measure by.
std::string error_or_unknown(const Trial& trial) {
  const double error = judged_error(trial);
  return std::isfinite(error) ? fmt::format("{:.3g} %", 100 * error) : "not known";
}

/// The advised scene as a file of its own.
std::string advised_text(const SceneFamily& family, const AdviseRequest& request, const Trial& best,
                         const fs::path& directory) {
  const std::string asked =
      request.of_stability ? fmt::format("--of stability --budget {:.4g}ms/frame", *request.budget * to_frame)
                           : fmt::format("--error {:.4g}% --of {}", 100 * request.error, name_of(request.of));
  return fmt::format(
             "# {} as `mss advise {}` computes it: error of {} {}, {:.3g} ms for a frame of 1/60 s.\n",
             family.given().name, asked, name_of(request.of), error_or_unknown(best), best.cost * to_frame) +
         to_toml(family.scene(best.candidate), directory);
}

/// A candidate among ties.
std::string short_name(const SceneFamily& family, const Trial& trial) {
  const Candidate& c = trial.candidate;
  std::string name = fmt::format("{} in {} precision, cells of {:.4g} m", c.integrator,
                                 to_string(c.precision), family.cell_size(c.level));
  if (c.model != spring_model) name += " of " + c.model;
  if (c.match) name += fmt::format(", moduli matched (\"{}\")", to_string(*c.match));
  if (family.is_calibrated()) name += fmt::format(", face_share {:g}", c.face_share);
  if (family.has_volume_force() && !c.volume_force) name += " without volume force";
  if (c.dt) {
    const auto steps = steps_per_frame(*c.dt);
    name += fmt::format(", {} step{} a frame", steps, steps == 1 ? "" : "s");
  }
  if (c.threads != 1) name += ", on all threads";
  return name;
}

std::string error_in_words(const SceneFamily& family, const AdviseRequest& request, const Advice& advice) {
  if (advice.finest_level == 0)
    return fmt::format(
        "error of {}: not known, as a reference takes more than --patience; the size of cells ranked "
        "candidates\n",
        name_of(request.of));
  const Trial& best = advice.trials[*advice.best];
  std::string text = fmt::format("error of {}: {:.3g} %, ", name_of(request.of), 100 * best.error);
  text += request.of_stability ? "with no limit asked for"
                               : fmt::format("requested {:.3g} %", 100 * request.error);
  text += fmt::format(", uncertainty of the reference {} %",
                      advice.uncertainty < 0.995 ? fmt::format("{:.2g}", 100 * advice.uncertainty)
                                                 : fmt::format("{:.0f}", 100 * advice.uncertainty));
  if (std::isfinite(best.error_at_half_step))
    text += fmt::format("; at half the step {:.3g} %", 100 * best.error_at_half_step);
  if (std::isfinite(advice.checked_error))
    text += fmt::format("; against a finer reference {:.3g} %", 100 * advice.checked_error);
  if (advice.elements.level > 0)
    text += fmt::format(
        "\nagainst finite elements of {:.4g} m: {:.3g} %, in themselves uncertain by {:.2g} %; "
        "elements cost {:.3g} s for a simulated second, in cells of the advised size {:.3g} s",
        family.cell_size(advice.elements.level), 100 * advice.elements.error,
        100 * advice.elements.uncertainty, advice.elements.cost_of_finer, advice.elements.cost);
  if (!advice.elements.problem.empty())
    text += fmt::format("\nnot compared with finite elements: {}", advice.elements.problem);
  return text + "\n";
}

/// Why cells that are smaller than those of what is advised are not.
std::string smaller_in_words(const SceneFamily& family, const Advice& advice) {
  const double size = family.cell_size(advice.trials[*advice.best].candidate.level);
  const auto count = [&](Verdict verdict) {
    return std::count_if(advice.trials.begin(), advice.trials.end(), [&](const Trial& trial) {
      return trial.verdict == verdict && family.cell_size(trial.candidate.level) < size * (1 - 1e-9);
    });
  };
  const auto fold = count(Verdict::folds), longer = count(Verdict::over_budget);
  if (fold == 0) return "";
  return fmt::format(
      "in smaller cells {} candidate{} or nearly so, {} of the others take longer than the budget: "
      "advise.csv\n",
      fold, fold == 1 ? " folds" : "s fold", longer);
}

std::string cost_in_words(const SceneFamily& family, const AdviseRequest& request, const Advice& advice) {
  const Trial& best = advice.trials[*advice.best];
  const auto [median, q1, q3] = quartiles(best.costs);
  std::string text = fmt::format(
      "cost: {:.3g} ms for a frame of 1/60 s{}, {:.3g} s for a simulated second\n", best.cost * to_frame,
      best.costs.empty() ? std::string()
                         : fmt::format(" (quartiles {:.3g} to {:.3g})", q1 * to_frame, q3 * to_frame),
      best.cost);
  if (std::isfinite(best.busiest))
    text +=
        fmt::format("in the long run nine of ten frames take less than {:.3g} ms, of {:.3g} that they may\n",
                    best.busiest * to_frame, *request.budget * to_frame);
  constexpr std::size_t few = 4;
  for (std::size_t i = 0; i < std::min(few, advice.ties.size()); ++i) {
    const Trial& tie = advice.trials[advice.ties[i]];
    text += fmt::format(
        "as {}: {} ({:.3g} ms, error {})\n",
        request.of_stability ? "good, within the noise" : "cheap, within the noise, and less accurate",
        short_name(family, tie), tie.cost * to_frame, error_or_unknown(tie));
  }
  if (advice.ties.size() > few) text += fmt::format("and {} more\n", advice.ties.size() - few);
  return text;
}

}  // namespace

std::vector<NamedTable> advice_tables(const SceneFamily& family, const AdviseRequest& request,
                                      const Advice& advice) {
  return {{"advise", trial_table(family, advice)},
          {"advise_request", request_table(family, request, advice)},
          {"advise_elements", element_table(family, advice.elements)}};
}

void write_advice(const SceneFamily& family, const AdviseRequest& request, const Advice& advice,
                  const Json& origin, const fs::path& directory) {
  const std::vector<NamedTable> tables = advice_tables(family, request, advice);
  for (const NamedTable& table : tables)
    write_atomically(directory / (table.name + ".csv"), table.table.csv());
  write_atomically(directory / "meta.json", meta(family, request, advice, tables, origin).dump(2) + "\n");
  const fs::path advised = directory / (family.given().name + "_advised.toml");
  if (advice.best && advice.within_budget)
    write_atomically(advised, advised_text(family, request, advice.trials[*advice.best], directory));
  else
    fs::remove(advised);
  for (const char* picture : {"advise.svg", "advise.png"}) fs::remove(directory / picture);
  for (NamedChart& chart : draw(tables).charts) {
    if (!has_points(chart.chart)) continue;
    chart.chart.footer = provenance_line(origin);
    mss::draw(chart.chart, directory / chart.name);
  }
}

std::string summary(const SceneFamily& family, const AdviseRequest& request, const Advice& advice) {
  std::string text;
  if (advice.best) {
    const Trial& best = advice.trials[*advice.best];
    text += fmt::format("{}: {}\n", family.given().name,
                        advice.within_budget ? "advised" : "the cheapest that meets the error");
    const std::vector<std::string> settings = family.settings(best.candidate);
    for (const std::string& setting : settings) text += fmt::format("  {}\n", setting);
    const auto is_ratio = [](const std::string& s) { return s.find("damping.ratio=") != std::string::npos; };
    const double change = family.cell_size(best.candidate.level) / family.given().body.cell_size;
    if (std::abs(change - 1) > 1e-9 && std::any_of(settings.begin(), settings.end(), is_ratio))
      text += "damping.ratio: of cells of this size it is the same viscosity of the body\n";
    text += error_in_words(family, request, advice);
    if (!advice.errors_rank && advice.finest_level > 0)
      text += "that is too uncertain to tell candidates apart: the size of cells ranked them\n";
    if (request.of_stability)
      text += fmt::format("run for {:g} s without a warning: stable and unfolded\n",
                          std::max(clean_seconds, family.given().solve.duration));
    text += fmt::format("smallest min_jacobian {:.3g}, largest stretch {:.3g}{}\n", best.min_jacobian,
                        best.max_stretch,
                        advice.reference_folds ? "; the reference folds, so candidates may" : "");
    if (best.candidate.dt)
      text += fmt::format("steps: {} a frame of 1/60 s\n", steps_per_frame(*best.candidate.dt));
    text += cost_in_words(family, request, advice);
    if (request.of_stability) text += smaller_in_words(family, advice);
  }
  if (!advice.about_matched.empty()) text += fmt::format("matched cells: {}\n", advice.about_matched);
  if (!advice.about_reduced.empty()) text += fmt::format("reduced bodies: {}\n", advice.about_reduced);
  return text + fmt::format("{} candidate{} in {:.3g} s\n", advice.trials.size(),
                            advice.trials.size() == 1 ? "" : "s", advice.seconds);
}

}  // namespace mss::advise
