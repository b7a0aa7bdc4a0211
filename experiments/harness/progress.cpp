#include "experiments/harness/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <utility>

namespace mss {

namespace {

volatile std::sig_atomic_t interrupt_seen = 0;

void note_interrupt(int signal) {
  interrupt_seen = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void watch_interrupts() {
  std::signal(SIGINT, note_interrupt);
  std::signal(SIGTERM, note_interrupt);
}

bool interrupted() { return interrupt_seen != 0; }

void Progress::report(double, std::string_view) {}

TerminalProgress::TerminalProgress(std::string task)
    : task_(std::move(task)), shown_(isatty(STDERR_FILENO) == 1) {}

TerminalProgress::~TerminalProgress() {
  if (shown_) fmt::print(stderr, "\r\033[K");
}

void TerminalProgress::report(double done, std::string_view what) {
  if (shown_) fmt::print(stderr, "\r\033[K{} {:3.0f} %  {}", task_, 100 * done, what);
}

bool TerminalProgress::stopped() const { return interrupted(); }

}  // namespace mss
