// mss_debug_build: the thesis's Algorithm 1 and the plain loop as a debug build of a compiler has them,
// without optimisation and with checked containers. `mss timing` runs it and reads what it prints.
//
// It is a program of its own because the standard library's inline functions are in every object file that
// uses them: in one program the linker would keep a single copy of each, and either this code would call
// optimised ones, or the optimised code these.
#if defined(__OPTIMIZE__) || !defined(_GLIBCXX_DEBUG)
#error "a debug build is without optimisation and with checked containers"
#endif

#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <vector>

#include "experiments/studies/timing/workload.hpp"
#include "reference/algorithm1.hpp"
#include "reference/plain_loop.hpp"

namespace {

using mss::studies::timing::TimingWorkload;
using Clock = std::chrono::steady_clock;

/// Makes updates until `seconds` have passed, at least one, and prints their number and the time of each.
template <class Model>
void print_sample(const char* method, int threads, Model& model, double seconds) {
  model.step(TimingWorkload::dt);  // its data into the caches, its threads awake
  const Clock::time_point begin = Clock::now();
  long steps = 0;
  double elapsed = 0;
  while (elapsed < seconds || steps == 0) {
    model.step(TimingWorkload::dt);
    ++steps;
    elapsed = std::chrono::duration<double>(Clock::now() - begin).count();
  }
  std::array<char, 32> shortest{};  // that reads back as the same number
  *std::to_chars(shortest.data(), shortest.data() + shortest.size() - 1, elapsed / double(steps)).ptr = '\0';
  std::printf("%s,%d,%ld,%s\n", method, threads, steps, shortest.data());
}

/// A number from the whole of a text, at least `least`; false if there is none.
template <class Number>
bool read(const char* text, Number least, Number& number) {
  const char* end = text + std::strlen(text);
  const auto [last, error] = std::from_chars(text, end, number);
  return error == std::errc() && last == end && number >= least;
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): it ends the program, which the one that runs it sees
int main(int argc, char** argv) {
  int cells = 0, samples = 0;
  double seconds = 0;
  std::vector<int> threads;
  bool understood =
      argc > 4 && read(argv[1], 1, cells) && read(argv[2], 1, samples) && read(argv[3], 0.0, seconds);
  for (int i = 4; understood && i < argc; ++i) understood = read(argv[i], 1, threads.emplace_back());
  if (!understood) {
    std::cerr
        << "usage: mss_debug_build CELLS SAMPLES SECONDS THREADS...\n"
           "prints the time of an update of a cube of CELLS per edge, once per sample of SECONDS: by the "
           "plain loop, and by Algorithm 1 with each number of THREADS\n";
    return 2;
  }
  const mss::Vec3 gravity(0, 0, TimingWorkload::gravity);
  mss::reference::Algorithm1 model(mss::studies::timing::timing_cube(cells), gravity, 1);
  for (auto& p : model.particles()) p.x[2] *= TimingWorkload::stretch;
  mss::reference::PlainLoop<double> loop(model, 1);
  std::puts("method,threads,steps,seconds_per_step");
  for (int sample = 0; sample < samples; ++sample) {
    for (const int count : threads) {
      model.set_threads(count);
      print_sample("algorithm_1_debug", count, model, seconds);
    }
    print_sample("plain_loop_debug", 1, loop, seconds);
  }
}
