#include "experiments/simulation/wakeful_twin.hpp"

#include <algorithm>
#include <chrono>

#include "experiments/harness/statistics.hpp"

namespace mss {

namespace {

Scene without_sleep(Scene scene) {
  scene.solve.sleep = {};
  return scene;
}

template <class Real>
double most_apart(const SceneRun<Real>& a, const SceneRun<Real>& b) {
  double most = 0;
  for (const std::ptrdiff_t site : a.system().particles())
    most = std::max(most, (a.state().x.at(site) - b.state().x.at(site)).norm());
  return most;
}

}  // namespace

template <class Real>
WakefulTwin<Real>::WakefulTwin(Scene scene, const Body& body) : run_(without_sleep(std::move(scene)), body) {}

template <class Real>
void WakefulTwin<Real>::follow(const SceneRun<Real>& sleeper, double t_end, const Lap& lap) {
  using Clock = std::chrono::steady_clock;
  Work work;
  const auto begin = Clock::now();
  if (run_.advance(t_end, work) != Status::ok) return;
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (work.steps > 0) awake_.push_back(seconds / double(work.steps));
  if (lap.asleep && lap.steps > 0) asleep_.push_back(lap.seconds / double(lap.steps));
  shares_ += sleeper.system().share_asleep();
  ++laps_;
  report_.apart_at_end = most_apart(sleeper, run_);
  report_.most_apart = std::max(report_.most_apart, report_.apart_at_end);
}

template <class Real>
SleepReport WakefulTwin<Real>::report() const {
  SleepReport report = report_;
  if (laps_ > 0) report.share = shares_ / double(laps_);
  if (!asleep_.empty()) report.seconds_asleep = quantile(asleep_, 0.5);
  if (!awake_.empty()) report.seconds_awake = quantile(awake_, 0.5);
  return report;
}

template class WakefulTwin<float>;
template class WakefulTwin<double>;

}  // namespace mss
