#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/communicator.hpp"

// Processes that mpirun, or another launcher, has started of this program.

namespace mss::cli {

/// Which of them this one is, and how many there are, by what the launcher left in the environment.
struct Launch {
  int rank = 0;
  int count = 1;
};
Launch launch();

/// Whether this process is to say what all of them would: the lowest says it at once, any other one after
/// five seconds, if it has not been told to end by then.
bool speaks_for_all();

/// Ranks that can reach each other.
class ConnectedCommunicator : public Communicator {
 public:
  /// To be called by all at the end of a run that has not failed, before the program ends.
  virtual void leave() {}
  /// Bytes of halos that each rank has sent so far, and the most memory that each has had. Collective.
  struct Costs {
    std::vector<std::int64_t> halo_bytes, peak_memory;
  };
  virtual Costs costs() const { return {}; }
  /// Halo exchanges so far.
  virtual std::int64_t exchanges() const { return 0; }
};

/// Connects the processes, as ranks. From then on this one works under the eyes of another one, see
/// work_under_guard(). Throws InputError in a program that was built without MPI, or with another one than
/// the launcher's. A process started alone is connected to none.
std::unique_ptr<ConnectedCommunicator> connect_ranks(const std::string& kept);

/// Splits the process in two: a guard, which does not return, and the worker, which does. The guard ends as
/// the worker does, hands it the first signal to end, and, where the worker was killed, says so and `kept`,
/// what is left of the work, and ends with exit_simulation_failed: the launcher, which sees the guard only,
/// then ends the other ranks and returns that as its status.
void work_under_guard(const std::string& kept);

/// In the worker: whether it should end, having been told to or having lost its guard.
bool told_to_end();

}  // namespace mss::cli
