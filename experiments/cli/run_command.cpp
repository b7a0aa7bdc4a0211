// `mss run`: simulates one scene and writes the results.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>

#include "core/base/error.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/launched_ranks.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/error_estimates.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/restart.hpp"
#include "experiments/simulation/result_files.hpp"
#include "experiments/simulation/run_preview.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/simulation/vtk_series.hpp"

namespace mss::cli {

namespace {

namespace fs = std::filesystem;

constexpr double rounding = 1e-9;  ///< of estimates, over their values

struct RunChoice {
  std::string scene;
  std::string directory;
  std::string from;  ///< directory of a run to go on from; empty: none
  std::vector<std::string> overrides;
  std::optional<long> vtk;
  bool only_preview = false;
};

Json final_row(const Table& series) {
  Json row = Json::object();
  for (const Column& column : series.columns())
    row[column.name] = series.number(series.size() - 1, column.name);
  return row;
}

/// Numbers that were not measured are null.
Json to_json(const SleepReport& sleep) {
  return {{"share", sleep.share},
          {"seconds_per_step_asleep", sleep.seconds_asleep},
          {"seconds_per_step_awake", sleep.seconds_awake},
          {"most_apart", sleep.largest_deviation},
          {"apart_at_end", sleep.apart_at_end}};
}

std::string description(const SleepReport& sleep, double bound) {
  const std::string cost = std::isfinite(sleep.seconds_asleep)
                               ? fmt::format(", a step while all sleep takes {:.3g} % of one awake",
                                             100 * sleep.seconds_asleep / sleep.seconds_awake)
                               : std::string();
  return fmt::format(
      "{:.3g} % of the body slept{}; compared with a run without sleep, particles end up to {:.3g} m away "
      "and "
      "were up to {:.3g} m away, {} {:.3g} m allowed",
      100 * sleep.share, cost, sleep.apart_at_end, sleep.largest_deviation,
      sleep.largest_deviation > bound ? "more than the" : "of", bound);
}

/// Numbers that do not exist are null.
Json to_json(const CorrectedValue& value) {
  const bool ok = value.status == Status::ok;
  Json doubts = Json::array();
  for (const EstimateWarning doubt : value.doubts) doubts.push_back(explanation(doubt));
  return {{"quantity", value.quantity},
          {"unit", value.unit},
          {"value", value.value},
          {"error_estimate", ok ? Json(value.estimate) : Json()},
          {"corrected", ok ? Json(value.corrected()) : Json()},
          {"richardson", value.richardson ? Json(*value.richardson) : Json()},
          {"doubts", doubts},
          {"status", to_string(value.status)}};
}

Json to_json(const SceneEstimates& estimates) {
  Json values = Json::array();
  for (const CorrectedValue& value : estimates.values) values.push_back(to_json(value));
  return {{"values", values}, {"none", estimates.none}, {"no_richardson", estimates.no_richardson}};
}

std::string description(const CorrectedValue& value) {
  std::string line = fmt::format("{} {:.5g} {}", value.quantity, value.value, value.unit);
  if (value.status != Status::ok)
    return line + ", no error estimate: " + std::string(to_string(value.status));
  const double share = std::abs(value.estimate / value.value);
  if (share < rounding)
    line += ", no error estimated";
  else
    line += fmt::format(", corrected by {:.2g} ({:.2g} %) to {:.5g}", value.estimate, 100 * share,
                        value.corrected());
  if (value.richardson && share >= rounding)
    line += fmt::format(", by Richardson (order 2 assumed) {:.5g}", *value.richardson);
  return line;
}

/// Each doubt once, after the quantities that it is about.
std::vector<std::string> doubts_of(const std::vector<CorrectedValue>& values) {
  std::vector<std::pair<EstimateWarning, std::vector<std::string>>> quantities;
  for (const CorrectedValue& value : values)
    for (const EstimateWarning doubt : value.doubts) {
      auto found = std::find_if(quantities.begin(), quantities.end(),
                                [&](const auto& entry) { return entry.first == doubt; });
      if (found == quantities.end()) found = quantities.insert(found, {doubt, {}});
      found->second.push_back(value.quantity);
    }
  std::vector<std::string> lines;
  lines.reserve(quantities.size());
  for (const auto& [doubt, names] : quantities)
    lines.push_back(fmt::format("{}: {}", fmt::join(names, ", "), explanation(doubt)));
  return lines;
}

void print(const std::string& scene, const SceneEstimates& estimates) {
  if (!estimates.none.empty()) return fmt::print("{}: no error estimate: {}\n", scene, estimates.none);
  for (const CorrectedValue& value : estimates.values) fmt::print("{}: {}\n", scene, description(value));
  for (const std::string& line : doubts_of(estimates.values)) fmt::print("{}: {}\n", scene, line);
  if (!estimates.no_richardson.empty())
    fmt::print("{}: no extrapolation: {}\n", scene, estimates.no_richardson);
}

Json to_json(const std::vector<LevelCount>& levels) {
  Json json = Json::array();
  for (const LevelCount& level : levels)
    json.push_back({{"cell_size", level.cell_size}, {"cells", level.cells}, {"particles", level.particles}});
  return json;
}

/// Null where contact of bodies is not asked for.
Json to_json(const std::optional<ContactReport>& contact) {
  if (!contact) return {};
  return {{"touches", contact->touches},
          {"depth", contact->depth},
          {"force", contact->force},
          {"energy", contact->energy},
          {"depth_in_cells_so_far", contact->depth_so_far},
          {"depth_over_reach_so_far", contact->reach_so_far},
          {"motion_over_reach_so_far", contact->motion_so_far}};
}

std::string description(const std::vector<LevelCount>& levels) {
  std::vector<std::string> parts;
  std::size_t particles = 0;
  for (const LevelCount& level : levels) {
    parts.push_back(fmt::format("{} cells of {:.4g} m", level.cells, level.cell_size));
    particles += level.particles;
  }
  return fmt::format("{}; {} particles move", fmt::join(parts, ", "), particles);
}

/// series.csv as far as it is there: of ranks that share a body each may be lost, and the others with it.
class GrowingSeries {
 public:
  explicit GrowingSeries(const fs::path& file) : stream_(file, std::ios::binary | std::ios::trunc) {}
  void add(const SeriesRow& row) {
    const std::string csv = series_table({row}).csv();
    stream_ << (has_header_ ? csv.substr(csv.find('\n') + 1) : csv) << std::flush;
    has_header_ = true;
  }

 private:
  std::ofstream stream_;
  bool has_header_ = false;
};

/// Null of a run in one go.
Json to_json(const std::vector<Continuation>& continued) {
  if (continued.empty()) return {};
  Json json = Json::array();
  for (const Continuation& part : continued) json.push_back({{"from_time", part.t}, {"exact", part.exact}});
  return json;
}

/// Null of a body in one process. What a rank sends to each neighbour before a force are positions and
/// velocities of a plane of particles.
Json sharing(const Scene& scene, const ConnectedCommunicator& ranks) {
  if (!ranks.are_several()) return {};
  const ConnectedCommunicator::Costs costs = ranks.costs();
  const VoxelGrid& cells = scene.body.voxels;
  const std::int64_t number = scene.solve.precision == Precision::single ? sizeof(float) : sizeof(double);
  return {{"halo_exchanges", ranks.exchanges()},
          {"halo_bytes_to_a_neighbour", number * 2 * 3 * (cells.nx() + 1) * (cells.ny() + 1)},
          {"halo_bytes_sent", costs.halo_bytes},
          {"peak_memory_bytes", costs.peak_memory}};
}

/// Of the scene, and of how it ended.
std::vector<std::string> all_warnings(const Scene& scene, const SimulationResult& result) {
  std::vector<std::string> warnings = scene.warnings;
  for (std::string& diagnostic : diagnostics_of(scene, result)) warnings.push_back(std::move(diagnostic));
  return warnings;
}

Json summary(const MatchedScene& ready, const SimulationResult& result, const Table& series,
             const std::optional<SceneEstimates>& estimates, int ranks, const Json& sharing) {
  const Scene& scene = ready.scene;
  return {{"status", to_string(result.status)},
          {"continued", to_json(result.continued)},
          {"ranks", ranks},
          {"sharing", sharing},
          {"match", to_json(ready.report)},
          {"estimates", estimates ? to_json(*estimates) : Json()},
          {"sleep", result.sleep ? to_json(*result.sleep) : Json()},
          {"scene", scene.name},
          {"integrator", scene.solve.integrator},
          {"precision", to_string(scene.solve.precision)},
          {"dt", result.dt},
          {"stable_dt", result.sure_steps.free},  // null where it is infinite
          {"stable_dt_guarded", result.sure_steps.guarded},
          {"levels", to_json(result.levels)},
          {"contact", to_json(result.contact)},
          {"threads", result.threads},
          {"threads_working", result.threads_working},
          {"kernel", result.kernel},
          {"device", result.device.empty() ? Json() : Json(result.device)},
          {"transfer_seconds", result.transfer_seconds},
          {"steps", result.work.steps},
          {"simulated_seconds", result.simulated_seconds},
          {"wall_seconds", result.wall_seconds},
          {"work",
           {{"steps", result.work.steps},
            {"force_evaluations", result.work.force_evaluations},
            {"jacobians", result.work.jacobians},
            {"factorisations", result.work.factorisations},
            {"linear_solves", result.work.linear_solves},
            {"products", result.work.products}}},
          {"final", final_row(series)},
          {"warnings", all_warnings(scene, result)},
          {"configuration", to_json(scene)},
          {"provenance", provenance()}};
}

/// Removes again, at its end, what of a directory and those around it did not exist before and is empty.
class EmptyDirectories {
 public:
  explicit EmptyDirectories(const fs::path& directory) {
    for (fs::path made = directory; !made.empty() && !fs::exists(made); made = made.parent_path())
      made_.push_back(made);
  }
  EmptyDirectories(const EmptyDirectories&) = delete;
  EmptyDirectories& operator=(const EmptyDirectories&) = delete;
  ~EmptyDirectories() {
    std::error_code not_empty;
    for (const fs::path& made : made_) fs::remove(made, not_empty);
  }

 private:
  std::vector<fs::path> made_;  ///< from the innermost
};

/// Frames of the run that goes on in its own directory stay.
void prepare(const Scene& scene, const fs::path& directory, const std::string& from) {
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "mss: warning: {}\n", warning);
  if (!from.empty() && fs::equivalent(from, directory)) return;
  remove_vtk_series(directory);
  fs::remove(directory / restart_file);  // of an older run
}

/// What a run that goes on begins with, if this one does. Throws InputError where it cannot.
std::optional<Restart> restart_of(const Scene& scene, const RunChoice& choice) {
  if (choice.from.empty()) return std::nullopt;
  Restart restart = read_restart(choice.from);
  check_restart(restart, scene, choice.from);
  return restart;
}

/// A run goes on, and has its results, where nothing can be left to go on from.
void keep_restart(const fs::path& directory, const Restart& restart) {
  try {
    write_restart(directory / restart_file, restart);
  } catch (const InputError& error) {
    fmt::print(stderr, "mss: warning: {}\n", error.what());
  }
}

/// As simulate(), with rows written as soon as they are there.
SimulationResult simulate_in_ranks(const Scene& scene, Progress& progress, const VtkChoice& vtk,
                                   const Communicator& ranks) {
  const fs::path& directory = vtk.directory;
  std::optional<GrowingSeries> rows;
  if (ranks.is_lowest()) {
    fs::remove(directory / "summary.json");  // of an earlier run, whose rows are overwritten
    fs::remove(directory / "particles.csv");
    fs::remove(directory / restart_file);
    rows.emplace(directory / "series.csv");
  }
  return simulate(scene, progress, vtk, {ranks, [&](const SeriesRow& row) {
                                           if (rows) rows->add(row);
                                         }});
}

/// Of a body in one process, whose particles are all there.
std::string body_in_words(const Scene& scene, const SimulationResult& result) {
  Eigen::AlignedBox3d extent;
  double mass = 0;
  std::size_t cells = 0;
  for (const ParticleRecord& p : result.particles) {
    extent.extend(p.rest);
    mass += p.mass;
  }
  for (const LevelCount& level : result.levels) cells += level.cells;
  return mss::body_in_words(scene, extent.sizes(), mass, cells, result.particles.size());
}

void print(const Scene& scene, const std::vector<Continuation>& continued) {
  const bool exact = std::all_of(continued.begin(), continued.end(), [](const auto& c) { return c.exact; });
  const bool keeps = find_integrator(scene.solve.integrator).exact_restart;
  fmt::print(
      "{}: it went on from {:.10g} s; {}\n", scene.name, continued.back().t,
      exact   ? "all is as in one run, bit for bit"
      : keeps ? "once by another build, or on another machine, so it is as one run to rounding"
              : scene.solve.integrator + " began anew there, so it is as one run to the method's tolerance");
}

void report(const Scene& scene, const SimulationResult& result, const fs::path& directory,
            const std::optional<SceneEstimates>& estimates) {
  if (launch().count == 1) fmt::print("{}: {}\n", scene.name, body_in_words(scene, result));
  const bool fixed = find_integrator(scene.solve.integrator).stepping == Stepping::fixed;
  const std::string step = fixed ? fmt::format("of {:.4g} s", result.dt) : "of its own choice",
                    simulated =
                        is_static(scene) ? "" : fmt::format("{:.4g} s simulated ", result.simulated_seconds);
  constexpr double to_frame = 1e3 / 60;  // ms of a frame of 1/60 s, from seconds of a simulated second
  const std::string frame = is_static(scene) || !(result.simulated_seconds > 0)
                                ? ""
                                : fmt::format(", {:.4g} ms a frame of 1/60 s",
                                              result.wall_seconds / result.simulated_seconds * to_frame);
  fmt::print("{}: {} after {} steps {}, {}in {:.3g} s{}; see {}\n", scene.name, to_string(result.status),
             result.work.steps, step, simulated, result.wall_seconds, frame, directory.string());
  if (!result.device.empty())
    fmt::print("{}: on {}; carrying states there and back took {:.3g} s more\n", scene.name, result.device,
               result.transfer_seconds);
  if (!result.continued.empty()) print(scene, result.continued);
  if (is_refined(scene)) fmt::print("{}: {}\n", scene.name, description(result.levels));
  if (estimates) print(scene.name, *estimates);
  if (result.sleep) fmt::print("{}: {}\n", scene.name, description(*result.sleep, scene.solve.sleep.bound));
  std::fflush(stdout);
  for (const std::string& diagnostic : diagnostics_of(scene, result))
    fmt::print(stderr, "mss: {}: {}\n", scene.name, diagnostic);
}

/// What can be said before any work.
void check_run(const Scene& scene, const RunChoice& choice) {
  check_solve(scene);
  if (launch().count > 1) check_shared(scene);
  if (choice.vtk && *choice.vtk < 1)
    throw InputError(
        fmt::format("--vtk is {}; give the number of steps from frame to frame, 1 or more", *choice.vtk));
  if (!choice.from.empty() && launch().count > 1)
    throw InputError("--from goes on in one process; leave it out, or start mss without mpirun");
  if (!choice.from.empty() && choice.vtk)
    throw InputError(
        "--vtk writes frames from the beginning on, and --from begins later; leave one of them out");
  if (!choice.from.empty() && choice.only_preview)
    throw InputError("--dry-run is of a whole run, and --from goes on with one; leave one of them out");
  if (choice.vtk && scene.mesh && launch().count > 1)
    throw InputError(
        "--vtk of a body given as a mesh is for one process; leave it out, or start mss without mpirun");
}

/// All ranks call it, and the lowest writes.
void write_results(const MatchedScene& ready, SimulationResult& result,
                   const std::optional<SceneEstimates>& estimates, const ConnectedCommunicator& ranks,
                   const fs::path& directory) {
  const Scene& scene = ready.scene;
  const Table series = series_table(result.series);
  if (ranks.is_lowest()) write_atomically(directory / "series.csv", series.csv());
  write_particles(directory / "particles.csv", ranks, result.particles);
  const Json shared = sharing(scene, ranks);
  if (!ranks.is_lowest()) return;
  write_atomically(directory / "summary.json",
                   summary(ready, result, series, estimates, ranks.count(), shared).dump(2) + "\n");
  report(scene, result, directory, estimates);
}

/// How moduli were changed, before anything is computed with them.
void print(const std::string& scene, const std::optional<MatchReport>& report) {
  if (!report || launch().rank > 0) return;
  for (const std::string& line : description(*report)) fmt::print("{}: {}\n", scene, line);
  fmt::print("{}: matched in {:.2g} s\n", scene, report->seconds);
}

/// `--dry-run`: what would be computed; nothing is written.
void print_preview(const Scene& scene, int& exit_status) {
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "mss: warning: {}\n", warning);
  const RunPreview preview = preview_run(scene);
  const auto line = [&](const std::string& text) { fmt::print("{}: {}\n", scene.name, text); };
  line(mss::body_in_words(scene, preview.extent, preview.mass, preview.cells, preview.particles));
  if (is_static(scene)) return line(fmt::format("{}: an equilibrium, no steps", scene.solve.integrator));
  const double duration = scene.solve.duration;
  line(std::isnan(preview.dt)
           ? fmt::format("{}: {:.4g} s in steps of its own choice", scene.solve.integrator, duration)
           : fmt::format("{}: {:.4g} s in {} steps of {:.4g} s", scene.solve.integrator, duration,
                         preview.steps, preview.dt));
  for (const std::string& warning : warnings_of_step(scene, preview.dt))
    fmt::print(stderr, "mss: warning: {}\n", warning);
  if (preview.status != Status::ok) {
    exit_status = exit_simulation_failed;
    return line(
        fmt::format("{} within the first {:.4g} s", to_string(preview.status), preview.simulated_seconds));
  }
  line(fmt::format("about {:.3g} s as its first {:.4g} s went, {:.3g} MB of memory so far",
                   preview.expected_seconds(duration), preview.simulated_seconds,
                   double(preview.memory_bytes) / 1e6));
}

void run_scene(const RunChoice& choice, int& exit_status) {
  const MatchedScene ready = load_matched_scene(scene_file(choice.scene), choice.overrides);
  const Scene& scene = ready.scene;
  check_run(scene, choice);
  print(scene.name, ready.report);
  if (choice.only_preview) return print_preview(scene, exit_status);
  std::optional<Restart> from = restart_of(scene, choice);
  const fs::path directory =
      choice.directory.empty() ? fs::path("out") / scene.name : fs::path(choice.directory);
  const std::unique_ptr<ConnectedCommunicator> ranks =
      connect_ranks(fmt::format("the rows until then are in {}", (directory / "series.csv").string()));
  const EmptyDirectories of_a_refused_scene(directory);
  std::optional<DirectoryClaim> claim;
  if (ranks->is_lowest()) {
    prepare_directory(directory);  // before hours of work, not after
    claim.emplace(directory);
    prepare(scene, directory, choice.from);
  }
  SimulationResult result;
  std::optional<SceneEstimates> estimates;
  {
    TerminalProgress progress(scene.name);
    const VtkChoice vtk{.every = choice.vtk.value_or(0), .directory = directory};
    const RestartChoice restart{.from = from ? &*from : nullptr,
                                .keep = [&](const Restart& left) { keep_restart(directory, left); }};
    result = ranks->are_several() ? simulate_in_ranks(scene, progress, vtk, *ranks)
                                  : simulate(scene, progress, vtk, {}, restart);
    if (is_static(scene) && result.status == Status::ok)
      estimates = estimate_errors(scene, result.particles, progress);
  }
  write_results(ready, result, estimates, *ranks, directory);
  if (choice.vtk && ranks->is_lowest())
    fmt::print("{}: for ParaView: {}\n", scene.name, (directory / "cells.vtkhdf.series").string());
  ranks->leave();
  if (result.status == Status::interrupted)
    exit_status = exit_interrupted;
  else if (result.status != Status::ok)
    exit_status = exit_simulation_failed;
}

void add_run(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand(
      "run", "simulate a scene; writes series.csv, particles.csv, summary.json, restart.bin");
  const auto choice = std::make_shared<RunChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  command->add_option("--out", choice->directory, "Directory for the results (default ./out/<scene>)");
  command->add_option(
      "--from", choice->from,
      "Go on from where the run that wrote to this directory ended: one that was interrupted, or for a "
      "longer solve.duration; the results are those of one run");
  add_settings(*command, choice->overrides);
  command->add_option(
      "--vtk", choice->vtk,
      "Also write every N-th step for ParaView (cells, springs, a mesh's surface); with adaptive methods "
      "every N-th row");
  command->add_flag(
      "--dry-run", choice->only_preview,
      "Print what would be computed: size, mass, steps, about how long it takes, memory, warnings; "
      "write nothing");
  command->callback([choice, &exit_status] { run_scene(*choice, exit_status); });
}

}  // namespace

Command run_command() { return add_run; }

}  // namespace mss::cli
