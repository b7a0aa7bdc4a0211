#include "experiments/harness/experiment.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"

namespace mss {

const Table& find_table(const std::vector<NamedTable>& tables, std::string_view name) {
  for (const NamedTable& named : tables)
    if (named.name == name) return named.table;
  throw InputError(fmt::format("there is no table {}.csv, from which charts are drawn", name));
}

const Table* rows_of(const std::vector<NamedTable>& tables, std::string_view name) {
  for (const NamedTable& named : tables)
    if (named.name == name) return named.table.size() > 0 ? &named.table : nullptr;
  return nullptr;
}

std::string table_of(std::string_view chart, const std::vector<NamedTable>& tables) {
  std::string longest;
  for (const NamedTable& named : tables)
    if ((chart == named.name || chart.starts_with(named.name + "_")) && named.name.size() > longest.size())
      longest = named.name;
  return longest;
}

const ExperimentInfo& find_experiment(std::string_view name) {
  return find_named(experiments(), name, "experiment", "experiments");
}

std::vector<std::string> moving_integrators(const std::vector<std::string>& named) {
  for (const std::string& name : named) {
    if (std::count(named.begin(), named.end(), name) > 1)
      throw InputError(fmt::format("integrator '{}' is named twice in --integrators; name it once", name));
    if (find_integrator(name).stepping == Stepping::equilibrium)
      throw InputError(fmt::format(
          "integrator '{}' finds an equilibrium, no motion; `mss list integrators` shows the others", name));
    if (!find_integrator(name).moves_particles())
      throw InputError(fmt::format(
          "integrator '{}' is for reduced bodies; `mss list integrators` shows the others", name));
  }
  if (!named.empty()) return named;
  std::vector<std::string> all;
  for (const IntegratorInfo& info : integrators())
    if (info.moves_particles() && info.has_modulus) all.push_back(info.name);
  return all;
}

std::vector<std::string> moving_families(const std::vector<std::string>& named) {
  std::vector<std::string> all;
  for (const std::string& name : moving_integrators(named)) {
    all.push_back(name);
    if (named.empty())
      for (const std::string& ending : find_integrator(name).variants) all.push_back(name + ending);
  }
  return all;
}

namespace {

/// Throws InputError if one that is named cannot move bodies of a model; leaves it out if none is named.
std::vector<std::string> able(const std::vector<std::string>& names, bool named, const std::string& model) {
  std::vector<std::string> able;
  for (const std::string& name : names)
    if (model == spring_model || !find_integrator(name).needs_springs())
      able.push_back(name);
    else if (named)
      throw InputError(fmt::format("{} moves bodies of model \"{}\" only, and --model is \"{}\"", name,
                                   spring_model, model));
  return able;
}

}  // namespace

std::vector<std::string> moving_integrators(const std::vector<std::string>& named, const std::string& model) {
  return able(moving_integrators(named), !named.empty(), model);
}

std::vector<std::string> moving_families(const std::vector<std::string>& named, const std::string& model) {
  return able(moving_families(named), !named.empty(), model);
}

std::vector<std::string> without_variants(const std::vector<std::string>& names) {
  const auto has = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::vector<std::string> kept;
  for (const std::string& name : names) {
    const std::string method = name.substr(0, name.find_first_of(":/"));
    if (method == name ? !has(find_integrator(name).variant_of) : !has(method)) kept.push_back(name);
  }
  return kept;
}

std::vector<std::string> limited_integrators(const std::vector<std::string>& named) {
  std::vector<std::string> limited;
  for (const std::string& name : moving_integrators(named))
    if (find_integrator(name).limit)
      limited.push_back(name);
    else if (!named.empty())
      throw InputError(
          fmt::format("{} has no largest step: it is stable at every step, or chooses its own", name));
  return limited;
}

void check_scenes(const std::vector<std::string>& named, const std::vector<std::string>& known) {
  for (const std::string& name : named) {
    if (std::count(named.begin(), named.end(), name) > 1)
      throw InputError(fmt::format("scene '{}' is named twice in --scenes; name it once", name));
    if (std::count(known.begin(), known.end(), name) == 0)
      throw InputError(
          fmt::format("--scenes: there is no scene '{}'; {}--help lists them", name, question(name, known)));
  }
}

Journal open_journal(const ExperimentOptions& options, const Json& configuration) {
  if (options.journal.empty()) return {};
  Journal journal(options.journal, configuration, options.part);
  if (journal.size() > 0)
    fmt::print(stderr, "mss: continuing from {} results in {}\n", journal.size(), options.journal.string());
  return journal;
}

}  // namespace mss
