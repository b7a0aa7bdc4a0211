// Cases over processes: workers are forked, take the next case from a shared counter, and write a line of
// JSON for each to a pipe of their own; only the caller writes the journal.
#include "experiments/harness/workers.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/base/thread_team.hpp"

namespace mss {

namespace {

/// A counter shared with all processes that are forked while it exists.
class SharedCounter {
 public:
  SharedCounter() {
    void* memory = mmap(nullptr, sizeof(std::atomic<std::size_t>), PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    value_ = new (memory) std::atomic<std::size_t>(0);
  }
  SharedCounter(const SharedCounter&) = delete;
  SharedCounter& operator=(const SharedCounter&) = delete;
  ~SharedCounter() { munmap(value_, sizeof(std::atomic<std::size_t>)); }
  std::size_t next() { return value_->fetch_add(1); }

 private:
  std::atomic<std::size_t>* value_;
};

/// A forked process and what has been read from it.
struct Worker {
  pid_t process = 0;
  int pipe = -1;  ///< -1: closed, all has been read
  std::string unread{};
};

bool write_all(int pipe, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = write(pipe, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    text.remove_prefix(std::size_t(n));
  }
  return true;
}

/// The main loop of a worker. An exception that escapes ends the process, which its parent detects.
// NOLINTNEXTLINE(bugprone-exception-escape): intended, see above
void work_through(int pipe, const std::vector<const Case*>& cases, SharedCounter& counter) noexcept {
  for (std::size_t i = counter.next(); i < cases.size(); i = counter.next()) {
    Json line{{"case", i}};
    try {
      line["result"] = cases[i]->compute();
    } catch (const InputError& error) {
      line["refused"] = error.what();
    } catch (const std::exception& error) {
      line["error"] = error.what();
    }
    if (!write_all(pipe, line.dump() + "\n") || !line.contains("result")) return;
  }
}

/// Forked processes; the destructor kills those that still run.
class Workers {
 public:
  Workers(int processes, const std::vector<const Case*>& cases) {
    try {
      for (int i = 0; i < processes; ++i) start(cases);
    } catch (...) {
      kill_all();
      throw;
    }
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  ~Workers() { kill_all(); }

  /// Waits at most 200 ms for lines and passes them to `take`. False once all workers have finished.
  template <class Take>
  bool read_lines(Take&& take) {
    constexpr int timeout = 200;  // [ms], so that the caller can check for an interruption
    std::vector<pollfd> open;
    for (const Worker& worker : workers_)
      if (worker.pipe >= 0) open.push_back({.fd = worker.pipe, .events = POLLIN, .revents = 0});
    if (open.empty()) return false;
    if (poll(open.data(), open.size(), timeout) <= 0) return true;
    for (const pollfd& ready : open)
      if (ready.revents != 0)
        read_from(*std::find_if(workers_.begin(), workers_.end(),
                                [&](const Worker& worker) { return worker.pipe == ready.fd; }),
                  take);
    return true;
  }

 private:
  void kill_all() {
    for (const Worker& worker : workers_) {
      if (worker.pipe < 0) continue;
      kill(worker.process, SIGKILL);
      close(worker.pipe);
      waitpid(worker.process, nullptr, 0);
    }
  }

  [[noreturn]] static void throw_no_process() {
    throw InputError(fmt::format("not all processes can be started ({}); choose fewer with --processes",
                                 std::strerror(errno)));
  }

  void start(const std::vector<const Case*>& cases) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw_no_process();
    const pid_t process = fork();
    if (process < 0) {
      close(ends[0]);
      close(ends[1]);
      throw_no_process();
    }
    if (process == 0) {
      for (const Worker& other : workers_) close(other.pipe);
      close(ends[0]);
      work_through(ends[1], cases, counter_);
      _exit(0);
    }
    close(ends[1]);
    workers_.push_back({.process = process, .pipe = ends[0]});
  }

  template <class Take>
  void read_from(Worker& worker, Take& take) {
    std::array<char, 4096> buffer{};
    const ssize_t n = read(worker.pipe, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) return;
    if (n <= 0) return finish(worker);
    worker.unread.append(buffer.data(), std::size_t(n));
    for (std::size_t end = 0; (end = worker.unread.find('\n')) != std::string::npos;) {
      take(Json::parse(worker.unread.substr(0, end)));
      worker.unread.erase(0, end + 1);
    }
  }

  static void finish(Worker& worker) {
    close(worker.pipe);
    worker.pipe = -1;
    int status = 0;
    waitpid(worker.process, &status, 0);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
      throw std::runtime_error(WIFSIGNALED(status)
                                   ? fmt::format("a worker process was ended by signal {}", WTERMSIG(status))
                                   : "a worker process ended early");
  }

  SharedCounter counter_;
  std::vector<Worker> workers_;
};

}  // namespace

std::vector<Case> own_cases(std::vector<Case> cases, const Journal& journal) {
  std::erase_if(cases, [&](const Case& c) { return !journal.part().has(c.group); });
  return cases;
}

bool compute_cases(const std::vector<Case>& cases, int processes, Journal& journal, Progress& progress) {
  std::vector<const Case*> open;
  for (const Case& c : cases)
    if (journal.find(c.name) == nullptr) open.push_back(&c);
  if (open.empty()) return !progress.stopped();
  std::size_t done = 0;
  const auto take = [&](const Json& line) {
    const std::string& name = open[line["case"].get<std::size_t>()]->name;
    if (line.contains("refused"))
      throw InputError(fmt::format("{}: {}", name, line["refused"].get<std::string>()));
    if (line.contains("error"))
      throw std::runtime_error(fmt::format("{}: {}", name, line["error"].get<std::string>()));
    journal.add(name, line["result"]);
    progress.report(double(++done) / double(open.size()), name);
  };
  const int requested = processes > 0 ? processes : available_cores();
  Workers workers(std::min(requested, int(open.size())), open);
  while (!progress.stopped())
    if (!workers.read_lines(take)) {
      if (done < open.size()) throw std::runtime_error("processes ended before all cases were computed");
      return true;
    }
  return false;
}

Status gather_cases(const std::vector<Case>& cases, int processes, Journal& journal, Progress& progress,
                    const std::function<void(const Json&)>& use) {
  const bool done = compute_cases(own_cases(cases, journal), processes, journal, progress);
  for (const Case& one : cases)
    if (const Json* result = journal.find(one.name)) use(*result);
  return done ? Status::ok : Status::interrupted;
}

}  // namespace mss
