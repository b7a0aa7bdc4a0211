#pragma once

#include <string>
#include <string_view>

namespace mss {

/// How a long computation reports its progress and checks whether it should stop. This default ignores
/// reports and never stops.
class Progress {
 public:
  Progress() = default;
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  virtual ~Progress() = default;

  /// `done` of the work, 0 to 1, is finished; `what` is being done now.
  virtual void report(double done, std::string_view what);

  /// True if the computation should return early with what it has.
  virtual bool stopped() const { return false; }
};

/// That of a part of a longer computation, from `begin` to `end` of the whole.
class PartProgress final : public Progress {
 public:
  PartProgress(Progress& whole, double begin, double end) : whole_(whole), begin_(begin), end_(end) {}
  void report(double done, std::string_view what) override {
    whole_.report(begin_ + done * (end_ - begin_), what);
  }
  bool stopped() const override { return whole_.stopped(); }

 private:
  Progress& whole_;
  double begin_, end_;
};

/// One line on stderr, rewritten in place, and only if that is a terminal; stopped() after Ctrl-C.
class TerminalProgress final : public Progress {
 public:
  explicit TerminalProgress(std::string task);
  ~TerminalProgress() override;  ///< clears the line

  void report(double done, std::string_view what) override;
  bool stopped() const override;

 private:
  std::string task_;
  bool shown_;
};

/// From now on the first SIGINT or SIGTERM only sets a flag; the second ends the program.
void watch_interrupts();

/// True after such a signal.
bool interrupted();

}  // namespace mss
