#include "tests/fuzz/workers.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <ctime>
#include <new>
#include <span>
#include <stdexcept>
#include <thread>

#include "experiments/io/output.hpp"
#include "tests/fuzz/memory.hpp"

namespace mss::fuzz {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t inputs_per_process = 2000;  ///< then a new one, so that leaks do not add up

double seconds_on(clockid_t clock) {
  timespec t{};
  if (clock_gettime(clock, &t) != 0) return 0;
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// What a process tells its parent, in memory that both see.
struct Slot {
  std::atomic<std::uint64_t> index{0};
  std::atomic<double> since{0};  ///< its processor time when it began this input [s]
  Extreme bytes, seconds;
};

/// Memory that this process and its children share.
template <class T>
class SharedArray {
 public:
  explicit SharedArray(std::size_t count) : count_(count) {
    void* memory = mmap(nullptr, bytes(), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory to share between processes");
    items_ = new (memory) T[count];
  }
  SharedArray(const SharedArray&) = delete;
  SharedArray& operator=(const SharedArray&) = delete;
  ~SharedArray() { munmap(items_, bytes()); }
  T& operator[](std::size_t i) { return items_[i]; }
  std::span<T> all() { return {items_, count_}; }

 private:
  std::size_t bytes() const { return std::max<std::size_t>(count_ * sizeof(T), 1); }
  std::size_t count_;
  T* items_ = nullptr;
};

class Workers {
 public:
  using Run = std::function<Ending(std::uint64_t, const fs::path&)>;

  Workers(const Campaign& campaign, const Run& run)
      : campaign_(campaign),
        run_(run),
        next_(campaign.first),
        endings_(campaign.end - campaign.first),
        slots_(std::size_t(campaign.processes)),
        processes_(std::size_t(campaign.processes)),
        folders_(std::size_t(campaign.processes)) {
    std::fill(endings_.all().begin(), endings_.all().end(), Ending::not_run);
  }

  const std::vector<TemporaryDirectory>& folders() const { return folders_; }

  /// Starts processes that are due, and looks after those that run. False: all is done.
  bool attend() {
    bool busy = false;
    for (std::size_t p = 0; p < processes_.size(); ++p) {
      if (processes_[p].pid > 0) watch(p);
      if (processes_[p].pid == 0) start(p);
      busy = busy || processes_[p].pid > 0;
    }
    return busy;
  }

  std::uint64_t done() {
    std::uint64_t running = 0;
    for (std::size_t p = 0; p < processes_.size(); ++p)
      if (processes_[p].pid > 0) running += processes_[p].end - slots_[p].index;
    return next_ - campaign_.first - running;
  }

  CampaignResult result() {
    CampaignResult result{
        .endings = {endings_.all().begin(), endings_.all().end()}, .bytes = {}, .seconds = {}};
    for (const Slot& slot : slots_.all()) {
      if (slot.bytes.value > result.bytes.value) result.bytes = slot.bytes;
      if (slot.seconds.value > result.seconds.value) result.seconds = slot.seconds;
    }
    return result;
  }

 private:
  struct Process {
    pid_t pid = 0;
    std::uint64_t begin = 0, end = 0;  ///< inputs left to it
  };

  void start(std::size_t p) {
    Process& process = processes_[p];
    if (process.begin == process.end) {
      process.begin = next_;
      process.end = next_ = std::min(next_ + inputs_per_process, campaign_.end);
    }
    if (process.begin == process.end) return;
    slots_[p].index = process.begin;
    slots_[p].since = 0;
    process.pid = fork();
    if (process.pid < 0) throw std::runtime_error("no further process can be started");
    if (process.pid > 0) return;
    work(p);
    std::exit(0);  // with the checks of sanitizers
  }

  void work(std::size_t p) {
    Slot& slot = slots_[p];
    limit_memory(campaign_.most_memory);
    for (std::uint64_t i = processes_[p].begin; i < processes_[p].end; ++i) {
      const double since = seconds_on(CLOCK_PROCESS_CPUTIME_ID);
      slot.since = since;
      slot.index = i;
      reset_peak();
      const Ending ending = run_(i, folders_[p].path());
      const double seconds = seconds_on(CLOCK_PROCESS_CPUTIME_ID) - since;
      if (seconds > slot.seconds.value) slot.seconds = {seconds, i};
      if (double(peak_bytes()) > slot.bytes.value) slot.bytes = {double(peak_bytes()), i};
      endings_[i - campaign_.first] = ending;
    }
    slot.index = processes_[p].end;
  }

  void watch(std::size_t p) {
    Process& process = processes_[p];
    clockid_t clock{};
    const bool hangs = clock_getcpuclockid(process.pid, &clock) == 0 &&
                       seconds_on(clock) - slots_[p].since > campaign_.most_seconds;
    if (hangs) kill(process.pid, SIGKILL);
    int status = 0;
    if (waitpid(process.pid, &status, hangs ? 0 : WNOHANG) == 0) return;
    const std::uint64_t index = slots_[p].index;
    const bool finished = WIFEXITED(status) && WEXITSTATUS(status) == 0 && index == process.end;
    process.pid = 0;
    process.begin = finished ? process.end : std::min(index + 1, process.end);
    if (finished) return;
    // sanitizers that find leaks at the end blame the last input
    const std::uint64_t blamed = std::min(index, process.end - 1);
    endings_[blamed - campaign_.first] = hangs ? Ending::hang : Ending::crash;
    fmt::print(stderr, "input {}: {}\n", blamed, hangs ? "hang" : "crash");
  }

  const Campaign& campaign_;
  const Run& run_;
  std::uint64_t next_;
  SharedArray<Ending> endings_;
  SharedArray<Slot> slots_;
  std::vector<Process> processes_;
  std::vector<TemporaryDirectory> folders_;
};

}  // namespace

CampaignResult run_campaign(const Campaign& campaign, const std::function<void(const fs::path&)>& prepare,
                            const std::function<Ending(std::uint64_t, const fs::path&)>& run,
                            const std::function<void(std::uint64_t)>& report) {
  Workers workers(campaign, run);
  for (const TemporaryDirectory& folder : workers.folders()) prepare(folder.path());
  auto last = std::chrono::steady_clock::now();
  while (workers.attend()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (std::chrono::steady_clock::now() - last < std::chrono::seconds(10)) continue;
    last = std::chrono::steady_clock::now();
    report(workers.done());
  }
  return workers.result();
}

}  // namespace mss::fuzz
