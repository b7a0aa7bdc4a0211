// Section 5.2.1, "24 fps": frames a second of `mss view`, which simulates and draws, against cells per edge.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "experiments/harness/json.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/process.hpp"
#include "experiments/studies/thesis/thesis.hpp"

namespace mss::studies::thesis {

namespace {

namespace fs = std::filesystem;
/// This program; empty if what runs is another one, such as a test.
std::string this_program() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return !error && program.filename() == "mss" ? program.string() : "";
}

/// `mss view` of the thesis's cube in n cells per edge, thrown; its springs are proportional to the cell's
/// size, so that the material is the same. On a screen of its own where there is none.
ProgramRun view(const std::string& program, int n, int frames, const fs::path& shot) {
  const double k = 100 * 5.0 / n;
  std::vector<std::string> arguments{
      program,
      "view",
      "fig5_2_bounce",
      "--every-frame",
      "--log",
      "--shot",
      shot.string(),
      "--frames",
      std::to_string(frames),
      "--set",
      fmt::format("body.cells=[{0},{0},{0}]", n),
      fmt::format("body.cell_size={:.17g}", 1.0 / n),
      fmt::format("material.springs={{edge={0:.17g},face={0:.17g},body={1:.17g}}}", k, 3 * k),
      "solve.dt=\"safe\""};
  const std::vector<std::string> screen{"xvfb-run", "-a", "-s", "-screen 0 1400x1000x24"};
  if (std::getenv("DISPLAY") == nullptr) arguments.insert(arguments.begin(), screen.begin(), screen.end());
  return run_program(arguments);
}

/// The line of JSON about the picture; null if there is none.
Json record_of(const std::string& output) {
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    Json json = Json::parse(line, nullptr, false);
    if (json.is_object() && json.value("event", "") == "shot") return json;
  }
  return {};
}

std::string why_not(const std::string& program, const ProgramRun& run) {
  if (program.empty()) return "not run by mss";
  if (!run.started) return "no display and no xvfb-run";
  return run.output.find("without a window") != std::string::npos ? "built without a window" : "no display";
}

}  // namespace

Table measure_frames(const ThesisConfig& config, const Progress& progress) {
  Table rows({{"cells"},
              {"frames"},
              {"steps_per_frame"},
              {"stepping", "s"},
              {"drawing", "s"},
              {"frames_per_second"},
              {"renderer"},
              {"status"}});
  const std::string program = this_program();
  const fs::path shot = fs::temp_directory_path() / fmt::format("mss_thesis_{}.png", getpid());
  for (const int n : config.frame_cells) {
    if (progress.stopped()) break;
    const ProgramRun run = program.empty() ? ProgramRun{} : view(program, n, config.frames, shot);
    const Json record = run.exit_status == 0 ? record_of(run.output) : Json();
    if (!record.is_object()) {
      rows.add({n, config.frames, no_value, no_value, no_value, no_value, std::string("none"),
                why_not(program, run)});
      continue;
    }
    const double frames = record["frames"], stepping = record["stepping_seconds"],
                 drawing = record["drawing_seconds"];
    rows.add({n, config.frames, record["steps"].get<double>() / frames, stepping / frames, drawing / frames,
              frames / (stepping + drawing), record["renderer"].get<std::string>(), std::string("ok")});
  }
  std::error_code ignored;
  fs::remove(shot, ignored);
  return rows;
}

}  // namespace mss::studies::thesis
