#pragma once

#include <vector>

namespace CLI {
class App;
}

namespace mss::cli {

/// Exit status of `mss`.
enum ExitStatus {
  exit_ok = 0,
  exit_check_failed = 1,
  exit_bad_input = 2,
  exit_simulation_failed = 3,
  exit_interrupted = 130  ///< Ctrl-C: finished rows are kept
};

/// Adds a subcommand whose callback does the work, sets the exit status if that is not 0, and throws
/// InputError for errors that the user can correct. A command is a file NAME_command.cpp that defines
/// `Command NAME_command()`.
using Command = void (*)(CLI::App& app, int& exit_status);

/// All commands, in the order of the help. The list is in CMakeLists.txt beside this file.
const std::vector<Command>& commands();

/// Runs the program: parses, dispatches, reports errors as one sentence on stderr. Returns the exit status.
int run_command_line(int argc, char** argv);

}  // namespace mss::cli
