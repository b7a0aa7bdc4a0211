#include "core/base/processor_quota.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

namespace mss {

namespace fs = std::filesystem;

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// Of one group; `max` and -1 stand for none.
double quota_of(const fs::path& group) {
  double quota = 0, period = 0;
  if (std::ifstream file(group / "cpu.max"); file >> quota >> period && quota > 0 && period > 0)
    return quota / period;
  std::ifstream quota_file(group / "cpu.cfs_quota_us"), period_file(group / "cpu.cfs_period_us");
  if (quota_file >> quota && period_file >> period && quota > 0 && period > 0) return quota / period;
  return unlimited;
}

/// Of a group and its ancestors. In a container the path may be the host's, of which only the root is there.
double least_quota(const fs::path& root, const std::string& path) {
  double least = quota_of(root);
  fs::path group = root;
  for (const fs::path& name : fs::path(path).relative_path())
    least = std::min(least, quota_of(group /= name));
  return least;
}

}  // namespace

double processor_quota(std::istream& membership, const fs::path& root) {
  double least = unlimited;
  std::string line;
  while (std::getline(membership, line)) {  // hierarchy:controllers:path
    std::istringstream fields(line);
    std::string hierarchy, controllers, path;
    if (!std::getline(fields, hierarchy, ':') || !std::getline(fields, controllers, ':') ||
        !std::getline(fields, path))
      continue;
    if (controllers.empty())
      least = std::min(least, least_quota(root, path));
    else if (("," + controllers + ",").find(",cpu,") != std::string::npos)
      least = std::min({least, least_quota(root / controllers, path), least_quota(root / "cpu", path)});
  }
  return least;
}

double processor_quota() {
  std::ifstream membership("/proc/self/cgroup");
  return processor_quota(membership, "/sys/fs/cgroup");
}

}  // namespace mss
