#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/record.hpp"
#include "core/body/body.hpp"
#include "core/scene/scene.hpp"
#include "experiments/harness/json.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// What a run leaves for another to go on from: the file `restart.bin` beside its results. Going on needs no
/// other file: rows so far are in the record too.
struct Restart {
  Status status = Status::ok;  ///< how the run ended; a failed one has no record
  double t = 0;                ///< simulated [s]
  double dt = 0;               ///< the step, "safe" resolved; 0: the method's choice [s]
  std::string kernel{};        ///< instruction set of the sweep
  std::string version{};       ///< of the program
  std::string build{};         ///< build_description()
  std::string spring_law{};
  std::string body{};    ///< digest of cells and what they hold
  Json configuration{};  ///< of the scene
  std::vector<std::byte> record{};
};

inline constexpr const char* restart_file = "restart.bin";

/// Writes a file whole or not at all. Throws InputError.
void write_restart(const std::filesystem::path& file, const Restart& restart);

/// What a run left in a directory. Throws InputError, one sentence, where there is nothing that was written
/// whole by a program that keeps the same.
Restart read_restart(const std::filesystem::path& directory);

/// Throws InputError, one sentence, where a scene is not what was run but longer, or the run failed. A scene
/// may differ in name, duration, threads and [expect]. `directory`: as a user gave it.
void check_restart(const Restart& restart, const Scene& scene, const std::filesystem::path& directory);

/// One time a run went on from another.
struct Continuation {
  double t = 0;       ///< from there [s]
  bool exact = true;  ///< with the bits of a run that does not stop

  void remember(Record& record) { record.keep(t, exact); }
};

/// What a run goes on from, and what it leaves.
struct RestartChoice {
  Restart* from = nullptr;  ///< checked; its record, which may be large, is taken. nullptr: the run begins
  std::function<void(const Restart&)> keep = {};  ///< empty: nothing is left
  double seconds_between = 300;                   ///< at rows of a run under way, of wall time
};

}  // namespace mss
