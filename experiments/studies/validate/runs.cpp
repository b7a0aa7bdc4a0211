// The runs of `mss validate`: every model of every case at every size, and the thesis's cube refined.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/validate/validate.hpp"

namespace mss::studies::validate {

BodyConfig case_body(const ValidationConfig& config, const ValidationCase& c, const ValidationModel& model,
                     int m) {
  const double h = 1.0 / m;
  const ElasticConstants material{config.young, c.poisson};
  return {.voxels = VoxelGrid::box(m * c.proportions[0], m * c.proportions[1], m * c.proportions[2]),
          .cell_size = h,
          .density = config.density,
          .springs = model.springs(material, h),
          .elastic = material,
          .damping = {.law = c.viscosity > 0 ? Damping::Law::viscosity : Damping::Law::none,
                      .viscosity = c.viscosity}};
}

namespace {

constexpr double slow = 2;  ///< [s]; where a solution takes longer, none is repeated

/// The solution by one model, and the times of its repetitions.
struct Result {
  Solution solution{};
  std::int64_t unknowns = 0;
  std::vector<double> seconds{};
};

/// Builds the body and the system and solves the case; all of this is timed.
void solve_once(const ValidationConfig& config, const ValidationCase& c, const ValidationModel& model, int m,
                Result& result) {
  if (result.solution.status != Status::ok) return;
  const Stopwatch watch;
  const Body body(case_body(config, c, model, m));
  const auto system = make_system<double>(model.model, body, c.environment, config.threads);
  result.solution = c.solve(*system);
  result.seconds.push_back(watch.seconds());
  result.unknowns = std::int64_t(unknowns_of(*system).size());
}

void add_row(Table& rows, const ValidationCase& c, const ValidationModel& model, int m, const Result& r) {
  const auto [status, value] = r.solution;
  const bool found = std::isfinite(value), ok = found && status == Status::ok;
  const auto [median, q1, q3] = quartiles(r.seconds);
  rows.add({c.name, model.name, m, r.unknowns, c.quantity + " [" + c.unit + "]", ok ? value : no_value,
            c.reference, ok ? std::abs(value / c.reference - 1) : no_value, c.uncertainty, median, q1, q3,
            std::int64_t(r.seconds.size()),
            std::string(status == Status::ok && !found ? "not found" : to_string(status))});
}

/// All models of a case in turn, repeatedly; false if stopped.
bool measure_case(const ValidationConfig& config, const ValidationCase& c, int m, Table& rows,
                  const Progress& progress) {
  std::vector<const ValidationModel*> models;
  for (const ValidationModel& model : config.models)
    if (c.deformations == Deformations::large || !model.for_large_only) models.push_back(&model);
  std::vector<Result> results(models.size());
  const auto solve_all = [&](int times) {
    return interleave(times, results.size(), progress,
                      [&](std::size_t i) { solve_once(config, c, *models[i], m, results[i]); });
  };
  if (!solve_all(1)) return false;
  const bool quick =
      std::all_of(results.begin(), results.end(), [](const Result& r) { return r.seconds.front() < slow; });
  if (quick && config.repetitions > 1 && !solve_all(config.repetitions - 1)) return false;
  for (std::size_t i = 0; i < results.size(); ++i) add_row(rows, c, *models[i], m, results[i]);
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
                {"uncertainty"},
                {"seconds", "s"},
                {"q1", "s"},
                {"q3", "s"},
                {"repeats"},
                {"status"}});
}

/// The thesis's springs on a cube of 1 m at n cells per edge: as printed, or scaled by 5 / n so that they are
/// the same material as at n = 5.
SpringConstants refined_springs(bool fixed_material, int n) {
  const double scale = fixed_material ? 5.0 / n : 1;
  return {.edge = 100 * scale, .face = 100 * scale, .body = 300 * scale, .volume = 0.1};
}

/// Young's modulus along an edge, from a tension test.
void add_refinement(const ValidationConfig& config, const ValidationCase& tension, int n, Table& table) {
  for (const bool fixed_material : {false, true})
    for (const Sharing sharing : {Sharing::weighted, Sharing::uniform}) {
      const Body body({.voxels = VoxelGrid::box(n, n, n),
                       .cell_size = 1.0 / n,
                       .sharing = sharing,
                       .density = config.density,
                       .springs = refined_springs(fixed_material, n)});
      SpringSystem<double> system(body, tension.environment, {.threads = 1});
      const Solution solution = tension.solve(system);
      const bool ok = solution.status == Status::ok;
      table.add({std::string(fixed_material ? "material" : "k"),
                 std::string(sharing == Sharing::weighted ? "weighted" : "uniform"), n,
                 ok ? 1 / solution.value : no_value, std::string(to_string(solution.status))});
    }
}

}  // namespace

ValidationTables measure_validation(const ValidationConfig& config, Progress& progress) {
  ValidationTables tables{
      .rows = empty_rows(),
      .refinement = Table({{"constant"}, {"sharing"}, {"cells"}, {"young", "Pa"}, {"status"}}),
      .strains = empty_strains(),
      .estimates = empty_estimates()};
  const auto total = double(config.cases.size() * config.cells.size() + 1);
  double done = 0;
  for (const ValidationCase& c : config.cases)
    for (const int m : config.cells) {
      progress.report(done++ / total, fmt::format("{}, {} cells across", c.name, m));
      if (m <= c.most_cells && !measure_case(config, c, m, tables.rows, progress)) {
        tables.status = Status::interrupted;
        return tables;
      }
    }
  const ValidationCase tension = tension_case(config.young, "tension", Vec3::UnitX());
  for (const int n : config.refinement) {
    progress.report(done / total, fmt::format("the thesis's cube, {} cells per edge", n));
    if (progress.stopped()) {
      tables.status = Status::interrupted;
      return tables;
    }
    add_refinement(config, tension, n, tables.refinement);
  }
  if (!measure_large_strain(config, progress, tables.strains) ||
      !measure_estimates(config, progress, tables.estimates))
    tables.status = Status::interrupted;
  return tables;
}

namespace {

const ValidationCase& case_named(const ValidationConfig& config, const std::string& name) {
  return *std::find_if(config.cases.begin(), config.cases.end(),
                       [&](const ValidationCase& c) { return c.name == name; });
}

const ValidationModel& model_named(const ValidationConfig& config, const std::string& name) {
  return *std::find_if(config.models.begin(), config.models.end(),
                       [&](const ValidationModel& m) { return m.name == name; });
}

/// Whether a model converges to the reference of a case: all do in small deformations.
bool same_law(const ValidationCase& c, const ValidationModel& model) {
  return c.deformations == Deformations::small || model.linear_in_green_strain;
}

/// Between the two finest resolutions; NaN if there is only one.
double observed_order(const std::vector<std::pair<double, double>>& errors_by_cells) {
  if (errors_by_cells.size() < 2) return no_value;
  const auto [fine, small] = errors_by_cells.back();
  const auto [coarse, large] = errors_by_cells[errors_by_cells.size() - 2];
  return std::log(large / small) / std::log(fine / coarse);
}

/// One case by one model; nothing is added if there are no rows of it.
void add_summary(Table& summary, const Table& runs, const std::string& name, const std::string& model,
                 bool comparable) {
  std::vector<std::pair<double, double>> errors;  // by cells
  std::string failure;
  double failed = 0;
  for (std::size_t r = 0; r < runs.size(); ++r)
    if (runs.text(r, "status") == "ok") {
      errors.emplace_back(runs.number(r, "cells"), runs.number(r, "error"));
    } else {
      failure = runs.text(r, "status");
      failed = runs.number(r, "cells");
    }
  if (errors.empty()) {
    if (!failure.empty()) summary.add({name, model, failed, no_value, no_value, failure});
    return;
  }
  const bool exact = errors.back().second < validation_rounding;
  const double order = exact || !comparable ? no_value : observed_order(errors);
  summary.add({name, model, errors.back().first, errors.back().second, order,
               std::string(exact                  ? "exact to rounding"
                           : !comparable          ? "another law"
                           : std::isfinite(order) ? "ok"
                                                  : "one size only")});
}

}  // namespace

Table validation_summary(const Table& rows, const ValidationConfig& config) {
  Table summary({{"case"}, {"model"}, {"cells"}, {"error"}, {"order"}, {"status"}});
  for (const std::string& name : rows.distinct("case"))
    for (const std::string& model : rows.distinct("model"))
      add_summary(summary, rows.where("case", name).where("model", model), name, model,
                  same_law(case_named(config, name), model_named(config, model)));
  return summary;
}

}  // namespace mss::studies::validate
