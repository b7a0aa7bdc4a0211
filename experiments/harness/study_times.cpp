// How long studies take: the one place that says it. Wall times are those of meta.json (`wall_seconds`).
#include "experiments/harness/study_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mss {

const std::string_view study_times_machine = "an AMD EPYC";

const std::vector<StudyTime>& study_times() {
  static const std::vector<StudyTime> times{
      // study, --quick [s], full [s]
      {"timing", 40, 406},    {"precision", 30, 652}, {"energy", 10, 103},   {"convergence", 10, 37},
      {"stiffness", 20, 316}, {"frames", 20, 161},    {"regimes", 50, 1900}, {"validate", 10, 40},
      {"contact", 10, 41},    {"volume", 20, 190},    {"shape", 10, 102},    {"stability", 20, 235},
      {"atlas", 20, 519},     {"failures", 20, 281},  {"recovery", 30, 731}, {"refine", 20, 557},
      {"thesis", 20, 103},
  };
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
  return fmt::format("{} studies, about {} on two cores (measured on {}); {} about {}", studies_.size(),
                     expected_text(quick_), study_times_machine, quick_ ? "without --quick" : "with --quick",
                     expected_text(!quick_));
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
