#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

namespace mss {

/// Cores that this process may use: of its affinity mask, and no more than its control group's quota of
/// processor time pays for.
int available_cores();

/// A counter that threads wait for. It is compared by difference, so that it may wrap.
class Counter {
 public:
  std::uint32_t value() const { return value_.load(std::memory_order_acquire); }
  bool reached(std::uint32_t target) const { return static_cast<std::int32_t>(value() - target) >= 0; }
  /// Replaces `expected` by `next`; false if it is something else.
  bool replace(std::uint32_t expected, std::uint32_t next) {
    return value_.compare_exchange_strong(expected, next, std::memory_order_acq_rel);
  }
  void announce(std::uint32_t value);
  /// Returns once `target` is reached: spins up to `spins` times, then sleeps.
  void wait(std::uint32_t target, int spins);
  /// The same without sleep; whether it is reached.
  bool spin(std::uint32_t target, int spins) const;

 private:
  std::atomic<std::uint32_t> value_{0};
  std::atomic<std::uint32_t> sleepers_{0};
};

/// Parts of a slab's step, one after the other. Slabs lie one above the other.
enum class SlabPart {
  inner,  ///< needs the slab alone
  edge,   ///< the slab above must have ended the step before
  seam    ///< the slab below must have ended its edge
};

/// Threads that share work and never wait for a core that is not there.
///
/// Work is divided into one slab a thread, and a slab's step into parts (SlabPart). The caller opens steps
/// and works on slab 0, helper r on slab r: each part is claimed by one compare-and-swap. What a helper has
/// not begun when the caller needs it, the caller does itself, so only a helper that loses its core in the
/// middle of a part is waited for. A long such wait is a strike: for ten times as long the caller works
/// alone, twice as long after the next strike, up to a second, until helpers have helped for four times as
/// long. Which thread does a part changes no bit.
class ThreadTeam {  // NOLINT(clang-analyzer-optin.performance.Padding): threads that wait share no line with
                    // others
 public:
  explicit ThreadTeam(int size);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int size() const { return size_; }

  /// Runs task(0) ... task(count - 1). Tasks must not throw.
  void for_each(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task);

  /// Whether the next step is the caller's alone: there is no helper, or one kept it waiting of late. If so,
  /// the step counts as done.
  bool works_alone();
  using SlabTask = std::function<void(int slab, SlabPart part, long step)>;
  /// Runs `steps` steps of size() slabs, from one to a few, so that works_alone() is asked between them.
  /// Tasks must not throw.
  void run_steps(long steps, const SlabTask& task);

  /// Threads that worked, on average over all steps so far.
  double threads_working() const;

 private:
  /// Parts are counted: four a step, the last of them none, so that the count may wrap.
  struct alignas(128) Slab {
    Counter claimed;
    std::uint32_t taken = 0;  ///< the last part that the caller did in a helper's place
    alignas(64) Counter done;
  };
  class BackOff;

  void help(int rank);
  void share(long steps, bool chained, const SlabTask& task);
  void reach(int slab, std::uint32_t target);
  void wait_for_helper(int slab, std::uint32_t target);
  double seconds_run(int slab);
  void perform(int slab, std::uint32_t part);

  int size_;
  int spins_;  ///< before a thread sleeps
  std::vector<Slab> slabs_;
  /// What parts helpers may take, and in the last bits whether slabs are chained.
  alignas(128) Counter open_;
  std::atomic<bool> stop_{false};
  alignas(128) const SlabTask* task_ = nullptr;
  std::uint32_t begin_ = 0, end_ = 0;  ///< of the steps that are open
  bool chained_ = false;               ///< whether parts wait for those of neighbouring slabs
  std::unique_ptr<BackOff> back_off_;
  std::int64_t taken_ = 0;               ///< in place of helpers, of the steps that are open
  std::int64_t steps_ = 0, helped_ = 0;  ///< steps so far, and parts of them that helpers did
  std::vector<std::thread> threads_;
};

}  // namespace mss
