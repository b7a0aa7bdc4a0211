#pragma once

#include <string>
#include <vector>

namespace mss {

struct ProgramRun {
  bool started = false;  ///< false: there is no such program
  int exit_status = -1;  ///< -1 if it did not end by itself
  std::string output;    ///< what it wrote to stdout and stderr
};

/// Runs a program found on the PATH, without a shell, and waits for it. `arguments[0]` is its name.
ProgramRun run_program(const std::vector<std::string>& arguments);

}  // namespace mss
