// How long studies take: measured by results/run.sh, in results/reproduce/study_times.csv.
#include "experiments/harness/study_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/harness/table.hpp"
#include "experiments/io/installation.hpp"
#include "experiments/io/output.hpp"

namespace mss {

std::vector<StudyTime> read_study_times(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return {};
  const Table table = Table::read(read_file(file), file.string());
  std::vector<StudyTime> times;
  for (std::size_t r = 0; r < table.size(); ++r)
    times.push_back({table.text(r, "study"), table.number(r, "quick"), table.number(r, "full"),
                     table.text(r, "machine")});
  return times;
}

const std::vector<StudyTime>& study_times() {
  static const std::vector<StudyTime> times =
      read_study_times(shipped_files() / "results" / "reproduce" / "study_times.csv");
  return times;
}

double expected_seconds(std::string_view study, bool quick) {
  for (const StudyTime& time : study_times())
    if (time.study == study) return quick ? time.quick : time.full;
  return 0;
}

std::string duration_text(double seconds) {
  if (seconds < 99.5) return fmt::format("{:.0f} s", seconds);
  const long minutes = std::lround(seconds / 60);
  if (minutes < 100) return fmt::format("{} min", minutes);
  return fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

StudyClock::StudyClock(std::vector<std::string> studies, bool quick)
    : studies_(std::move(studies)), quick_(quick) {}

double StudyClock::expected(std::size_t first, std::size_t end, bool quick) const {
  double sum = 0;
  for (std::size_t i = first; i < end; ++i) sum += expected_seconds(studies_[i], quick);
  return sum;
}

std::string StudyClock::expected_text(bool quick) const {
  return duration_text(expected(0, studies_.size(), quick));
}

std::string StudyClock::announcement() const {
  if (expected(0, studies_.size(), quick_) == 0) return fmt::format("{} studies", studies_.size());
  return fmt::format("{} studies, about {} on two cores (measured on {}); {} about {}", studies_.size(),
                     expected_text(quick_), study_times().front().machine,
                     quick_ ? "without --quick" : "with --quick", expected_text(!quick_));
}

std::string StudyClock::comparison() const {
  if (expected(0, studies_.size(), true) == 0) return {};
  return fmt::format(": about {} on two cores instead of {}", expected_text(true), expected_text(false));
}

std::string StudyClock::finished(double seconds) {
  ++done_;
  elapsed_ += seconds;
  const double before = expected(0, done_, quick_), rest = expected(done_, studies_.size(), quick_);
  std::string text = fmt::format("{} of {} done in {}", done_, studies_.size(), duration_text(elapsed_));
  if (done_ < studies_.size())
    text += fmt::format(", about {} left", duration_text(before > 0 ? rest * elapsed_ / before : rest));
  return text;
}

}  // namespace mss
