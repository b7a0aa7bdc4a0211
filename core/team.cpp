#include "core/team.hpp"

#include <sched.h>

#include <algorithm>

namespace mss {

int available_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, int(std::thread::hardware_concurrency()));
}

namespace {

bool reached(std::uint32_t value, std::uint32_t target) {
  return static_cast<std::int32_t>(value - target) >= 0;
}

}  // namespace

void wait_until_reached(const Counter& value, std::uint32_t target, bool may_spin) {
  constexpr int spins =
      400;  // of some 70 cycles each, about 10 us: a step of the smallest bodies worth two threads
  for (int i = 0; may_spin && i < spins; ++i) {
    if (reached(value.load(std::memory_order_acquire), target)) return;
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }
  for (std::uint32_t seen = value.load(std::memory_order_acquire); !reached(seen, target);
       seen = value.load(std::memory_order_acquire))
    value.wait(seen, std::memory_order_acquire);
}

void announce(Counter& value, std::uint32_t reached) {
  value.store(reached, std::memory_order_seq_cst);
  value.notify_all();
}

Team::Team(int size) : size_(std::max(1, size)), may_spin_(size_ <= available_cores()) {
  for (int rank = 1; rank < size_; ++rank) threads_.emplace_back([this, rank] { work(rank); });
}

Team::~Team() {
  stop_.store(true, std::memory_order_release);
  round_.fetch_add(1, std::memory_order_seq_cst);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Team::run(const std::function<void(int)>& task) {
  const auto others = std::uint32_t(size_ - 1);
  if (others > 0) {
    task_ = &task;
    done_.store(0, std::memory_order_relaxed);
    round_.fetch_add(1, std::memory_order_seq_cst);
    round_.notify_all();
  }
  task(0);
  if (others > 0) wait_until_reached(done_, others, may_spin_);
}

void Team::for_each(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
  run([&](int rank) {
    const std::ptrdiff_t last = count * (rank + 1) / size_;
    for (std::ptrdiff_t i = count * rank / size_; i < last; ++i) task(i);
  });
}

void Team::work(int rank) {
  for (std::uint32_t round = 1;; ++round) {
    wait_until_reached(round_, round, may_spin_);
    if (stop_.load(std::memory_order_acquire)) return;
    (*task_)(rank);
    done_.fetch_add(1, std::memory_order_seq_cst);
    done_.notify_one();
  }
}

}  // namespace mss
