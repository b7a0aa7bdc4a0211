#include "experiments/peer/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/error.hpp"
#include "experiments/harness/drawings.hpp"
#include "experiments/harness/page.hpp"
#include "experiments/harness/results_folder.hpp"
#include "experiments/io/output.hpp"

namespace mss::peer {

namespace {

namespace fs = std::filesystem;

constexpr const char* no_limit = "complete; no limit was given";

/// A number of a score, and of which scenes it is.
struct ScoreColumn {
  const char* name;
  const char* unit;
  double (*value)(const Score&);
  bool (*applies)(const Scale&);
};

const std::vector<ScoreColumn>& score_columns() {
  constexpr auto always = [](const Scale&) { return true; };
  static const std::vector<ScoreColumn> columns{
      {"error", "", [](const Score& s) { return s.error; }, always},
      {"worst_error", "", [](const Score& s) { return s.worst_error; }, always},
      {"volume_low", "", [](const Score& s) { return s.volume_low; }, always},
      {"volume_high", "", [](const Score& s) { return s.volume_high; }, always},
      {"volume_drift", "", [](const Score& s) { return s.volume_drift; }, always},
      {"min_jacobian", "", [](const Score& s) { return s.min_jacobian; }, always},
      {"momentum_drift", "", [](const Score& s) { return s.momentum_drift; },
       [](const Scale& s) { return s.has_momentum; }},
      {"spin_drift", "", [](const Score& s) { return s.spin_drift; },
       [](const Scale& s) { return s.has_spin; }},
      {"penetration", "m", [](const Score& s) { return s.penetration; },
       [](const Scale& s) { return s.has_planes; }},
      {"held_drift", "m", [](const Score& s) { return s.held_drift; },
       [](const Scale& s) { return s.has_holds; }},
      {"energy_gain", "", [](const Score& s) { return s.energy_gain; },
       [](const Scale& s) { return s.has_energy; }},
      {"energy_loss", "", [](const Score& s) { return s.energy_loss; },
       [](const Scale& s) { return s.has_energy; }},
      {"cpu_ms_per_frame", "ms", [](const Score& s) { return s.cpu_ms; }, always},
      {"wall_ms_per_frame", "ms", [](const Score& s) { return s.wall_ms; }, always}};
  return columns;
}

std::vector<ScoreColumn> columns_of(const Scale& scale) {
  std::vector<ScoreColumn> columns;
  for (const ScoreColumn& column : score_columns())
    if (column.applies(scale)) columns.push_back(column);
  return columns;
}

Table table_of_scores(const Judge& judge, const std::vector<Judged>& results) {
  const std::vector<ScoreColumn> measured = columns_of(judge.scale());
  std::vector<Column> columns{{"scene"},     {"result"},     {"engine"},  {"version"},  {"setting"},
                              {"step", "s"}, {"iterations"}, {"threads"}, {"precision"}};
  for (const ScoreColumn& column : measured) columns.push_back({column.name, column.unit});
  for (const char* name : {"velocities", "verdict", "missed", "not_checked", "status"})
    columns.push_back({name});
  Table table(std::move(columns));
  for (const auto& [result, score, checks] : results) {
    std::vector<Cell> row{judge.exchange().scene.name,
                          result.name,
                          result.engine,
                          result.version,
                          setting_of(result, results),
                          result.step,
                          std::int64_t(result.iterations.value_or(0)),
                          std::int64_t(result.threads),
                          result.precision};
    for (const ScoreColumn& column : measured) row.emplace_back(column.value(score));
    row.emplace_back(std::string(result.has_velocities ? "given" : "differences"));
    row.emplace_back(verdict_of(checks));
    row.emplace_back(in_words(checks, CheckState::missed));
    row.emplace_back(in_words(checks, CheckState::not_checked));
    row.emplace_back(score.status);
    table.add(std::move(row));
  }
  return table;
}

/// The same for results that differ in their step alone.
auto sweep_key(const Result& r, const std::vector<Judged>& all) {
  return std::tuple(r.engine, r.version, setting_of(r, all), r.iterations.value_or(0), r.precision);
}

std::size_t count_steps(const std::vector<const Judged*>& sweep) {
  std::set<double> steps;
  for (const Judged* row : sweep) steps.insert(row->result.step);
  return steps.size();
}

/// The largest step below which none failed, and the smallest that did; NaN where there is none.
std::pair<double, double> stable_steps(const std::vector<const Judged*>& sweep) {
  double unstable = std::numeric_limits<double>::infinity(), stable = no_value;
  for (const Judged* row : sweep)
    if (row->score.unstable) unstable = std::min(unstable, row->result.step);
  for (const Judged* row : sweep)
    if (row->score.stable && row->result.step < unstable && !(row->result.step < stable))
      stable = row->result.step;
  return {stable, std::isinf(unstable) ? no_value : unstable};
}

/// Results whose samples are at fault say nothing about stability.
Table table_of_stability(const std::vector<Judged>& results) {
  Table table({{"engine"},
               {"version"},
               {"setting"},
               {"iterations"},
               {"precision"},
               {"steps"},
               {"largest_stable_step", "s"},
               {"smallest_unstable_step", "s"},
               {"status"}});
  using Key = decltype(sweep_key(Result(), results));
  std::map<Key, std::vector<const Judged*>> sweeps;
  for (const Judged& judged : results)
    if (judged.score.stable || judged.score.unstable)
      sweeps[sweep_key(judged.result, results)].push_back(&judged);
  for (const auto& [key, sweep] : sweeps) {
    const std::size_t steps = count_steps(sweep);
    if (steps < 2) continue;
    const auto& [engine, version, setting, iterations, precision] = key;
    const auto [stable, unstable] = stable_steps(sweep);
    table.add({engine, version, setting, std::int64_t(iterations), precision, std::int64_t(steps), stable,
               unstable,
               std::string(std::isnan(stable)     ? "none is stable"
                           : std::isnan(unstable) ? "all are stable"
                                                  : "ok")});
  }
  return table;
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(); }

template <class Number>
Json value_or_null(const std::optional<Number>& value) {
  return value ? Json(*value) : Json();
}

Json limits_to_json(const Limits& limits) {
  return {{"error", value_or_null(limits.error)},
          {"volume", value_or_null(limits.volume)},
          {"momentum", value_or_null(limits.momentum)},
          {"spin", value_or_null(limits.spin)},
          {"energy", value_or_null(limits.energy)},
          {"penetration", value_or_null(limits.penetration)},
          {"cpu_ms_per_frame", value_or_null(limits.cpu_ms)}};
}

Json met_or_null(const Check& check) {
  return check.state == CheckState::not_checked ? Json() : Json(check.state == CheckState::met);
}

Json result_to_json(const Judge& judge, const Judged& judged) {
  const auto& [result, score, checks] = judged;
  Json json{{"result", result.name},
            {"engine", result.engine},
            {"version", result.version},
            {"step", result.step},
            {"iterations", value_or_null(result.iterations)},
            {"precision", result.precision},
            {"threads", result.threads},
            {"settings", result.settings},
            {"status", score.status},
            {"stable", score.stable},
            {"velocities", result.has_velocities ? "given" : "differences"},
            {"verdict", verdict_of(checks)}};
  for (const ScoreColumn& column : columns_of(judge.scale()))
    json["scores"][column.name] = number_or_null(column.value(score));
  for (const Check& check : checks)
    json["checks"].push_back({{"name", check.name}, {"met", met_or_null(check)}, {"words", check.words}});
  return json;
}

/// Of all results together.
std::string verdict(const std::vector<Judged>& results) {
  std::vector<Check> checks;
  for (const Judged& judged : results)
    checks.insert(checks.end(), judged.checks.begin(), judged.checks.end());
  return verdict_of(checks);
}

std::string verdict_in_words(const std::vector<Check>& checks) {
  const std::string verdict = verdict_of(checks);
  if (verdict == "missed") return "missed: " + in_words(checks, CheckState::missed);
  return verdict == "met" ? verdict : no_limit;
}

/// As text of XML, whose special characters are those of HTML.
std::string escaped(const std::string& text) { return html_text(printable(text)); }

/// A line for each engine of which several steps were tried.
std::string stability_in_words(const Table& stability) {
  std::string text;
  for (std::size_t row = 0; row < stability.size(); ++row) {
    const double stable = stability.number(row, "largest_stable_step"),
                 unstable = stability.number(row, "smallest_unstable_step");
    text += fmt::format("  {}, {:g} steps tried: ", stability.text(row, "engine"),
                        stability.number(row, "steps"));
    text += std::isfinite(stable) ? fmt::format("stable up to {:.4g} s", stable) : "none is stable";
    text += std::isfinite(unstable) ? fmt::format(", not at {:.4g} s\n", unstable) : "\n";
  }
  return text;
}

/// The numbers of a score, in a line.
std::string measures_in_words(const Score& score, const Scale& scale) {
  std::string text;
  for (const ScoreColumn& column : columns_of(scale))
    text += fmt::format("{}{} {:.3g}{}{}", text.empty() ? "" : ", ", column.name, column.value(score),
                        *column.unit ? " " : "", column.unit);
  return text + (score.cpu_ms == 0 ? "; gives no processor time" : "");
}

std::string energy_in_words(const Scale& scale) {
  if (!scale.has_energy) return "the model has none";
  return scale.takes_energy.empty() ? "conserved" : "not conserved: " + scale.takes_energy;
}

/// A line of a chart: an engine with its setting.
std::string line_of(const Table& scores, std::size_t row) {
  const std::string& setting = scores.text(row, "setting");
  return scores.text(row, "engine") + (setting.empty() ? "" : ", " + setting);
}

std::vector<ChartSeries> lines_of(const Table& scores) {
  std::vector<std::string> names;
  for (std::size_t row = 0; row < scores.size(); ++row)
    if (const std::string name = line_of(scores, row);
        std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  std::vector<ChartSeries> all;
  for (const std::string& name : names) {
    ChartSeries series{.label = name};
    for (std::size_t row = 0; row < scores.size(); ++row)
      if (const double cost = scores.number(row, "cpu_ms_per_frame"), error = scores.number(row, "error");
          line_of(scores, row) == name && cost > 0 && error > 0)
        series.points.push_back({cost, error});
    std::sort(series.points.begin(), series.points.end(),
              [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
    if (!series.points.empty()) all.push_back(std::move(series));
  }
  return all;
}

}  // namespace

Judged judged(const Judge& judge, Result result, const Limits& limits) {
  const Score score = judge.score(result);
  std::vector<Check> checks = checks_of(judge, result, score, limits);
  result.samples.clear();
  result.samples.shrink_to_fit();
  return {std::move(result), score, std::move(checks)};
}

std::string setting_of(const Result& result, const std::vector<Judged>& all) {
  if (!result.settings.is_object()) return "";
  std::string text;
  for (const auto& [key, value] : result.settings.items()) {
    const bool differs = std::any_of(all.begin(), all.end(), [&, k = key, v = value](const Judged& other) {
      return other.result.engine == result.engine &&
             (!other.result.settings.is_object() || other.result.settings.value(k, Json()) != v);
    });
    if (key == "iterations" || !differs) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", key,
                        printable(value.is_string() ? value.get<std::string>() : value.dump()));
  }
  return text;
}

std::vector<NamedTable> score_tables(const Judge& judge, const std::vector<Judged>& results) {
  std::vector<NamedTable> tables{{"scores", table_of_scores(judge, results)}};
  if (Table stability = table_of_stability(results); stability.size() > 0)
    tables.push_back({"stability", std::move(stability)});
  return tables;
}

Drawings draw(const std::vector<NamedTable>& tables) {
  const Table& scores = find_table(tables, "scores");
  if (scores.size() == 0) return {};
  Chart chart{.title = "Error against cost: " + scores.text(0, "scene"),
              .subtitle =
                  "rms distance from the reference over its largest displacement; times as programs "
                  "give them",
              .x = {.label = "processor time of a frame of 1/60 s [ms]", .logarithmic = true},
              .y = {.label = "error", .logarithmic = true},
              .series = lines_of(scores)};
  std::size_t drawn = 0;
  for (const ChartSeries& series : chart.series) drawn += series.points.size();
  if (drawn < scores.size()) chart.subtitle += fmt::format("; {} not drawn", scores.size() - drawn);
  return {.charts = {{"scores", std::move(chart)}}};
}

Json to_json(const Judge& judge, const std::vector<Judged>& results, const Limits& limits,
             const Json& origin) {
  const Exchange& exchange = judge.exchange();
  Json json{{"format", "mss-peer-score-1"},
            {"scene", exchange.scene.name},
            {"verdict", verdict(results)},
            {"limits", limits_to_json(limits)},
            {"reference",
             {{"integrator", exchange.facts.integrator},
              {"dt", exchange.facts.dt},
              {"uncertainty", exchange.facts.uncertainty},
              {"energy", energy_in_words(judge.scale())},
              {"free_samples", judge.scale().free_samples},
              {"provenance", exchange.provenance}}},
            {"results", Json::array()},
            {"provenance", origin}};
  for (const Judged& judged : results) json["results"].push_back(result_to_json(judge, judged));
  return json;
}

std::string to_junit(const Judge& judge, const std::vector<Judged>& results) {
  std::size_t tests = 0, failures = 0, skipped = 0;
  std::string cases;
  for (const auto& [result, score, checks] : results)
    for (const Check& check : checks) {
      ++tests;
      cases += fmt::format("    <testcase classname=\"{}\" name=\"{}\"", escaped(result.name), check.name);
      if (check.state == CheckState::met) {
        cases += "/>\n";
        continue;
      }
      const bool failed = check.state == CheckState::missed;
      ++(failed ? failures : skipped);
      cases += fmt::format(">\n      <{} message=\"{}\"/>\n    </testcase>\n", failed ? "failure" : "skipped",
                           escaped(check.words));
    }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"mss peer score {}\" "
      "tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n{}  </testsuite>\n</testsuites>\n",
      escaped(judge.exchange().scene.name), tests, failures, skipped, cases);
}

std::string write_scores(const Judge& judge, const std::vector<Judged>& results, const Limits& limits,
                         const Json& origin, const fs::path& directory) {
  const std::vector<NamedTable> tables = score_tables(judge, results);
  for (const NamedTable& named : tables)
    write_atomically(directory / (named.name + ".csv"), named.table.csv());
  if (tables.size() == 1) fs::remove(directory / "stability.csv");  // of an earlier run
  Json meta{{"experiment", "peer_score"}};
  meta.update(to_json(judge, results, limits, origin));
  meta.erase("results");  // scores.csv has them
  meta["tables"] = describe_tables(tables);
  write_atomically(directory / "meta.json", meta.dump(2) + "\n");
  try {
    write_drawings(draw(tables), tables, origin, directory);
  } catch (const InputError& problem) {
    return problem.what();
  }
  return "";
}

std::string summary(const Judge& judge, const std::vector<Judged>& results) {
  const ReferenceFacts& facts = judge.exchange().facts;
  std::string text =
      fmt::format("{}: reference by {}, dt = {:.3g} s, {:.2g} from one of twice the step; energy {}\n",
                  judge.exchange().scene.name, facts.integrator, facts.dt, facts.uncertainty,
                  energy_in_words(judge.scale()));
  for (const auto& [result, score, checks] : results) {
    text += "  " + printable(result.name);
    if (score.status != "ok") {
      text += ": missed: " + score.status + "\n";
      continue;
    }
    text += fmt::format(": {}\n    {}\n", measures_in_words(score, judge.scale()), verdict_in_words(checks));
    if (const std::string open = in_words(checks, CheckState::not_checked); !open.empty())
      text += "    not checked: " + open + "\n";
  }
  text += stability_in_words(table_of_stability(results));
  const auto failed =
      std::count_if(results.begin(), results.end(), [](const Judged& j) { return is_missed(j.checks); });
  const std::string words = verdict(results) == "met" ? "all met" : no_limit;
  return text + fmt::format("{} result{}: {}\n", results.size(), results.size() == 1 ? "" : "s",
                            failed == 0 ? words : fmt::format("{} missed", failed));
}

}  // namespace mss::peer
