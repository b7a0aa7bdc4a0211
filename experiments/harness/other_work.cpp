#include "experiments/harness/other_work.hpp"

#include <sched.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

namespace mss {

namespace {

/// user, nice, system, idle, iowait, irq, softirq, steal; guests' time, after these, is in the first two.
using Counters = std::array<double, 8>;

/// The numbers of a line; the last ones are 0 if a kernel does not have them.
std::optional<Counters> counters_in(std::string_view line) {
  constexpr std::size_t fewest = 4;
  Counters counters{};
  std::size_t found = 0;
  const char *at = line.data(), *end = line.data() + line.size();
  while (found < counters.size()) {
    while (at != end && *at == ' ') ++at;
    const auto [rest, error] = std::from_chars(at, end, counters.at(found));
    if (error != std::errc()) break;
    at = rest;
    ++found;
  }
  if (found < fewest) return std::nullopt;
  return counters;
}

void add(const Counters& c, CoreTicks& ticks) {
  const auto [user, nice, system, idle, waiting, irq, soft_irq, stolen] = c;
  const double busy = user + nice + system + irq + soft_irq;
  ticks.busy += busy;
  ticks.stolen += stolen;
  ticks.total += busy + stolen + idle + waiting;
}

std::vector<int> own_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cores;
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return cores;
  for (int core = 0; core < CPU_SETSIZE; ++core)
    if (CPU_ISSET(core, &set)) cores.push_back(core);
  return cores;
}

std::optional<CoreTicks> read_ticks(const std::vector<int>& cores) {
  std::ifstream stream("/proc/stat");
  return core_ticks(std::string(std::istreambuf_iterator<char>(stream), {}), cores);
}

/// Of this process and of those of its children that have been waited for.
double own_ticks() {
  constexpr double micro = 1e-6;
  double seconds = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    if (getrusage(who, &usage) != 0) continue;
    for (const timeval& time : {usage.ru_utime, usage.ru_stime})
      seconds += double(time.tv_sec) + micro * double(time.tv_usec);
  }
  return seconds * double(sysconf(_SC_CLK_TCK));
}

}  // namespace

std::optional<CoreTicks> core_ticks(std::string_view proc_stat, const std::vector<int>& cores) {
  CoreTicks all, chosen;
  bool has_all = false;
  while (!proc_stat.empty()) {
    const std::string_view line = proc_stat.substr(0, proc_stat.find('\n'));
    proc_stat.remove_prefix(std::min(proc_stat.size(), line.size() + 1));
    if (!line.starts_with("cpu")) continue;
    const std::string_view name = line.substr(0, line.find(' '));
    const std::optional<Counters> counters = counters_in(line.substr(name.size()));
    if (!counters) return std::nullopt;
    int core = -1;
    std::from_chars(name.data() + 3, name.data() + name.size(), core);
    if (core < 0) {
      add(*counters, all);
      has_all = true;
    } else if (std::find(cores.begin(), cores.end(), core) != cores.end()) {
      add(*counters, chosen);
    }
  }
  if (chosen.total > 0) return chosen;
  if (!has_all) return std::nullopt;
  return all;
}

std::optional<OtherWork> other_work(const CoreTicks& before, const CoreTicks& after, double own_ticks) {
  const double total = after.total - before.total;
  if (!(total > 0)) return std::nullopt;
  const double stolen = std::max(0.0, after.stolen - before.stolen);
  const double others = std::max(0.0, after.busy - before.busy - own_ticks);  // kernels count whole ticks
  return OtherWork{.share = std::min(1.0, (others + stolen) / total),
                   .stolen = std::min(1.0, stolen / total)};
}

OtherWorkWatch::OtherWorkWatch() : cores_(own_cores()), ticks_(read_ticks(cores_)), own_(own_ticks()) {}

std::optional<OtherWork> OtherWorkWatch::so_far() const {
  const std::optional<CoreTicks> now = read_ticks(cores_);
  if (!ticks_ || !now) return std::nullopt;
  return other_work(*ticks_, *now, own_ticks() - own_);
}

std::optional<OtherWork> other_work_now() {
  const OtherWorkWatch watch;
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  return watch.so_far();
}

std::optional<OtherWork> more_of(const std::optional<OtherWork>& a, const std::optional<OtherWork>& b) {
  if (!a || (b && b->share > a->share)) return b;
  return a;
}

Json to_json(const std::optional<OtherWork>& work) {
  if (!work) return nullptr;
  const auto rounded = [](double share) { return std::round(1e3 * share) / 1e3; };
  return {{"share", rounded(work->share)}, {"stolen", rounded(work->stolen)}};
}

std::optional<OtherWork> other_work_in(const Json& provenance) {
  const auto found = provenance.find("other_work");
  if (found == provenance.end() || !found->is_object()) return std::nullopt;
  return OtherWork{.share = found->at("share").get<double>(), .stolen = found->at("stolen").get<double>()};
}

}  // namespace mss
