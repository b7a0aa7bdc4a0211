// Bodies that touch each other or themselves, as parts of the study.
#include "experiments/studies/contact/robustness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "experiments/harness/case_rows.hpp"

namespace mss::studies::contact {

namespace {

constexpr const char *pile_file = "contact_pile", *incline_file = "contact_incline",
                     *capstan_file = "contact_capstan", *self_file = "contact_self",
                     *drop_file = "contact_drop", *random_file = "contact_random";

/// The table of a result's rows, which stand under the name of their file.
Json rows_in(const char* file, const Table& rows) { return {{file, rows_of(rows)}}; }

template <class Run, class Add>
void add_cases(const std::vector<Run>& runs, const char* file, Table (*empty)(), Add add,
               std::vector<Case>& cases) {
  for (const Run& run : runs)
    cases.push_back({run.name(), [=] {
                       Table rows = empty();
                       add(run, rows);
                       return rows_in(file, rows);
                     }});
}

std::vector<std::pair<const char*, Table*>> named_tables(RobustnessTables& tables) {
  return {{pile_file, &tables.pile}, {incline_file, &tables.incline}, {capstan_file, &tables.capstan},
          {self_file, &tables.self}, {drop_file, &tables.drop},       {random_file, &tables.random}};
}

std::string counted(const char* what, const Table& rows) {
  std::string line = fmt::format("{:<21} of {:3} runs", what, rows.size());
  for (const std::string& status : rows.distinct("status"))
    line += fmt::format(", {} {}", rows.where("status", status).size(), status);
  return line + "\n";
}

template <class Run>
Json names_of(const std::vector<Run>& runs) {
  Json names = Json::array();
  for (const Run& run : runs) names.push_back(run.name());
  return names;
}

}  // namespace

RobustnessConfig robustness_config(const ExperimentOptions& options) {
  constexpr int all = 300, few = 10;
  return {.piles = pile_config(options),
          .ropes = capstan_config(options),
          .self = self_contact_config(options),
          .drops = drop_config(options),
          .random = {.count = options.quick ? few : all}};
}

Json configuration(const RobustnessConfig& c) {
  return {{"piles", names_of(c.piles.piles)},       {"ropes", names_of(c.ropes)},
          {"inclines", names_of(c.piles.inclines)}, {"self_contact", names_of(c.self.runs)},
          {"drops", names_of(c.drops.runs)},        {"random_first_seed", c.random.first_seed},
          {"random_scenes", c.random.count}};
}

/// Random scenes several at a time: most take a moment.
std::vector<Case> robustness_cases(const RobustnessConfig& config) {
  std::vector<Case> cases;
  add_cases(config.piles.piles, pile_file, empty_pile, add_pile_run, cases);
  add_cases(config.piles.inclines, incline_file, empty_incline, add_incline_run, cases);
  add_cases(config.ropes, capstan_file, empty_capstan, add_capstan_run, cases);
  add_cases(config.self.runs, self_file, empty_self_contact, add_self_contact_run, cases);
  add_cases(config.drops.runs, drop_file, empty_drop, add_drop_run, cases);
  constexpr int at_once = 10;
  for (int i = 0; i < config.random.count; i += at_once) {
    const std::uint64_t first = config.random.first_seed + std::uint64_t(i),
                        end = first + std::uint64_t(std::min(at_once, config.random.count - i));
    cases.push_back({fmt::format("random scenes from {}", first), [=] {
                       Table rows = empty_random();
                       for (std::uint64_t seed = first; seed < end; ++seed) add_random_scene(seed, rows);
                       return rows_in(random_file, rows);
                     }});
  }
  return cases;
}

bool add_robustness_result(const Json& result, RobustnessTables& tables) {
  for (const auto& [file, table] : named_tables(tables)) {
    if (!result.contains(file)) continue;
    add_rows(result[file], *table);
    return true;
  }
  return false;
}

std::vector<NamedTable> robustness_files(RobustnessTables tables) {
  std::vector<NamedTable> files;
  for (const auto& [file, table] : named_tables(tables)) files.push_back({file, std::move(*table)});
  return files;
}

void add_robustness_charts(const std::vector<NamedTable>& tables, Drawings& drawings) {
  const auto add = [&](const char* name, const Chart& chart) {
    if (has_points(chart)) drawings.charts.push_back({name, chart});
  };
  if (const Table* piles = rows_of(tables, pile_file)) add("contact_pile", pile_depth_chart(*piles));
  if (const Table* drops = rows_of(tables, drop_file)) add("contact_drop", drop_chart(*drops));
}

std::string robustness_summary(const RobustnessTables& tables) {
  return counted("piles", tables.pile) + counted("blocks on slopes", tables.incline) +
         counted("ropes on a cylinder", tables.capstan) + counted("self-contact", tables.self) +
         counted("drops", tables.drop) + counted("random scenes", tables.random) +
         random_summary(tables.random);
}

}  // namespace mss::studies::contact
