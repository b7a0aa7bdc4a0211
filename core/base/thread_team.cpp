#include "core/base/thread_team.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <system_error>

#include "core/base/processor_quota.hpp"

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

namespace mss {

int available_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  static const double quota = processor_quota();
  const int cores = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set)
                                                                : int(std::thread::hardware_concurrency());
  return std::max(1, int(std::min(double(cores), quota)));
}

namespace {

void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// The processor's own clock, a third of the cost of the system's.
std::int64_t ticks() {
#if defined(__x86_64__)
  return std::int64_t(__rdtsc());
#else
  return std::chrono::steady_clock::now().time_since_epoch().count();
#endif
}

/// Of some 70 to 140 cycles each.
constexpr int spins_before_sleep = 400;  ///< 10 to 20 us: the next step of a small body has begun by then
constexpr int spins_for_helper = 25;     ///< about 1 us: a helper that runs has taken its next part by then

constexpr std::uint32_t parts_a_step = 4, last_part = 2;
constexpr std::int64_t parts_with_work = last_part + 1;

bool is_before(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) < 0; }
std::uint32_t step_of(std::uint32_t part) { return part & ~(parts_a_step - 1); }
std::uint32_t after(std::uint32_t part) {
  return part % parts_a_step == last_part ? step_of(part) + parts_a_step : part + 1;
}

}  // namespace

void Counter::announce(std::uint32_t value) {
  // Sequentially consistent: were sleepers counted before the value is visible, one would sleep for ever.
  value_.store(value, std::memory_order_seq_cst);
  if (sleepers_.load(std::memory_order_seq_cst) != 0) value_.notify_all();
}

bool Counter::spin(std::uint32_t target, int spins) const {
  for (int i = 0; i < spins; ++i) {
    if (reached(target)) return true;
    relax();
  }
  return reached(target);
}

void Counter::wait(std::uint32_t target, int spins) {
  if (spin(target, spins)) return;
  sleepers_.fetch_add(1, std::memory_order_seq_cst);
  for (;;) {
    const std::uint32_t seen = value_.load(std::memory_order_seq_cst);
    if (reached(target)) break;
    value_.wait(seen, std::memory_order_acquire);
  }
  sleepers_.fetch_sub(1, std::memory_order_relaxed);
}

/// When the caller works alone.
class ThreadTeam::BackOff {
 public:
  bool is_alone() {
    if (until_ == 0) return false;
    const std::int64_t left = until_ - ticks();
    if (left > 0 && left <= length_) return true;  // more: the clock went back
    until_ = 0;
    return false;
  }

  /// `helped`: whether a helper did its share of the step before, in the same call.
  void begin_step(bool helped) {
    const std::int64_t now = ticks();
    if (helped) helped_for_ += now - began_;
    began_ = now;
  }

  /// After the last one; `absent`: whether no helper did any part of all steps since `since`.
  void end_steps(std::int64_t since, bool helped, bool absent) {
    const std::int64_t now = ticks();
    if (helped) helped_for_ += now - began_;
    if (!absent) {
      absent_for_ = absence_ = 0;
      return;
    }
    absent_for_ += now - since;
    const double second = ticks_a_second(now);
    if (double(absent_for_) < 200e-6 * second) return;
    absent_for_ = 0;
    absence_ = std::clamp(2 * absence_, std::int64_t(1e-3 * second), std::int64_t(16e-3 * second));
    stay_alone(now, absence_);
  }

  std::int64_t begun() const { return began_; }

  /// After a wait from `since` on, of which the helper ran for `seconds`: whether it was a strike. The rest
  /// is then longer than the caller's own part of the step, and than it takes to wake a thread.
  bool strikes(std::int64_t since, double seconds) {
    constexpr double least = 300e-6, longest = 1;
    const std::int64_t now = ticks();
    const double second = ticks_a_second(now);
    const auto stall = now - since - std::int64_t(seconds * second);
    if (double(stall) < least * second || stall < since - began_) return false;
    strike_ = helped_for_ > 4 * strike_ ? 10 * stall : std::max(2 * strike_, 10 * stall);
    strike_ = std::min(strike_, std::int64_t(longest * second));
    helped_for_ = 0;
    stay_alone(now, strike_);
    return true;
  }

 private:
  void stay_alone(std::int64_t now, std::int64_t length) {
    until_ = std::max(until_, now + length);
    length_ = until_ - now;
  }
  double ticks_a_second(std::int64_t now) const {
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - made_;
    return double(now - made_at_) / since.count();
  }

  std::chrono::steady_clock::time_point made_ = std::chrono::steady_clock::now();
  std::int64_t made_at_ = ticks();
  std::int64_t began_ = 0;                     ///< the step
  std::int64_t until_ = 0, length_ = 0;        ///< the time alone
  std::int64_t strike_ = 0, helped_for_ = 0;   ///< that after the last strike; steps with help since then
  std::int64_t absence_ = 0, absent_for_ = 0;  ///< the last one without a strike; steps before the next
};

ThreadTeam::ThreadTeam(int size)
    : size_(std::max(1, size)),
      spins_(size_ > 1 && size_ <= available_cores() ? spins_before_sleep : 0),
      slabs_(std::size_t(size_)),
      back_off_(std::make_unique<BackOff>()) {
  try {
    for (int rank = 1; rank < size_; ++rank) threads_.emplace_back([this, rank] { help(rank); });
  } catch (const std::system_error&) {
    // No more threads to be had: the caller does what they would have done.
  }
}

ThreadTeam::~ThreadTeam() {
  stop_.store(true, std::memory_order_release);
  open_.announce(end_ + last_part);  // wakes helpers, and opens no part
  for (std::thread& thread : threads_) thread.join();
}

bool ThreadTeam::works_alone() {
  if (size_ > 1 && !back_off_->is_alone()) return false;
  ++steps_;
  return true;
}

void ThreadTeam::for_each(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
  if (count < 2 || works_alone()) {
    for (std::ptrdiff_t i = 0; i < count; ++i) task(i);
    return;
  }
  const auto third = [&](int slab, SlabPart part, long) {
    const std::ptrdiff_t first = count * slab / size_, length = count * (slab + 1) / size_ - first;
    const std::ptrdiff_t last = first + length * (int(part) + 1) / 3;
    for (std::ptrdiff_t i = first + length * int(part) / 3; i < last; ++i) task(i);
  };
  share(1, false, std::ref(third));
}

void ThreadTeam::run_steps(long steps, const SlabTask& task) { share(steps, true, task); }

double ThreadTeam::threads_working() const {
  return steps_ == 0 ? size_ : 1 + double(helped_) / double(steps_ * parts_with_work);
}

void ThreadTeam::share(long steps, bool chained, const SlabTask& task) {
  begin_ = end_;
  end_ = begin_ + parts_a_step * std::uint32_t(steps);
  chained_ = chained;
  task_ = &task;
  open_.announce(end_ + (chained ? 0 : 1));
  taken_ = 0;
  bool helped = false;
  std::int64_t since = 0;
  for (long step = 0; step < steps; ++step) {
    back_off_->begin_step(helped);
    if (step == 0) since = back_off_->begun();
    const std::int64_t taken = taken_;
    reach(0, begin_ + parts_a_step * std::uint32_t(step + 1));
    helped = taken == taken_;
  }
  for (int slab = 1; slab < size_; ++slab) reach(slab, end_);
  const std::int64_t offered = steps * (size_ - 1) * parts_with_work;
  back_off_->end_steps(since, helped, taken_ == offered);
  steps_ += steps;
  helped_ += offered - taken_;
}

/// Sees to it that a slab's parts before `target` are done.
void ThreadTeam::reach(int s, std::uint32_t target) {
  Slab& slab = slabs_[std::size_t(s)];
  for (;;) {
    const std::uint32_t part = slab.done.value();  // once: helpers go on meanwhile
    if (!is_before(part, target)) return;
    const bool helper_runs = part - slab.taken > parts_a_step;
    if (s > 0 && helper_runs && slab.done.spin(after(part), spins_for_helper)) continue;
    if (chained_) {
      if (part % parts_a_step == 1 && s + 1 < size_) reach(s + 1, step_of(part));
      if (part % parts_a_step == 2 && s > 0) reach(s - 1, step_of(part) + 2);
    }
    if (s == 0 || slab.claimed.replace(part, after(part))) {
      if (s > 0) ++taken_, slab.taken = part;
      perform(s, part);
    } else {
      wait_for_helper(s, after(part));
    }
  }
}

/// Processor time of the helper of a slab [s].
double ThreadTeam::seconds_run(int slab) {
  clockid_t clock{};
  timespec time{};
  if (pthread_getcpuclockid(threads_[std::size_t(slab) - 1].native_handle(), &clock) != 0 ||
      clock_gettime(clock, &time) != 0)
    return 0;
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

/// For a part that the helper of a slab has begun. While it runs, waiting is no strike: parts may be unequal.
void ThreadTeam::wait_for_helper(int slab, std::uint32_t target) {
  Counter& done = slabs_[std::size_t(slab)].done;
  if (done.spin(target, spins_)) return;
  const std::int64_t since = ticks();
  const double before = seconds_run(slab);
  done.wait(target, 0);
  if (back_off_->strikes(since, seconds_run(slab) - before))
    open_.announce(begin_);  // helpers take no further parts
}

void ThreadTeam::perform(int slab, std::uint32_t part) {
  (*task_)(slab, SlabPart(part % parts_a_step), long((part - begin_) / parts_a_step));
  slabs_[std::size_t(slab)].done.announce(after(part));
}

void ThreadTeam::help(int rank) {
  Slab& own = slabs_[std::size_t(rank)];
  while (!stop_.load(std::memory_order_acquire)) {
    const std::uint32_t part = own.done.value(), open = open_.value();
    if (!is_before(part, step_of(open))) {
      open_.wait(part + 2, spins_);
      continue;
    }
    if (open % parts_a_step == 0) {  // chained
      if (part % parts_a_step == 1 && rank + 1 < size_)
        slabs_[std::size_t(rank) + 1].done.wait(step_of(part), spins_);
      if (part % parts_a_step == 2) slabs_[std::size_t(rank) - 1].done.wait(step_of(part) + 2, spins_);
    }
    if (own.claimed.replace(part, after(part)))
      perform(rank, part);
    else
      own.done.wait(after(part), spins_);
  }
}

}  // namespace mss
