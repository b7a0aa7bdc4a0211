// Engines that people use beside this program, on the same scenes: each with its own element or method, tried
// with several steps and iterations, as a single setting flatters where errors cancel. reference/peers has
// the adapters.
#include "experiments/studies/peers/peers.hpp"

#include <fmt/format.h>

#include <cmath>

namespace mss::studies::peers {

namespace {

constexpr const char* caption =
    "Cantilevers and bars of 4 x 1 x 1 m, 2 or 4 cells across, 10 kg/m^3, E = 1 MPa, nu = "
    "0.3 unless named; a cube and a ball of 1 m, 7 and 8 cells across, E = 0.1 MPa, 1000 kg/m^3; a block on "
    "a slope of 20 degrees, friction 0.2. The same particles and masses for all; lattices get the springs, "
    "elements the hexahedra or tetrahedra. A star: with constants by which the engine's law has the scene's "
    "E and nu at small strain (reference/peers), and MuJoCo's contacts with solref 0.004 1. Nothing is "
    "damped; a tip at rest is that of the same settings with a drag on all motion, after four periods "
    "(methods that creep are still on their way). Errors of tips and periods are those from quadratic finite "
    "elements (CalculiX C3D20, 16x4x4), of bars with nu = 0 from rho g L^2 / (2 E), of slopes from Coulomb's "
    "law for a rigid block; in charts errors below 0.1 percent are drawn there, and sweeps of both step and "
    "iterations are not joined. Volume is over that at rest; spin and momentum are compared with those at "
    "the start, in a second of free flight; motion_error is the distance from the lattice's own motion in "
    "short steps over its largest displacement. Processor time is that of stepping on one thread, the "
    "cheapest of three runs at most; of CalculiX that of the whole program. MuJoCo and Jolt run in "
    "WebAssembly in Node.js: what they would take natively is not known; of Bullet, natively and in "
    "WebAssembly, the price was 1.15 to 2.2 times the time (measured once, by an earlier prototype that is "
    "not kept), and native_low and native_high are the time over these. Engines that are not installed have "
    "a row that says so.";

std::string line_of(const Table& rows, std::size_t r) {
  const double tip = rows.number(r, "tip_error");
  const std::string error = std::isfinite(tip) ? fmt::format("tip {:+.1f} %", 100 * tip) : "no tip";
  const double period = rows.number(r, "period_error"), cpu = rows.number(r, "cpu_ms_per_frame");
  return fmt::format(
      "{:<20} {:<20} {:>9} {:>4}  {}{}{}{}\n", rows.text(r, "scene"), rows.text(r, "family"),
      std::isfinite(rows.number(r, "step")) ? fmt::format("{:.3g} ms", 1e3 * rows.number(r, "step")) : "",
      rows.number(r, "iterations"), error,
      std::isfinite(period) ? fmt::format(", period {:+.1f} %", 100 * period) : "",
      std::isfinite(cpu) ? fmt::format(", {:.3g} ms a frame", cpu) : "",
      rows.text(r, "status") == "ok" ? "" : "  (" + rows.text(r, "status") + ")");
}

Json configuration(const PeersConfig& config) {
  Json families = Json::array();
  for (const Family& family : config.families) {
    Json settings = Json::array();
    for (const Setting& setting : family.settings)
      settings.push_back({{"steps_per_frame", setting.steps}, {"iterations", setting.iterations}});
    families.push_back({{"name", family.name}, {"options", family.options}, {"settings", settings}});
  }
  return {{"families", families},
          {"price_of_webassembly", {least_price_of_webassembly, most_price_of_webassembly}}};
}

PeersConfig config_of(bool quick) { return {.families = peer_families(quick), .quick = quick}; }

ExperimentResult run_peers(const ExperimentOptions& options, Progress& progress) {
  const PeersConfig config = config_of(options.quick);
  PeersTables measured = measure_peers(config, progress);
  ExperimentResult result{
      .status = measured.status, .caption = caption, .configuration = configuration(config)};
  const Table& cantilevers = measured.tables[0].table;
  for (std::size_t r = 0; r < cantilevers.size(); ++r) result.summary += line_of(cantilevers, r);
  result.tables = std::move(measured.tables);
  return result;
}

/// Of this program alone: engines may be missing, and are another's.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  PeersConfig config = config_of(true);
  std::erase_if(config.families, [](const Family& family) { return family.adapter != Adapter::own; });
  static_cast<void>(options);
  return measure_peers(config, progress)
      .tables[0]
      .table.select(
          {"scene", "family", "step", "iterations", "tip_error", "period_error", "volume_low", "status"});
}

}  // namespace

ExperimentInfo experiment() {
  return {
      .name = "peers",
      .summary =
          "Jolt, MuJoCo, Bullet and CalculiX on the same scenes: tips, periods, volume, spin, contact and "
          "time",
      .times = true,
      .run = run_peers,
      .draw = draw_peers,
      .baseline = {.keys = {"scene", "family", "step", "iterations"},
                   .rules = {{"tip_error", 1e-3, 1e-6}, {"period_error", 1e-3, 1e-6}, {"volume_low", 1e-6}},
                   .table = baseline_table}};
}

}  // namespace mss::studies::peers
