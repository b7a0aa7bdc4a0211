#include "core/refinement/local_step_plan.hpp"

#include <algorithm>
#include <cmath>

namespace mss {

namespace {

constexpr double least_nu = 0.01;     ///< delta = 1 + nu / p^2
constexpr double most_damping = 0.4;  ///< over a step
/// What a particle's update costs in a plan with short steps, over one in plain steps: 1.3 to 1.7 under a
/// patch's load; one ragged map of `mss refine` has more, and loses by its plan.
constexpr double cost_in_short_steps = 1.5;

/// What keeps a damped mode at the edge of the range stable: 4 - omega^2 dt^2 >= 2 c dt.
double nu_of(double damping, double dt) {
  const double share = damping * dt;
  return std::max(least_nu, 1.2 * share / (1 - share));
}

/// The largest stable step without local ones.
double largest_step(const SpectralBound& bound) {
  return 4 / (bound.damping + std::hypot(bound.damping, 2 * bound.omega));
}

class Planner {
 public:
  explicit Planner(const std::vector<LevelCost>& levels) : levels_(levels) {
    for (const LevelCost& level : levels) damping_ = std::max(damping_, level.bound.damping);
  }

  LocalStepPlan best() const {
    LocalStepPlan best;
    double least = 0;
    const std::size_t boundaries = levels_.size() - 1;
    for (std::size_t choice = 0; choice < std::size_t(1) << boundaries; ++choice) {
      std::vector<LocalRate> rates;
      std::size_t slower = 0;
      bool possible = true;
      for (std::size_t level = 1; level <= boundaries; ++level) {
        if ((choice >> (level - 1) & 1U) == 0) continue;
        possible =
            possible && levels_[level].depth == levels_[level - 1].depth + 1;  // else they do not touch
        rates.push_back({level, 0});
        slower = level;
      }
      if (!possible) continue;
      set_substeps(rates);
      const double step = stable_step(rates),
                   cost = (rates.empty() ? 1 : cost_in_short_steps) * work(rates) / step;
      if (slower > 0 && cost >= least) continue;
      least = cost;
      best = {std::move(rates), step};
    }
    return best;
  }

 private:
  std::size_t end_of(const std::vector<LocalRate>& rates, std::size_t r) const {
    return r + 1 < rates.size() ? rates[r + 1].first_level : levels_.size();
  }
  /// Bound of levels [first, last).
  double omega(std::size_t first, std::size_t last) const {
    double most = 0;
    for (std::size_t level = first; level < last; ++level) most = std::max(most, levels_[level].bound.omega);
    return most;
  }
  void set_substeps(std::vector<LocalRate>& rates) const {
    for (std::size_t r = 0; r < rates.size(); ++r)
      rates[r].substeps =
          1 << (levels_[end_of(rates, r) - 1].depth - levels_[rates[r].first_level - 1].depth);
  }

  double stable_step(const std::vector<LocalRate>& rates) const {
    const std::size_t slow = rates.empty() ? levels_.size() : rates.front().first_level;
    double dt = largest_step({omega(0, slow), damping_});
    while (!is_stable(rates, dt)) dt *= 0.995;
    return dt;
  }

  bool is_stable(const std::vector<LocalRate>& rates, double dt) const {
    if (rates.empty()) return true;
    if (damping_ * dt > most_damping) return false;
    const std::vector<ChebyshevFilter> filters = filters_of(rates, damping_, dt);
    if (filters.empty()) return false;
    double step = dt;
    for (std::size_t r = 0; r < rates.size(); ++r) {
      const double share = omega(rates[r].first_level, end_of(rates, r)) * step;
      if (share * share > filters[r].range()) return false;
      step /= rates[r].substeps;
    }
    return true;
  }

  /// Particles' updates in a step.
  double work(const std::vector<LocalRate>& rates) const {
    double sum = 0, updates = 1;
    std::size_t r = 0;
    for (std::size_t level = 0; level < levels_.size(); ++level) {
      if (r < rates.size() && rates[r].first_level == level) updates *= rates[r++].substeps;
      sum += updates * double(levels_[level].particles);
      if (r < rates.size() && rates[r].first_level == level + 1)
        sum += updates * (rates[r].substeps - 1) * double(levels_[level].beside_next);
    }
    return sum;
  }

  const std::vector<LevelCost>& levels_;
  double damping_ = 0;
};

}  // namespace

ChebyshevFilter::ChebyshevFilter(int p, double delta_) : delta(delta_), value{1, delta_} {
  double slope = 1, before = 0;  // of T_1 and T_0
  for (int k = 1; k < p; ++k) {
    const double next = 2 * value[std::size_t(k)] + 2 * delta * slope - before;
    value.push_back(2 * delta * value[std::size_t(k)] - value[std::size_t(k) - 1]);
    before = slope;
    slope = next;
  }
  w = 2 * slope / value[std::size_t(p)];
}

LocalStepPlan plan_local_steps(const std::vector<LevelCost>& levels) { return Planner(levels).best(); }

std::vector<ChebyshevFilter> filters_of(const std::vector<LocalRate>& rates, double damping, double dt) {
  std::vector<ChebyshevFilter> filters;
  double nu = nu_of(damping, dt);
  for (std::size_t r = 0; r < rates.size(); ++r) {
    const int p = rates[r].substeps;
    double delta = 1 + nu / (double(p) * p);
    if (r > 0) {
      const int before = rates[r - 1].substeps;
      const double room = filters.back().range() / (2.0 * before * before) - 1;
      if (room <= 0) return {};
      delta = std::max(delta, std::cosh(std::acosh(std::max(1 / room, 1.0)) / p));
    }
    filters.emplace_back(p, delta);
    nu = least_nu;
  }
  return filters;
}

}  // namespace mss
