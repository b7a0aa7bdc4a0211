// Which cells a scene at rest needs.
#include "experiments/advise/static_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/harness/drawings.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/results_folder.hpp"
#include "experiments/io/output.hpp"

namespace mss::advise {

namespace {

namespace fs = std::filesystem;

constexpr double growth = 8;  ///< of a solution's time as cells halve
constexpr std::size_t sizes_for_limit = 3;
constexpr double negligible = 1e-9;
constexpr double least_gain = 1.5;  ///< of a map, in particles: below, cells of a size between do as well

const CorrectedValue* find(const SizeTried& size, const std::string& quantity) {
  for (const CorrectedValue& value : size.estimates.values)
    if (value.quantity == quantity && value.status == Status::ok) return &value;
  return nullptr;
}

/// What a quantity tends to, and relative to it how far the assumption of order 2 leads elsewhere.
struct Limit {
  double value = no_value, uncertainty = no_value;
};

Limit limit_of(const StaticAdvice& advice, const std::string& quantity) {
  std::vector<double> values;
  for (const SizeTried& size : advice.sizes) {
    const CorrectedValue* found = find(size, quantity);
    if (found == nullptr)
      values.clear();
    else
      values.push_back(found->value);
  }
  if (values.size() < sizes_for_limit) return {};
  const double *last = values.data() + values.size() - 1, change = last[0] - last[-1];
  if (std::abs(change) <= negligible * std::abs(last[0])) return {last[0], 0};
  const double ratio = (last[-1] - last[-2]) / change;
  if (!(ratio > 1)) return {};
  const double limit = last[0] + change / (ratio - 1);
  return {limit, std::abs((last[0] + change / 3) / limit - 1)};
}

SizeTried solve(const Scene& scene, Progress& progress) {
  SizeTried tried{.cell_size = scene.body.cell_size};
  SimulationResult result;
  tried.seconds = seconds_of([&] { result = simulate(scene, progress); });
  tried.work = result.work;
  tried.status = result.status;
  tried.particles = result.particles.size();
  tried.boxes = extents_of_boxes(scene, result.particles);
  if (result.status == Status::ok)
    tried.estimate_seconds =
        seconds_of([&] { tried.estimates = estimate_errors(scene, result.particles, progress); });
  return tried;
}

/// The largest component of a displacement at the finest size, or the stored energy.
std::string judged_quantity(const AdviseRequest& request, const SizeTried& finest) {
  const CorrectedValue* largest = nullptr;
  for (const CorrectedValue& value : finest.estimates.values)
    if (value.quantity.starts_with("displacement") &&
        (largest == nullptr || std::abs(value.value) > std::abs(largest->value)))
      largest = &value;
  return largest != nullptr && request.of == ErrorOf::displacement ? largest->quantity : "stored energy";
}

/// The largest cells of those that meet the error and all smaller do too.
template <class Meets>
double largest_cells(const StaticAdvice& advice, Meets&& meets) {
  double largest = 0;
  for (auto size = advice.sizes.rbegin(); size != advice.sizes.rend() && meets(*size); ++size)
    largest = size->cell_size;
  return largest;
}

void conclude(const AdviseRequest& request, StaticAdvice& advice) {
  if (advice.sizes.size() < sizes_for_limit) {
    advice.explanation = fmt::format(
        "a limit needs {} sizes of cells, and {} could be solved; give more --patience, or cells that divide",
        sizes_for_limit, advice.sizes.size());
    return;
  }
  advice.quantity = judged_quantity(request, advice.sizes.back());
  const Limit limit = limit_of(advice, advice.quantity);
  if (!std::isfinite(limit.value)) {
    advice.explanation =
        fmt::format("{} does not converge over the {} smallest sizes", advice.quantity, sizes_for_limit);
    if (!advice.sizes.back().estimates.none.empty()) advice.explanation = advice.sizes.back().estimates.none;
    return;
  }
  const auto meets = [&](double value) {
    return std::abs(value / limit.value - 1) + limit.uncertainty <= request.error;
  };
  advice.as_computed = largest_cells(advice, [&](const SizeTried& size) {
    const CorrectedValue* value = find(size, advice.quantity);
    return value != nullptr && meets(value->value);
  });
  advice.corrected = largest_cells(advice, [&](const SizeTried& size) {
    const CorrectedValue* value = find(size, advice.quantity);
    return value != nullptr && value->doubts.empty() && meets(value->corrected());
  });
  if (advice.as_computed == 0 && advice.corrected == 0)
    advice.explanation = fmt::format(
        "no size meets {:.3g} %, of which the limit's uncertainty is {:.2g} %; give more --patience",
        100 * request.error, 100 * limit.uncertainty);
}

const SizeTried* size_of(const StaticAdvice& advice, double cell_size) {
  for (const SizeTried& size : advice.sizes)
    if (size.cell_size == cell_size) return &size;
  return nullptr;
}

/// The three smallest of the sizes that do not meet the error.
std::vector<double> sizes_of_maps(const StaticAdvice& advice) {
  std::vector<double> sizes;
  for (auto size = advice.sizes.rbegin(); size != advice.sizes.rend() && sizes.size() < 3; ++size)
    if (size->cell_size > advice.as_computed) sizes.push_back(size->cell_size);
  return sizes;
}

/// Particles that cells of one size would need for an error, by interpolation of the logarithms between the
/// sizes tried; at smaller errors than the smallest cells have, theirs, which are too few.
double whole_particles(const StaticAdvice& advice, double limit, double error) {
  double before = no_value, particles_before = no_value;
  for (const SizeTried& size : advice.sizes) {
    if (!same_extents(size.boxes, advice.sizes.back().boxes)) continue;
    const CorrectedValue* value = find(size, advice.quantity);
    const double here = value != nullptr ? std::abs(value->value / limit - 1) : no_value;
    if (before >= error && error >= here && before > here) {
      const double share = std::log(before / error) / std::log(before / here);
      return particles_before * std::pow(double(size.particles) / particles_before, share);
    }
    before = here;
    particles_before = double(size.particles);
  }
  return error < before ? particles_before : no_value;
}

void advise_maps(const Scene& scene, const AdviseRequest& request, Progress& progress, StaticAdvice& advice) {
  const Limit limit = limit_of(advice, advice.quantity);
  if (!std::isfinite(limit.value) || !can_be_split(scene)) return;
  const SizeTried* whole = size_of(advice, advice.as_computed);
  std::size_t fewest = whole != nullptr ? whole->particles : advice.sizes.back().particles;
  advice.maps = try_maps(scene, advice.quantity, sizes_of_maps(advice), fewest, progress);
  for (std::size_t i = 0; i < advice.maps.size(); ++i) {
    MapTried& map = advice.maps[i];
    if (!same_extents(map.boxes, advice.sizes.back().boxes)) continue;
    const double error = std::abs(map.value / limit.value - 1);
    map.gain = whole_particles(advice, limit.value, error) / double(map.particles);
    if (error + limit.uncertainty > request.error || map.particles >= fewest || !(map.gain >= least_gain))
      continue;
    fewest = map.particles;
    advice.map = i;
    advice.explanation.clear();
  }
}

}  // namespace

void check_static(const AdviseRequest& request) {
  if (request.of != ErrorOf::displacement && request.of != ErrorOf::energy)
    throw InputError(fmt::format("--of {} is about motion; of a scene at rest give displacement or energy",
                                 error_names()[std::size_t(request.of)]));
}

StaticAdvice advise_at_rest(const Scene& scene, const AdviseRequest& request, Progress& progress) {
  check_static(request);
  if (is_refined(scene))
    throw InputError(
        fmt::format("{}: advice begins with cells of one size; leave [[refine]] and body.refinement out",
                    scene.file.string()));
  SceneEdit edit = edit_of(scene);
  while (edit.level % 2 == 0) edit.level /= 2;
  StaticAdvice advice;
  for (double expected = 0; expected <= request.patience; edit.level *= 2) {
    std::optional<Scene> sized;
    try {
      sized = edited(scene, edit);
    } catch (const InputError&) {  // a box holds no particle, or there are too many
      if (!advice.sizes.empty() || edit.level > level_of(scene)) break;
      continue;
    }
    progress.report(0, fmt::format("cells of {:.4g} m", sized->body.cell_size));
    advice.sizes.push_back(solve(*sized, progress));
    advice.stopped = progress.stopped();
    if (advice.stopped) break;
    const SizeTried& last = advice.sizes.back();
    expected =
        growth *
        by_work({.work = last.work, .particles = last.particles, .of_elements = !has_springs(scene.model)});
  }
  if (advice.stopped) return advice;
  conclude(request, advice);
  advise_maps(scene, request, progress, advice);
  advice.stopped = progress.stopped();
  return advice;
}

namespace {

void add_rows(const StaticAdvice& advice, const std::string& quantity, Table& table) {
  const auto [limit, uncertainty] = limit_of(advice, quantity);
  for (const SizeTried& size : advice.sizes) {
    const CorrectedValue* value = find(size, quantity);
    const bool known = value != nullptr && std::isfinite(limit);
    table.add({quantity, size.cell_size, std::int64_t(size.particles), size.seconds, size.estimate_seconds,
               value ? value->value : no_value, value ? value->estimate : no_value, limit, uncertainty,
               known ? value->value / limit - 1 : no_value, known ? value->corrected() / limit - 1 : no_value,
               value ? to_string(value->doubts) : "",
               std::string(known                       ? "ok"
                           : size.status != Status::ok ? to_string(size.status)
                           : value                     ? "does not converge"
                                                       : "no estimate")});
  }
}

}  // namespace

std::vector<NamedTable> static_tables(const AdviseRequest& request, const StaticAdvice& advice) {
  Table table({{"quantity"},
               {"cell_size", "m"},
               {"particles"},
               {"seconds", "s"},
               {"estimate_seconds", "s"},
               {"value"},
               {"estimate"},
               {"limit"},
               {"uncertainty"},
               {"error"},
               {"corrected_error"},
               {"doubts"},
               {"status"}});
  if (!advice.sizes.empty())
    for (const CorrectedValue& value : advice.sizes.back().estimates.values)
      add_rows(advice, value.quantity, table);
  Table maps({{"cell_size", "m"},
              {"levels"},
              {"particles"},
              {"seconds", "s"},
              {"value"},
              {"error"},
              {"gain"},
              {"status"}});
  const double limit = limit_of(advice, advice.quantity).value;
  for (const MapTried& map : advice.maps)
    maps.add({map.cell_size, map.levels, std::int64_t(map.particles), map.seconds, map.value,
              map.value / limit - 1, map.gain,
              std::string(std::isfinite(map.gain) || map.status != Status::ok ? to_string(map.status)
                                                                              : "not compared")});
  Table requested({{"quantity"}, {"error"}, {"as_computed", "m"}, {"corrected", "m"}});
  requested.add({advice.quantity, request.error, advice.as_computed, advice.corrected});
  return {{"static_advice", table}, {"static_advice_maps", maps}, {"static_advice_request", requested}};
}

Drawings draw_at_rest(const std::vector<NamedTable>& tables) {
  const Table &all = find_table(tables, "static_advice"),
              &request = find_table(tables, "static_advice_request");
  const std::string quantity = request.text(0, "quantity");
  if (all.size() == 0 || quantity.empty()) return {};
  const Table rows = all.where("quantity", quantity).where("status", "ok");
  Chart chart{.title = "At rest: error against the size of cells",
              .subtitle = fmt::format("{}; against the limit of the smallest cells", quantity),
              .x = {.label = "size of cells", .logarithmic = true, .unit = "m"},
              .y = {.label = "relative error", .logarithmic = true}};
  for (const auto& [column, label] :
       {std::pair{"error", "as computed"}, {"corrected_error", "corrected by the estimate"}}) {
    ChartSeries series{.label = label};
    for (std::size_t r = 0; r < rows.size(); ++r)
      series.points.push_back({rows.number(r, "cell_size"), std::abs(rows.number(r, column))});
    chart.series.push_back(std::move(series));
  }
  using Direction = ReferenceLine::Direction;
  chart.lines.push_back({Direction::horizontal, request.number(0, "error"), "requested"});
  if (rows.size() > 0 && rows.number(0, "uncertainty") > 0)
    chart.lines.push_back({Direction::horizontal, rows.number(0, "uncertainty"), "uncertainty of the limit"});
  return {.charts = {{"static_advice", chart}}};
}

void write_static_advice(const Scene& scene, const AdviseRequest& request, const StaticAdvice& advice,
                         const Json& origin, const fs::path& directory) {
  const std::vector<NamedTable> tables = static_tables(request, advice);
  for (const NamedTable& table : tables)
    write_atomically(directory / (table.name + ".csv"), table.table.csv());
  const Json meta{{"experiment", "static_advice"},
                  {"scene", scene.name},
                  {"error", request.error},
                  {"quantity", advice.quantity},
                  {"cell_size_as_computed", advice.as_computed},
                  {"cell_size_corrected", advice.corrected},
                  {"map", advice.map ? Json{{"cell_size", advice.maps[*advice.map].cell_size},
                                            {"levels", advice.maps[*advice.map].levels}}
                                     : Json()},
                  {"explanation", advice.explanation},
                  {"configuration", to_json(scene)},
                  {"tables", describe_tables(tables)},
                  {"provenance", origin}};
  write_atomically(directory / "meta.json", meta.dump(2) + "\n");
  for (const char* picture : {"static_advice.svg", "static_advice.png"}) fs::remove(directory / picture);
  write_drawings(draw_at_rest(tables), tables, origin, directory);
}

namespace {

std::string summary_of_maps(const Scene& scene, const StaticAdvice& advice) {
  if (advice.maps.empty()) return {};
  if (!advice.map)
    return fmt::format(
        "{}: smaller cells in places do not pay: at equal errors they save less than a third of the "
        "particles\n",
        scene.name);
  const MapTried& map = advice.maps[*advice.map];
  std::string text = fmt::format(
      "{}: it is met as computed in cells of {:.4g} m, halved up to {} times in places (body.refinement = "
      "\"auto\", body.refinement_levels = {}): {} particles, {:.3g} s",
      scene.name, map.cell_size, map.levels, map.levels, map.particles, map.seconds);
  if (const SizeTried* whole = size_of(advice, advice.as_computed))
    text += fmt::format(" in place of {} and {:.3g} s{}", whole->particles, whole->seconds,
                        map.seconds > whole->seconds ? ": fewer, but slower" : "");
  return text + "\n";
}

}  // namespace

std::string summary(const Scene& scene, const AdviseRequest& request, const StaticAdvice& advice) {
  std::string text;
  const double limit = limit_of(advice, advice.quantity).value;
  for (const SizeTried& size : advice.sizes) {
    const CorrectedValue* value = find(size, advice.quantity);
    if (value == nullptr || !std::isfinite(limit)) continue;
    text += fmt::format(
        "  cells of {:<7.4g} m: {} {:.5g} {}, error {:.3g} %, estimated {:.3g} %, corrected {:.3g} %; "
        "doubts: {}\n",
        size.cell_size, value->quantity, value->value, value->unit, 100 * (value->value / limit - 1),
        -100 * value->estimate / limit, 100 * (value->corrected() / limit - 1), to_string(value->doubts));
  }
  const auto meet = [&](const char* how, double cell_size) {
    return cell_size > 0 ? fmt::format("{}: {:.3g} % is met {} in cells of {:.4g} m\n", scene.name,
                                       100 * request.error, how, cell_size)
                         : std::string();
  };
  return text + meet("as computed", advice.as_computed) + meet("by the corrected value", advice.corrected) +
         summary_of_maps(scene, advice);
}

}  // namespace mss::advise
