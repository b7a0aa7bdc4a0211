// Times of the thesis's loops in a debug build, from a program of its own (debug_build.cpp).
#include <fmt/format.h>

#include "experiments/io/installation.hpp"
#include "experiments/io/process.hpp"
#include "experiments/studies/timing/timing.hpp"

namespace mss::studies::timing {

const char* debug_build_flags() { return MSS_DEBUG_BUILD_FLAGS; }

Table debug_build_samples(int cells, int samples, double sample_seconds, const std::vector<int>& threads) {
  std::vector<std::string> command{helper_program("mss_debug_build").string(), fmt::format("{}", cells),
                                   fmt::format("{}", samples), fmt::format("{}", sample_seconds)};
  for (const int count : threads) command.push_back(fmt::format("{}", count));
  const ProgramRun run = run_program(command);
  if (!run.started || run.exit_status != 0)
    return Table({{"method"}, {"threads"}, {"steps"}, {"seconds_per_step", "s"}});
  return Table::read(run.output, "mss_debug_build");
}

}  // namespace mss::studies::timing
