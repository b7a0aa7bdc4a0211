#pragma once

#include <filesystem>
#include <istream>

namespace mss {

/// Cores' worth of time that the control groups of this process let it use; infinite without a quota.
double processor_quota();

/// The same of a process whose /proc/self/cgroup is `membership`, with control groups mounted at `root`:
/// the least of a group's and its ancestors', in files `cpu.max` (version 2) or `cpu.cfs_quota_us` and
/// `cpu.cfs_period_us` (version 1).
double processor_quota(std::istream& membership, const std::filesystem::path& root);

}  // namespace mss
