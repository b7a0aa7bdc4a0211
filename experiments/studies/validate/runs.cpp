// The runs of `mss validate`: every model of every case at every size, and the thesis's cube refined.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/spring_system.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/statistics.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/validate/validate.hpp"

namespace mss::studies::validate {

namespace {

using Clock = std::chrono::steady_clock;
constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double slow = 2;  ///< where an answer takes longer, none is repeated [s]

/// What came of one model of a case.
struct Result {
  Answer answer{};
  std::int64_t unknowns = 0;
  std::vector<double> seconds{};
};

/// Builds a body and asks it, all of it timed: that is what an answer costs.
void ask(const ValidationConfig& config, const ValidationCase& c, const ValidationModel& model, int m,
         Result& result) {
  if (result.answer.status != Status::ok) return;
  const auto begin = Clock::now();
  const double h = 1.0 / m;
  const ElasticConstants material{config.young, c.poisson};
  const Body body({.voxels = VoxelGrid::box(m * c.proportions[0], m * c.proportions[1], m * c.proportions[2]),
                   .cell_size = h,
                   .density = config.density,
                   .springs = model.springs(material, h),
                   .elastic = material});
  const auto system = make_system<double>(model.model, body, c.environment, config.threads);
  result.answer = c.answer(*system);
  result.seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
  result.unknowns = std::int64_t(system->unknowns().size());
}

/// All models of a case in turn, again and again; false if stopped.
bool measure_case(const ValidationConfig& config, const ValidationCase& c, int m, Table& rows,
                  const Progress& progress) {
  std::vector<const ValidationModel*> models;
  for (const ValidationModel& model : config.models)
    if (c.large || !model.for_large_only) models.push_back(&model);
  std::vector<Result> results(models.size());
  const auto ask_all = [&](int times) {
    return interleave(times, results.size(), progress,
                      [&](std::size_t i) { ask(config, c, *models[i], m, results[i]); });
  };
  if (!ask_all(1)) return false;
  const bool quick =
      std::all_of(results.begin(), results.end(), [](const Result& r) { return r.seconds.front() < slow; });
  if (quick && config.repetitions > 1 && !ask_all(config.repetitions - 1)) return false;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Result& r = results[i];
    const bool found = std::isfinite(r.answer.value), ok = found && r.answer.status == Status::ok;
    const std::string status(r.answer.status == Status::ok && !found ? "not found"
                                                                     : to_string(r.answer.status));
    rows.add({c.name, models[i]->name, m, r.unknowns, c.quantity + " [" + c.unit + "]",
              ok ? r.answer.value : none, c.reference, ok ? std::abs(r.answer.value / c.reference - 1) : none,
              c.doubt, quantile(r.seconds, 0.5), quantile(r.seconds, 0.25), quantile(r.seconds, 0.75),
              std::int64_t(r.seconds.size()), status});
  }
  return true;
}

Table empty_rows() {
  return Table({{"case"},
                {"model"},
                {"cells"},
                {"unknowns"},
                {"quantity"},
                {"value"},
                {"reference"},
                {"error"},
                {"doubt"},
                {"seconds", "s"},
                {"q1", "s"},
                {"q3", "s"},
                {"repeats"},
                {"status"}});
}

/// The thesis's springs on a cube of 1 m at n cells per edge: as printed, or for the material they make at n
/// = 5 (stiffness goes as 1 / n).
SpringConstants refined_springs(bool fixed_material, int n) {
  const double scale = fixed_material ? 5.0 / n : 1;
  return {.edge = 100 * scale, .face = 100 * scale, .body = 300 * scale, .volume = 0.1};
}

/// Young's modulus along an edge, by a pull.
void add_refinement(const ValidationConfig& config, const ValidationCase& pull, int n, Table& table) {
  for (const bool fixed_material : {false, true})
    for (const Sharing sharing : {Sharing::weighted, Sharing::uniform}) {
      const Body body({.voxels = VoxelGrid::box(n, n, n),
                       .cell_size = 1.0 / n,
                       .sharing = sharing,
                       .density = config.density,
                       .springs = refined_springs(fixed_material, n)});
      SpringSystem<double> system(body, pull.environment, {.threads = 1});
      const Answer answer = pull.answer(system);
      const bool ok = answer.status == Status::ok;
      table.add({std::string(fixed_material ? "material" : "k"),
                 std::string(sharing == Sharing::weighted ? "weighted" : "uniform"), n,
                 ok ? 1 / answer.value : none, std::string(to_string(answer.status))});
    }
}

}  // namespace

ValidationTables measure_validation(const ValidationConfig& config, Progress& progress) {
  ValidationTables tables{
      .rows = empty_rows(),
      .refinement = Table({{"held"}, {"sharing"}, {"cells"}, {"young", "Pa"}, {"status"}})};
  const auto total = double(config.cases.size() * config.cells.size() + 1);
  double done = 0;
  for (const ValidationCase& c : config.cases) {
    if (c.name == "stretch_100")
      for (const int n : config.refinement) {
        if (progress.stopped()) {
          tables.status = Status::interrupted;
          return tables;
        }
        progress.report(done / total, fmt::format("the thesis's cube, {} cells per edge", n));
        add_refinement(config, c, n, tables.refinement);
      }
    for (const int m : config.cells) {
      progress.report(done++ / total, fmt::format("{}, {} cells across", c.name, m));
      if (m <= c.most_cells && !measure_case(config, c, m, tables.rows, progress)) {
        tables.status = Status::interrupted;
        return tables;
      }
    }
  }
  return tables;
}

namespace {

/// Whether a case asks a model for the law that the reference has.
bool same_law(const ValidationConfig& config, const std::string& name, const std::string& model) {
  for (const ValidationCase& c : config.cases)
    if (c.name == name && c.large)
      return std::any_of(config.models.begin(), config.models.end(), [&](const ValidationModel& m) {
        return m.name == model && m.model == "st_venant_kirchhoff";
      });
  return true;
}

}  // namespace

Table validation_summary(const Table& rows, const ValidationConfig& config) {
  Table summary({{"case"}, {"model"}, {"cells"}, {"error"}, {"order"}, {"status"}});
  for (const std::string& name : rows.distinct("case"))
    for (const std::string& model : rows.distinct("model")) {
      std::vector<std::pair<double, double>> errors;  // by cells
      std::string failure;
      double failed = 0;
      for (std::size_t r = 0; r < rows.size(); ++r) {
        if (rows.text(r, "case") != name || rows.text(r, "model") != model) continue;
        if (rows.text(r, "status") == "ok") {
          errors.emplace_back(rows.number(r, "cells"), rows.number(r, "error"));
        } else {
          failure = rows.text(r, "status");
          failed = rows.number(r, "cells");
        }
      }
      if (errors.empty()) {
        if (!failure.empty()) summary.add({name, model, failed, none, none, failure});
        continue;
      }
      double order = none;
      const bool exact = errors.back().second < validation_rounding;
      const bool comparable = same_law(config, name, model);
      if (errors.size() > 1 && !exact && comparable) {
        const auto [fine, small] = errors.back();
        const auto [coarse, large] = errors[errors.size() - 2];
        order = std::log(large / small) / std::log(fine / coarse);
      }
      summary.add({name, model, errors.back().first, errors.back().second, order,
                   std::string(exact                  ? "exact to rounding"
                               : !comparable          ? "another law"
                               : std::isfinite(order) ? "ok"
                                                      : "one size only")});
    }
  return summary;
}

}  // namespace mss::studies::validate
