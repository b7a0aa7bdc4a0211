#include "experiments/peer/score.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "experiments/simulation/moving_body.hpp"

namespace mss::peer {

namespace {

std::vector<Measures> measures_of(const Exchange& exchange, const std::vector<State<double>>& samples) {
  std::vector<Measures> measures;
  measures.reserve(samples.size());
  for (const State<double>& sample : samples) measures.push_back(measure(*exchange.system, sample));
  return measures;
}

Vec3 centre_of(const Body& body, const Field<double>& x) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites()) sum += body.mass(site) * x.at(site);
  return sum / body.total_mass();
}

/// Of the motion that is straight from one sample to the next. Its angular momentum,
/// sum m (x0 - c0) x (x1 - c1) / h, is the same in every interval of a rigid rotation.
Balance between(const Body& body, const State<double>& before, const State<double>& after) {
  const double h = after.t - before.t;
  const Vec3 c0 = centre_of(body, before.x), c1 = centre_of(body, after.x);
  Balance balance;
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 x0 = before.x.at(site), x1 = after.x.at(site), v = (x1 - x0) / h;
    balance.momentum += body.mass(site) * v;
    balance.spin += body.mass(site) / h * (x0 - c0).cross(x1 - c1);
    balance.energy += body.mass(site) * v.squaredNorm() / 2;
  }
  return balance;
}

std::vector<Balance> balances_at(const std::vector<Measures>& measures) {
  std::vector<Balance> balances;
  balances.reserve(measures.size());
  for (const Measures& m : measures) balances.push_back({m.total(), m.momentum, m.angular_momentum});
  return balances;
}

std::vector<Balance> balances_between(const Body& body, const std::vector<State<double>>& samples,
                                      const std::vector<Measures>& measures) {
  const auto potential = [&](std::size_t k) { return measures[k].total() - measures[k].kinetic; };
  std::vector<Balance> balances;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    balances.push_back(between(body, samples[k - 1], samples[k]));
    balances.back().energy += (potential(k - 1) + potential(k)) / 2;
  }
  return balances;
}

/// Sites that a plane may push.
std::vector<std::ptrdiff_t> free_sites(const Exchange& exchange) {
  const HeldSites& held = exchange.system->held();
  std::vector<std::ptrdiff_t> sites;
  for (const std::ptrdiff_t site : exchange.body->sites())
    if (held.empty() || !held.holds(site, 0)) sites.push_back(site);
  return sites;
}

double deepest(const Exchange& exchange, const std::vector<State<double>>& samples) {
  double depth = 0;
  const std::vector<std::ptrdiff_t> sites = free_sites(exchange);
  for (const Plane& plane : exchange.scene.environment.planes)
    for (const State<double>& sample : samples)
      for (const std::ptrdiff_t site : sites) depth = std::max(depth, -plane.gap(sample.x.at(site)));
  return depth;
}

double largest_held_drift(const Exchange& exchange, const std::vector<State<double>>& samples) {
  double largest = 0;
  for (const std::ptrdiff_t site : exchange.body->sites())
    if (exchange.system->held().holds(site, 0))
      for (const State<double>& sample : samples)
        largest = std::max(largest, (sample.x.at(site) - exchange.start.x.at(site)).norm());
  return largest;
}

/// What takes energy of the true motion.
std::string energy_taker(const Exchange& exchange, bool touches) {
  if (exchange.scene.body.is_damped()) return "the material is damped";
  return touches ? "planes touch the body" : "";
}

}  // namespace

Judge::Judge(const Exchange& exchange)
    : exchange_(exchange),
      reference_(measures_of(exchange, exchange.reference)),
      at_samples_(balances_at(reference_)),
      between_samples_(balances_between(*exchange.body, exchange.reference, reference_)) {
  find_scale();
  const double all = scale_.displacement + scale_.momentum + scale_.spin + std::abs(scale_.energy);
  if (!std::isfinite(all * all))
    throw InputError(
        fmt::format("{}: numbers of its reference are not finite; export it again", exchange.scene.name));
  constexpr double rounding = 1e-9;
  if (scale_.displacement <= rounding * scale_.size)
    throw InputError(
        fmt::format("{}: nothing moves in it, so that no motion can be compared with it; export a "
                    "scene that moves",
                    exchange.scene.name));
}

void Judge::find_scale() {
  const Body& body = *exchange_.body;
  const VoxelGrid& voxels = body.config().voxels;
  scale_.size = body.config().cell_size * Vec3(voxels.nx(), voxels.ny(), voxels.nz()).norm();
  double kinetic = 0;
  for (const Measures& m : reference_) {
    kinetic = std::max(kinetic, m.kinetic);
    scale_.energy = std::max(scale_.energy, m.mechanical());
  }
  for (const State<double>& sample : exchange_.reference)
    for (const std::ptrdiff_t site : body.sites())
      scale_.displacement =
          std::max(scale_.displacement, (sample.x.at(site) - exchange_.start.x.at(site)).norm());
  const Environment& environment = exchange_.scene.environment;
  scale_.momentum = std::sqrt(2 * body.total_mass() * kinetic);
  scale_.has_holds = !environment.holds.empty();
  scale_.has_planes = !environment.planes.empty();
  scale_.free_samples = scale_.has_holds ? 0 : count_free_samples();
  scale_.has_momentum = scale_.free_samples > 1 && scale_.momentum > 0;
  constexpr double rounding = 1e-9;
  const double spin = reference_.front().angular_momentum.norm();
  if (spin > rounding * scale_.momentum * scale_.size) scale_.spin = spin;
  scale_.has_spin = scale_.has_momentum && scale_.spin > 0 && environment.loads.empty();
  scale_.has_energy = exchange_.scene.model != mollemans_model && scale_.energy > 0;
  scale_.takes_energy =
      energy_taker(exchange_, scale_.has_planes && count_free_samples() < exchange_.times.size());
}

/// Until the last sample after which the reference moves on straight for a sample without touching a plane.
std::size_t Judge::count_free_samples() const {
  const Environment& environment = exchange_.scene.environment;
  const double h = exchange_.spacing;
  for (std::size_t k = 0; k < exchange_.reference.size(); ++k)
    for (const Plane& plane : environment.planes)
      for (const std::ptrdiff_t site : exchange_.body->sites()) {
        const State<double>& sample = exchange_.reference[k];
        const double gap = plane.gap(sample.x.at(site));
        if (gap <= 0) return k;
        const double falls = std::min(0.0, plane.normal.dot(environment.gravity)) * h * h / 2;
        if (gap + h * plane.normal.dot(sample.v.at(site)) + falls <= 0) return k + 1;
      }
  return exchange_.reference.size();
}

/// Empty, or when and how a motion left all bounds.
std::string Judge::blow_up(const Result& result, const std::vector<Measures>& measures) const {
  constexpr double far = 10, fast = 100;
  const Body& body = *exchange_.body;
  for (std::size_t k = 0; k < result.samples.size(); ++k) {
    double largest = 0;
    for (const std::ptrdiff_t site : body.sites())
      largest = std::max(largest, (result.samples[k].x.at(site) - exchange_.start.x.at(site)).squaredNorm());
    const double kinetic = result.has_velocities ? measures[k].kinetic
                           : k == 0              ? 0
                                    : between(body, result.samples[k - 1], result.samples[k]).energy;
    if (std::sqrt(largest) > far * std::max(scale_.displacement, scale_.size) ||
        !(kinetic <= fast * scale_.energy))
      return fmt::format("blown up at t = {:.6g}", result.samples[k].t);
  }
  return "";
}

void Judge::add_distances(const Result& result, Score& score) const {
  double sum = 0, largest = 0;
  for (std::size_t k = 0; k < result.samples.size(); ++k)
    for (const std::ptrdiff_t site : exchange_.body->sites()) {
      const double square = (result.samples[k].x.at(site) - exchange_.reference[k].x.at(site)).squaredNorm();
      sum += square;
      largest = std::max(largest, square);
    }
  const double count = double(result.samples.size() * exchange_.body->particle_count());
  score.error = std::sqrt(sum / count) / scale_.displacement;
  score.worst_error = std::sqrt(largest) / scale_.displacement;
}

void Judge::add_volumes(const std::vector<Measures>& measures, Score& score) const {
  score.volume_low = score.volume_high = measures.front().volume_ratio;
  score.min_jacobian = measures.front().min_jacobian;
  score.volume_drift = 0;
  for (std::size_t k = 0; k < measures.size(); ++k) {
    const double ratio = measures[k].volume_ratio;
    score.volume_low = std::min(score.volume_low, ratio);
    score.volume_high = std::max(score.volume_high, ratio);
    score.volume_drift = std::max(score.volume_drift, std::abs(ratio - reference_[k].volume_ratio));
    score.min_jacobian = std::min(score.min_jacobian, measures[k].min_jacobian);
  }
}

void Judge::add_balances(const std::vector<Balance>& now, const std::vector<Balance>& reference,
                         Score& score) const {
  double momentum = 0, spin = 0, gain = 0, loss = 0;
  const std::size_t free = scale_.free_samples - (now.size() < exchange_.times.size() ? 1 : 0);
  for (std::size_t k = 0; k < now.size(); ++k) {
    const double excess = now[k].energy - reference[k].energy;
    gain = std::max(gain, excess);
    loss = std::max(loss, -excess);
    if (!scale_.has_momentum || k >= free) continue;
    momentum = std::max(momentum, (now[k].momentum - reference[k].momentum).norm());
    spin = std::max(spin, (now[k].spin - reference[k].spin).norm());
  }
  if (scale_.has_momentum) score.momentum_drift = momentum / scale_.momentum;
  if (scale_.has_spin) score.spin_drift = spin / scale_.spin;
  if (scale_.has_energy) score.energy_gain = gain / scale_.energy;
  if (scale_.has_energy) score.energy_loss = loss / scale_.energy;
}

Score Judge::score(const Result& result) const {
  Score score;
  if (!result.problem.empty()) {
    score.status = result.problem;
    score.unstable = result.diverged;
    return score;
  }
  const double frames = exchange_.times.back() / frame;
  score.cpu_ms = 1e3 * result.cpu_seconds / frames;
  score.wall_ms = 1e3 * result.wall_seconds / frames;
  const std::vector<Measures> measures = measures_of(exchange_, result.samples);
  if (const std::string words = blow_up(result, measures); !words.empty()) {
    score.status = words;
    score.unstable = true;
    return score;
  }
  score.stable = true;
  add_distances(result, score);
  add_volumes(measures, score);
  if (result.has_velocities)
    add_balances(balances_at(measures), at_samples_, score);
  else
    add_balances(balances_between(*exchange_.body, result.samples, measures), between_samples_, score);
  if (scale_.has_planes) score.penetration = deepest(exchange_, result.samples);
  if (scale_.has_holds) score.held_drift = largest_held_drift(exchange_, result.samples);
  return score;
}

}  // namespace mss::peer
