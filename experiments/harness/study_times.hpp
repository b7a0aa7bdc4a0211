#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mss {

/// How long a study takes by `mss reproduce` on two cores.
struct StudyTime {
  std::string study;    ///< name
  double quick = 0;     ///< [s] with --quick
  double full = 0;      ///< [s]
  std::string machine;  ///< processor that it was measured on
};

/// A table as results/run.sh writes it: study, quick [s], full [s], machine. Empty if there is no such file;
/// throws as Table::read().
std::vector<StudyTime> read_study_times(const std::filesystem::path& file);

/// The times that come with the program.
const std::vector<StudyTime>& study_times();

/// Seconds that a study is expected to take; 0 if it has not been measured.
double expected_seconds(std::string_view study, bool quick);

/// A duration in words, as exact as is of use: "12 s", "7 min", "1 h 52 min".
std::string duration_text(double seconds);

/// The time of studies that run one after the other: said before, and estimated again after each.
class StudyClock {
 public:
  StudyClock(std::vector<std::string> studies, bool quick);

  /// How many studies, and how long they will take, with --quick and without.
  std::string announcement() const;

  /// How long they take with --quick and without, for its help: ": about ...".
  std::string comparison() const;

  /// The next of the studies is finished, after `seconds`. Returns how far the whole is; the rest is assumed
  /// to differ from the measured times as the finished studies did.
  std::string finished(double seconds);

 private:
  /// [s] of the studies from `first` to `end`, exclusive.
  double expected(std::size_t first, std::size_t end, bool quick) const;
  std::string expected_text(bool quick) const;  ///< of all

  std::vector<std::string> studies_;
  bool quick_;
  std::size_t done_ = 0;
  double elapsed_ = 0;  ///< [s] of the studies that are done
};

}  // namespace mss
