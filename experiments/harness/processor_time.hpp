#pragma once

#include <ctime>

namespace mss {

/// Time that processors have worked for this process, of all its threads, since it was made: while others
/// have the cores it stands still, so that the cost of a computation on one thread is the same on a busy
/// machine, but for what shared caches and clock rates take.
class ProcessorStopwatch {
 public:
  double seconds() const { return now() - begin_; }

 private:
  static double now() {
    constexpr double nano = 1e-9;
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + nano * double(time.tv_nsec);
  }
  double begin_ = now();
};

/// Processor time that a task takes [s].
template <class Task>
double processor_seconds_of(Task&& task) {
  const ProcessorStopwatch watch;
  task();
  return watch.seconds();
}

}  // namespace mss
