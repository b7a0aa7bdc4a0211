#include "experiments/simulation/non_sleeping_reference.hpp"

#include <algorithm>

#include "experiments/harness/measure.hpp"
#include "experiments/harness/statistics.hpp"

namespace mss {

namespace {

Scene without_sleep(Scene scene) {
  scene.solve.sleep = {};
  return scene;
}

template <class Real>
double largest_distance(const SceneRun<Real>& a, const SceneRun<Real>& b) {
  double most = 0;
  for (const std::ptrdiff_t site : a.system().particles())
    most = std::max(most, (a.state().x.at(site) - b.state().x.at(site)).norm());
  return most;
}

}  // namespace

template <class Real>
NonSleepingReference<Real>::NonSleepingReference(Scene scene, const Body& body)
    : run_(without_sleep(std::move(scene)), body) {}

template <class Real>
void NonSleepingReference<Real>::advance_and_compare(const SceneRun<Real>& sleeping, double t_end,
                                                     const Interval& interval) {
  Work work;
  Status status = Status::ok;
  const double seconds = seconds_of([&] { status = run_.advance(t_end, work); });
  if (status != Status::ok) return;
  if (work.steps > 0) awake_.push_back(seconds / double(work.steps));
  if (interval.asleep && interval.steps > 0) asleep_.push_back(interval.seconds / double(interval.steps));
  shares_ += sleeping.system().share_asleep();
  ++intervals_;
  report_.apart_at_end = largest_distance(sleeping, run_);
  report_.largest_deviation = std::max(report_.largest_deviation, report_.apart_at_end);
}

template <class Real>
SleepReport NonSleepingReference<Real>::report() const {
  SleepReport report = report_;
  if (intervals_ > 0) report.share = shares_ / double(intervals_);
  if (!asleep_.empty()) report.seconds_asleep = quantile(asleep_, 0.5);
  if (!awake_.empty()) report.seconds_awake = quantile(awake_, 0.5);
  return report;
}

template class NonSleepingReference<float>;
template class NonSleepingReference<double>;

}  // namespace mss
