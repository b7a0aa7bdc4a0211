#include "experiments/simulation/step_balance.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace mss {

namespace {

/// Planes that touch a surface touch the cells that carry its vertices.
double margin_of(const Scene& scene, double dt) {
  constexpr double rounding = 1e-6, cells = 2;
  const double h = scene.body.cell_size;
  for (const SceneBody* one : bodies_of(scene))
    if (one->contact_surface) return cells * h;
  return rounding * h + scene.environment.gravity.norm() * dt * dt;
}

double squared_weight(const Scene& scene, double mass) {
  double weight = mass * scene.environment.gravity.norm();
  for (const Load& load : scene.environment.loads) weight += load.force.norm();
  return weight * weight / mass;
}

}  // namespace

StepBalance::StepBalance(const Scene& scene, SolidSystem<double>& system, double dt)
    : scene_(scene),
      system_(system),
      dt_(dt),
      margin_(margin_of(scene, dt)),
      obstacles_(scene.environment.obstacles.begin(), scene.environment.obstacles.end()),
      free_axes_(system.size()),
      force_(system.size()) {
  const Box box = box_at_rest(scene);
  const Vec3 half = (box.upper - box.lower) / 2;
  middle_ = box.lower + half;
  reach_ = half.norm();
  Eigen::Matrix<double, functions, functions> gram;
  gram.setZero();
  for (const std::ptrdiff_t site : system.particles()) {
    free_axes_.set(site, Vec3::Ones());
    gram += system.mass(site) * values(site) * values(site).transpose();
  }
  system.clear_prescribed(free_axes_);
  inverse_gram_ = gram.completeOrthogonalDecomposition().pseudoInverse();  // of few cells it is singular
}

bool StepBalance::applies_to(const Scene& scene) {
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  return method.iterates && method.has_modulus && method.order_undamped == 1 &&
         scene.solve.precision == Precision::dbl;
}

StepBalance::Values StepBalance::values(std::ptrdiff_t site) const {
  const Vec3 p = (system_.rest_position(site) - middle_) / reach_;
  Values values;
  values << 1, p, p.cwiseProduct(p), p[1] * p[2], p[2] * p[0], p[0] * p[1];
  return values;
}

double StepBalance::squared_norm(const Moments& moments) const {
  return (moments.transpose() * inverse_gram_ * moments).trace();
}

/// Also what has been stopped in the step, or has left.
bool StepBalance::is_touched(const Vec3& x, const Vec3& next, const Vec3& v, double t) const {
  const std::vector<Plane>& planes = scene_.environment.planes;
  return std::any_of(planes.begin(), planes.end(),
                     [&](const Plane& plane) {
                       return std::min({plane.gap(x), plane.gap(next), plane.gap(x + dt_ * v)}) <= margin_;
                     }) ||
         std::any_of(obstacles_.begin(), obstacles_.end(), [&](const ObstacleSurface& surface) {
           // A bound may be a plane that touches a round obstacle beside the particle.
           const double beside = (next - x - dt_ * v).norm();
           return std::min({surface.gap(x, t - dt_), surface.gap(next, t), surface.gap(x + dt_ * v, t)}) <=
                  margin_ + beside;
         });
}

/// The velocities are the step's own, (x' - x) / dt: what planes have stopped has lost its own afterwards.
void StepBalance::add(const State<double>& before, const State<double>& after) {
  velocity_ = after.x;
  velocity_.array() = (after.x.array() - before.x.array()) / dt_;
  system_.force(after.t, after.x, velocity_, force_);
  Moments residuals = Moments::Zero(), inertia = residuals, reactions = residuals;
  for (const std::ptrdiff_t site : system_.particles()) {
    const Vec3 x = before.x.at(site), v = before.v.at(site);
    const Vec3 pull = system_.mass(site) * (velocity_.at(site) - v) / dt_;
    const Vec3 residual = pull - force_.at(site);
    const Vec3 free = is_touched(x, after.x.at(site), v, after.t) ? Vec3(Vec3::Zero()) : free_axes_.at(site);
    const Values phi = values(site);
    residuals += phi * free.cwiseProduct(residual).transpose();
    reactions += phi * (Vec3::Ones() - free).cwiseProduct(residual).transpose();
    inertia += phi * pull.transpose();
  }
  residual_ += squared_norm(residuals);
  reactions_ += squared_norm(reactions);
  inertia_ += squared_norm(inertia);
  weight_ += squared_weight(scene_, system_.total_mass());
  ++steps_;
}

std::optional<Imbalance> StepBalance::imbalance() const {
  // Forces that would move the body by a millionth of a millionth of its size in a step.
  const double acceleration = 1e-12 * reach_ / (dt_ * dt_);
  const double rounding = steps_ * system_.total_mass() * acceleration * acceleration;
  const auto over = [&](double whole, Imbalance::Over of) {
    return whole > rounding ? std::optional(Imbalance{std::sqrt(residual_ / whole), of}) : std::nullopt;
  };
  if (weight_ == 0 && reactions_ > inertia_) return over(reactions_, Imbalance::Over::reactions);
  if (inertia_ > weight_) return over(inertia_, Imbalance::Over::inertia);
  return over(weight_, Imbalance::Over::weight);
}

}  // namespace mss
