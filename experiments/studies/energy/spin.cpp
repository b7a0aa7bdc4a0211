// A body that spins freely for thousands of frames: what methods leave of its energy, momentum and spin.
// Steps of backward Euler take as much of a rotation as of a vibration of the same frequency; methods that
// project or iterate a few times add what they leave unsolved.
#include "experiments/studies/energy/spin.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "experiments/harness/case_rows.hpp"
#include "experiments/harness/settings.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/simulation/bench_scenes.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/outcome.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::studies::energy {

namespace {

constexpr double blown_up = 10;  // times the initial energy

/// The spinning body at its start.
struct SpinningBody {
  explicit SpinningBody(const SpinConfig& c)
      : setup(bench_setup(find_bench_scene("spin"), c.cells, {.young = c.young})),
        body(setup.body),
        owned(make_system<double>(c.model, body, {}, 1)),
        system(*owned),
        start(system.undeformed_state()) {
    const Vec3 centre = setup.body.cell_size * c.cells / 2 * Vec3::Ones(),
               drift = c.drift * Vec3(0.8, -0.6, 0);
    for (const std::ptrdiff_t site : body.sites())
      start.v.set(site, drift + setup.angular_velocity.cross(start.x.at(site) - centre));
    first = measure(system, start);
  }
  BenchSetup setup;
  Body body;
  std::unique_ptr<BodySystem<double>> owned;
  BodySystem<double>& system;
  State<double> start;
  Measures first;
};

/// Five a decade, two seconds, and the last.
std::vector<long> sampled_frames(long frames) {
  std::vector<long> all{early_frame, frames};
  for (int k = 0; std::pow(10, k / 5.0) < double(frames); ++k)
    all.push_back(std::lround(std::pow(10, k / 5.0)));
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  std::erase_if(all, [&](long f) { return f > frames; });
  return all;
}

/// The step of a method [s]; 0: it chooses it, NaN: none is safe.
double spin_step(const IntegratorInfo& info, const SpectralBound& bound) {
  if (info.stepping == Stepping::adaptive) return 0;
  if (!info.limit) return frame;
  return guaranteed_step(info, bound) > 0 ? explicit_steps(info, bound, frame).dt : no_value;
}

double left_of(const Vec3& now, const Vec3& first) { return now.dot(first) / first.squaredNorm(); }

Table empty_spin_rows() {
  return Table({{"integrator"},
                {"dt", "s"},
                {"frame"},
                {"t", "s"},
                {"energy"},
                {"momentum"},
                {"angular_momentum"},
                {"steps_taken"},
                {"status"}});
}

/// Advances to a frame. Methods refuse what they cannot serve.
std::string spin_on(Integrator<double>& method, SpinningBody& b, State<double>& state, long to, Work& work) {
  try {
    return std::string(to_string(method.advance(b.system, state, double(to) * frame, work)));
  } catch (const InputError&) {
    return "refused";
  }
}

/// One method through all frames, until it fails.
Table run_spin(const SpinConfig& config, const IntegratorInfo& info) {
  SpinningBody b(config);
  Table rows = empty_spin_rows();
  IntegratorOptions options{.dt = spin_step(info, b.system.spectral_bound()), .tolerance = config.tolerance};
  if (std::isnan(options.dt)) {
    rows.add({info.name, no_value, 0, 0.0, no_value, no_value, no_value, 0, std::string("no safe step")});
    return rows;
  }
  scale_errors(options, b.system);
  const auto method = info.make<double>(options);
  State<double> state = b.start;
  Work work;
  for (const long at : sampled_frames(config.frames)) {
    std::string status = spin_on(*method, b, state, at, work);
    const Measures m = measure_in_time(b.system, state, velocity_lag(info, options.dt));
    const double energy = m.mechanical() / b.first.mechanical();
    if (status == "ok" && !(energy < blown_up)) status = std::string(to_string(Outcome::blows_up));
    const auto shown = [&](double value) { return status == "ok" ? value : no_value; };
    rows.add({info.name, options.dt, at, double(at) * frame, shown(energy),
              shown(left_of(m.momentum, b.first.momentum)),
              shown(left_of(m.angular_momentum, b.first.angular_momentum)), work.steps, status});
    if (status != "ok") break;
  }
  return rows;
}

/// With marks for the step, and the status if it failed.
std::string row_name(const Table& summary, std::size_t r) {
  const std::string &status = summary.text(r, "status"), &integrator = summary.text(r, "integrator");
  const double dt = summary.number(r, "dt");
  const char* mark = dt == 0 ? " **" : dt < frame * (1 - 1e-9) ? " *" : "";
  return integrator + mark + (status == "ok" ? "" : " (" + status + ")");
}

}  // namespace

SpinConfig spin_config(const ExperimentOptions& options) {
  SpinConfig config{.model = options.model,
                    .integrators = moving_families(options.integrators, options.model)};
  if (options.quick) config.frames = 300;
  return config;
}

SpinTables measure_spin(const SpinConfig& config, int processes, Journal& journal, Progress& progress) {
  std::vector<Case> cases;
  for (const std::string& name : config.integrators)
    cases.push_back(
        {"spin, " + name, [&] { return rows_of(run_spin(config, find_integrator(name))); }, name});
  SpinTables tables{empty_spin_rows()};
  tables.status = gather_cases(cases, processes, journal, progress,
                               [&](const Json& rows) { add_rows(rows, tables.rows); });
  return tables;
}

Table spin_summary(const Table& rows) {
  Table summary({{"integrator"},
                 {"dt", "s"},
                 {"early_angular_momentum"},
                 {"energy"},
                 {"momentum"},
                 {"angular_momentum"},
                 {"frames"},
                 {"status"}});
  for (const std::string& integrator : rows.distinct("integrator")) {
    const Table run = rows.where("integrator", integrator), early = run.where("frame", double(early_frame));
    const std::size_t last = run.size() - 1;
    summary.add({integrator, run.number(last, "dt"),
                 early.size() > 0 ? early.number(0, "angular_momentum") : no_value,
                 run.number(last, "energy"), run.number(last, "momentum"),
                 run.number(last, "angular_momentum"), std::int64_t(run.number(last, "frame")),
                 run.text(last, "status") != "ok" ? run.text(last, "status")
                 : early.size() > 0               ? std::string("ok")
                                                  : std::string("shorter than two seconds")});
  }
  return summary;
}

std::vector<NamedTable> spin_files(const SpinConfig& config, const Table& rows) {
  return {{"energy_spin", rows},
          {"energy_spin_summary", spin_summary(rows)},
          {"energy_spin_settings", settings_table({{"model", config.model},
                                                   {"cells", std::int64_t(config.cells)},
                                                   {"young", config.young},
                                                   {"frames", std::int64_t(config.frames)}})}};
}

Chart spin_chart(const Table& summary, const Table& settings) {
  constexpr double most_shown = 1.5, apart = 0.22;  // of markers in a row; rows are 1 apart
  Chart chart{
      .title = "What is left of a free spin",
      .subtitle = fmt::format("undamped cube, {:g} cells an edge, {:g} MPa, 10 rad/s; {:g} frames of 1/60 s; "
                              "*: at safe steps, **: at steps it chooses",
                              setting_number(settings, "cells"), setting_number(settings, "young") / 1e6,
                              setting_number(settings, "frames")),
      .x = {.label = "at the end, over that at the start", .low = -0.05, .high = most_shown + 0.05},
      .y = {.label = ""}};
  std::vector<ChartSeries> left{{.label = "energy", .joined = false},
                                {.label = "linear momentum", .joined = false},
                                {.label = "angular momentum", .joined = false}};
  ChartSeries beyond{.label = fmt::format("failed, or more than {}", most_shown), .lines = false};
  std::vector<std::string> names;
  const std::vector<std::string> shown = without_variants(summary.distinct("integrator"));
  for (std::size_t r = 0; r < summary.size(); ++r) {
    if (std::find(shown.begin(), shown.end(), summary.text(r, "integrator")) == shown.end()) continue;
    const double y = double(shown.size() - names.size());
    bool all = true;
    for (std::size_t of = 0; of < left.size(); ++of) {
      constexpr std::array columns{"energy", "momentum", "angular_momentum"};
      const double x = summary.number(r, columns[of]);
      if (x <= most_shown) left[of].points.push_back({std::max(x, 0.0), y + apart * (1 - double(of))});
      all = all && x <= most_shown;
    }
    if (!all) beyond.points.push_back({most_shown, y});
    names.push_back(row_name(summary, r));
  }
  chart.y = named_rows(names);
  chart.series = std::move(left);
  if (!beyond.points.empty()) chart.series.push_back(std::move(beyond));
  add_model_to_subtitle(chart, setting_text(settings, "model"));
  return chart;
}

}  // namespace mss::studies::energy
