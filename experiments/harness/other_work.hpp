#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "experiments/harness/json.hpp"

// How much of the cores goes to other work than this process's. The load average cannot tell: it decays over
// a minute, so that a run finds there what the one before it left behind, and it counts this process too.

namespace mss {

/// What a kernel counts of some cores since it started, in its ticks.
struct CoreTicks {
  double busy = 0;    ///< of processes and of the kernel
  double stolen = 0;  ///< given to other guests by the host of a virtual machine
  double total = 0;   ///< idle ones too
};

/// The sum over cores in the text of /proc/stat; over all if none of them is there. Nothing if the text is
/// not understood.
std::optional<CoreTicks> core_ticks(std::string_view proc_stat, const std::vector<int>& cores);

/// Shares of the time of all cores, 0 to 1.
struct OtherWork {
  double share = 0;  ///< of other processes, of the kernel for them, and of other guests of a virtual machine
  double stolen = 0;  ///< of it, that of other guests
};

/// Between two readings, in which this process and its children took so many ticks. Nothing if no time passed
/// between them.
std::optional<OtherWork> other_work(const CoreTicks& before, const CoreTicks& after, double own_ticks);

/// From this share on, times are said to be disturbed: well above what a system does by itself. One process
/// that keeps a core busy is as much on ten cores, and on more of them goes unsaid.
inline constexpr double disturbing_share = 0.1;

/// Watches the cores that this process may run on, since it was made.
class OtherWorkWatch {
 public:
  OtherWorkWatch();
  /// Nothing where the system has no /proc/stat. Children count as this process once they have been waited
  /// for.
  std::optional<OtherWork> so_far() const;

 private:
  std::vector<int> cores_;
  std::optional<CoreTicks> ticks_;
  double own_;
};

/// During the next fifth of a second, in which this process sleeps.
std::optional<OtherWork> other_work_now();

/// What took the larger share; one that is not known counts as none.
std::optional<OtherWork> more_of(const std::optional<OtherWork>& a, const std::optional<OtherWork>& b);

/// As {"share": 0.31, "stolen": 0.02}, as provenances have it under "other_work"; null if it is not known.
Json to_json(const std::optional<OtherWork>& work);
/// From a provenance. Nothing if it has none, as in results of earlier versions.
std::optional<OtherWork> other_work_in(const Json& provenance);

}  // namespace mss
