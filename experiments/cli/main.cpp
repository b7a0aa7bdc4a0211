#include "experiments/cli/commands.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

/// Large matrices come and go in searches and steps. By default their pages go back to the system each time,
/// and are cleared again when they return, which took a quarter of the time of `mss modes`.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int gibibyte = 1 << 30;
  constexpr int most_of_older = 32 << 20;  // what a glibc takes that refuses more
  if (mallopt(M_MMAP_THRESHOLD, gibibyte) == 0) mallopt(M_MMAP_THRESHOLD, most_of_older);
  mallopt(M_TRIM_THRESHOLD, gibibyte);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  return mss::cli::run_command_line(argc, argv);
}
