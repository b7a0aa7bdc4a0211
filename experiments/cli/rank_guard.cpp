#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "experiments/cli/commands.hpp"
#include "experiments/cli/launched_ranks.hpp"
#include "experiments/harness/progress.hpp"

namespace mss::cli {

namespace {

pid_t guard = 0;   // of this worker; 0: there is none
pid_t worker = 0;  // of this guard
volatile std::sig_atomic_t told = 0;

void hand_on(int signal) {
  if (told == 0) kill(worker, signal);
  told = 1;
}

[[noreturn]] void watch_worker(const std::string& kept) {
  int status = 0;
  while (waitpid(worker, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFEXITED(status)) _exit(WEXITSTATUS(status));
  if (told != 0) _exit(exit_interrupted);
  fmt::print(stderr, "mss: rank {} of {} was ended by signal {} ({}), so all end; {}\n", launch().rank,
             launch().count, WTERMSIG(status), strsignal(WTERMSIG(status)), kept);
  std::fflush(stderr);
  _exit(exit_simulation_failed);
}

}  // namespace

void work_under_guard(const std::string& kept) {
  std::fflush(nullptr);  // or both would print what waits
  const pid_t parent = getpid();
  worker = fork();
  if (worker < 0) throw std::system_error(errno, std::generic_category(), "a process cannot be started");
  if (worker > 0) {
    prctl(PR_SET_NAME, "mss-guard");  // for `top`, and those who end processes by name
    std::signal(SIGINT, hand_on);
    std::signal(SIGTERM, hand_on);
    watch_worker(kept);
  }
  guard = parent;
  setpgid(0, 0);  // launchers end groups: the guard's alone
}

bool told_to_end() { return interrupted() || (guard != 0 && getppid() != guard); }

}  // namespace mss::cli
