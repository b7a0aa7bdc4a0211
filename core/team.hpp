#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

namespace mss {

/// Cores this process may use (its affinity mask, not the machine's size).
int available_cores();

/// Counts steps or rounds; compared by difference, so that it may wrap.
using Counter = std::atomic<std::uint32_t>;

/// Blocks until `value` has reached `target`. Spins for a few microseconds, because a neighbour's slab is
/// usually about to finish, then sleeps, so that other processes can use the core.
void wait_until_reached(const Counter& value, std::uint32_t target, bool may_spin);

/// Sets a counter that others may wait for. It must be sequentially consistent: notifying checks for
/// waiters, and if it did so before the new value is visible, a waiter would sleep for ever.
void announce(Counter& value, std::uint32_t reached);

/// Threads that persist between steps. The caller is rank 0, so a team of one starts no thread.
class Team {
 public:
  explicit Team(int size);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int size() const { return size_; }

  /// More threads than cores: waiting threads must yield their core at once.
  bool may_spin() const { return may_spin_; }

  /// Runs task(rank) on every rank and returns when all have returned. Tasks must not throw.
  void run(const std::function<void(int)>& task);

  /// Runs task(0) ... task(count - 1), each rank a range of them. Tasks must not throw.
  void for_each(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task);

 private:
  void work(int rank);

  int size_;
  bool may_spin_;
  const std::function<void(int)>* task_ = nullptr;
  Counter round_{0};  ///< tasks started so far
  std::atomic<bool> stop_{false};
  Counter done_{0};  ///< ranks that have finished the current one
  std::vector<std::thread> threads_;
};

}  // namespace mss
