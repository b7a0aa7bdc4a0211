// Static problems in cells of several sizes, and what estimates say of their errors.
#include <fmt/format.h>

#include <cmath>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/extrapolation.hpp"
#include "experiments/studies/refine/refine.hpp"
#include "integrators/analysis/error_estimate.hpp"
#include "integrators/statics/linear_response.hpp"

namespace mss::studies::refine {

namespace {

/// A problem solved in cells of one size.
struct Solved {
  std::size_t particles = 0;
  GoalEstimate goal{};
};

/// Equal weights that add up to the direction.
Field<double> mean_over(const Body& body, const Box& box, const Vec3& direction) {
  Field<double> weight(body.lattice().size);
  const std::vector<std::ptrdiff_t> sites = body.select(box.lower, box.upper);
  for (const std::ptrdiff_t site : sites) weight.set(site, direction / double(sites.size()));
  return weight;
}

/// `estimated`: false leaves the estimate out.
Solved solve(const RefineConfig& config, const Problem& problem, double face_share, int n, bool estimated) {
  const Body body(in_cells(problem, n, config.material, face_share));
  SpringSystem<double> system(body, problem.environment, {.threads = config.threads});
  Work work;
  const LinearResponse response = linear_response(system, {}, work);
  Solved solved{.particles = body.particle_count(), .goal = {.status = response.status}};
  if (response.status != Status::ok) return solved;
  const Field<double> weight = mean_over(body, problem.goal, problem.direction);
  if (estimated)
    solved.goal = GoalEstimator(system, response.displacement, work).displacement(weight);
  else
    solved.goal.value = inner(system, weight, response.displacement);
  return solved;
}

class Estimates {
 public:
  Estimates(const RefineConfig& config, Progress& progress) : config_(config), progress_(progress) {}

  EstimateTables run();

 private:
  void find_reference(const Problem& problem);
  void measure(const Problem& problem, double face_share);
  bool goes_on(const Problem& problem, double face_share, int n);

  const RefineConfig& config_;
  Progress& progress_;
  double done_ = 0;
  Limit limit_{};
  double uncertainty_ = no_value;
  EstimateTables tables_{.rows = Table({{"problem"},
                                        {"face_share"},
                                        {"cells"},
                                        {"particles"},
                                        {"value", "m"},
                                        {"estimate", "m"},
                                        {"reference", "m"},
                                        {"raw_error"},
                                        {"corrected_error"},
                                        {"richardson_error"},
                                        {"effectivity"},
                                        {"doubts"},
                                        {"status"}}),
                         .reference = Table({{"problem"},
                                             {"description"},
                                             {"cells"},
                                             {"reference", "m"},
                                             {"order"},
                                             {"uncertainty"},
                                             {"status"}})};
};

/// False if stopped.
bool Estimates::goes_on(const Problem& problem, double face_share, int n) {
  const double a_problem =
      double(config_.face_shares.size() * (config_.cells.size() + config_.reference_cells.size() + 1));
  progress_.report(done_++ / (double(config_.problems.size()) * a_problem),
                   fmt::format("{}, t = {:g}, {} cells a metre", problem.name, face_share, n));
  if (progress_.stopped()) tables_.status = Status::interrupted;
  return tables_.status == Status::ok;
}

void Estimates::find_reference(const Problem& problem) {
  std::vector<Limit> limits;
  Status status = Status::ok;
  for (const double face_share : config_.face_shares) {
    std::vector<double> values;
    for (const int n : config_.reference_cells) {
      if (!goes_on(problem, face_share, n)) return;
      const Solved solved = solve(config_, problem, face_share, n, false);
      if (solved.goal.status != Status::ok) status = solved.goal.status;
      values.push_back(solved.goal.value);
    }
    limits.push_back(limit_of(values));
  }
  limit_ = limits.back();
  uncertainty_ = std::abs(limits.front().value / limit_.value - 1);
  const bool found = status == Status::ok && limit_.order > 0;
  tables_.reference.add({problem.name, problem.description, config_.reference_cells.back(), limit_.value,
                         limit_.order, uncertainty_,
                         std::string(found                  ? "ok"
                                     : status == Status::ok ? "does not converge"
                                                            : to_string(status))});
}

void Estimates::measure(const Problem& problem, double face_share) {
  if (!goes_on(problem, face_share, config_.cells.front() / 2)) return;
  double coarse = solve(config_, problem, face_share, config_.cells.front() / 2, false).goal.value;
  for (const int n : config_.cells) {
    if (!goes_on(problem, face_share, n)) return;
    const auto [particles, goal] = solve(config_, problem, face_share, n, true);
    const bool ok = goal.status == Status::ok;
    const auto error = [&](double value) { return ok ? value / limit_.value - 1 : no_value; };
    tables_.rows.add({problem.name, face_share, n, std::int64_t(particles), ok ? goal.value : no_value,
                      ok ? goal.error : no_value, limit_.value, error(goal.value), error(goal.corrected()),
                      error(richardson(coarse, goal.value)),
                      ok ? goal.error / (limit_.value - goal.value) : no_value, to_string(goal.doubts),
                      std::string(to_string(goal.status))});
    coarse = goal.value;
  }
}

EstimateTables Estimates::run() {
  for (const Problem& problem : config_.problems) {
    find_reference(problem);
    for (const double face_share : config_.face_shares)
      if (tables_.status == Status::ok) measure(problem, face_share);
    if (tables_.status != Status::ok) break;
  }
  return std::move(tables_);
}

}  // namespace

EstimateTables measure_estimates(const RefineConfig& config, Progress& progress) {
  return Estimates(config, progress).run();
}

}  // namespace mss::studies::refine
