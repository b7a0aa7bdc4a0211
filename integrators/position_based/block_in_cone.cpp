#include "integrators/position_based/block_in_cone.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace mss {

namespace {

constexpr int friction_rounds = 5;

/// Normals whose rest, off those before, is shorter than that say nothing new.
constexpr double negligible_normal = 1e-6;

/// A particle on some planes.
class Touching {
 public:
  Touching(const std::vector<Plane>& planes, const std::vector<double>& gaps,
           const std::vector<std::size_t>& on, const Vec3& free, const Vec3& before, const Vec3& u,
           const VertexModel& model)
      : planes_(planes), on_(on), free_(free), u_(u), model_(model), onto_(Vec3::Zero()) {
    Eigen::Matrix3d across = Eigen::Matrix3d::Zero();
    for (const std::size_t p : on_) {
      Vec3 n = free.cwiseProduct(planes_[p].normal);
      n -= across * n;
      if (n.norm() < negligible_normal) continue;
      onto_ -= (planes_[p].gap(before + u + onto_) - gaps[p]) / n.squaredNorm() * n;
      across += n.normalized() * n.normalized().transpose();
    }
    along_ = free.asDiagonal();
    along_ -= across;
  }

  /// Moves onto the planes and along them as Coulomb's cones let it.
  Vec3 move(std::vector<double>& pressures) const {
    Vec3 stuck = onto_ - along_ * (u_ + onto_);
    set_pressures(stuck, pressures);
    const Vec3 held = along_ * reaction(stuck);
    double limit = friction_limit(pressures);
    if (along_.trace() < 0.5 || (limit > 0 && held.norm() <= limit)) return stuck;
    Vec3 direction = held.stableNormalized(), moved = stuck;
    for (int round = 0; round < friction_rounds; ++round) {
      moved = onto_ + slide(limit * direction);
      set_pressures(moved, pressures);
      if (limit == 0 && round > 0) break;
      const Vec3 slid = along_ * (u_ + moved);
      if (limit > 0 && slid.dot(direction) >= 0) {
        set_pressures(stuck, pressures);
        return stuck;
      }
      limit = friction_limit(pressures);
      direction = -slid.stableNormalized();
    }
    return moved;
  }

 private:
  Vec3 reaction(const Vec3& moved) const { return model_.hessian * moved - model_.force; }

  /// How far it moves along the planes under a friction.
  Vec3 slide(const Vec3& friction) const {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along_;
    const Eigen::Matrix3d block = along_ * model_.hessian * along_ + model_.hessian.trace() * across;
    const Vec3 force = along_ * (model_.force - model_.hessian * onto_ + friction);
    return along_ * block.ldlt().solve(force);
  }

  /// By which planes keep it there. Of several sets that do, as where normals depend on each other, the
  /// smallest.
  void set_pressures(const Vec3& moved, std::vector<double>& pressures) const {
    const Vec3 r = reaction(moved);
    if (on_.size() == 1) {
      const Vec3 n = free_.cwiseProduct(planes_[on_[0]].normal);
      pressures[on_[0]] = n.isZero(0) ? 0 : n.dot(r) / n.squaredNorm();
      return;
    }
    Eigen::MatrixXd normals(3, on_.size());
    for (std::size_t i = 0; i < on_.size(); ++i)
      normals.col(Eigen::Index(i)) = free_.cwiseProduct(planes_[on_[i]].normal);
    const Eigen::VectorXd p = normals.completeOrthogonalDecomposition().solve(free_.cwiseProduct(r));
    for (std::size_t i = 0; i < on_.size(); ++i) pressures[on_[i]] = p[Eigen::Index(i)];
  }

  double friction_limit(const std::vector<double>& pressures) const {
    double limit = 0;
    for (const std::size_t p : on_) limit += planes_[p].friction * std::max(0.0, pressures[p]);
    return limit;
  }

  const std::vector<Plane>& planes_;
  const std::vector<std::size_t>& on_;
  const Vec3& free_;
  const Vec3& u_;
  const VertexModel& model_;
  Vec3 onto_;              ///< the shortest way onto the planes
  Eigen::Matrix3d along_;  ///< projects onto directions in all planes
};

}  // namespace

Vec3 move_in_cone(const std::vector<Plane>& planes, const std::vector<double>& gaps, const Vec3& free,
                  const Vec3& before, const Vec3& u, const VertexModel& model,
                  std::vector<double>& pressures) {
  pressures.assign(planes.size(), 0);
  std::vector<std::size_t> on;
  Vec3 moved = model.hessian.ldlt().solve(model.force);
  for (std::size_t round = 0; round < 2 * planes.size() + 1; ++round) {
    std::size_t worst = planes.size();
    double deepest = 0;
    for (std::size_t p = 0; p < planes.size(); ++p) {
      if (std::find(on.begin(), on.end(), p) != on.end()) continue;
      if (const double gap = planes[p].gap(before + u + moved) - gaps[p]; gap < deepest)
        deepest = gap, worst = p;
    }
    if (worst == planes.size()) break;
    on.push_back(worst);
    pressures.assign(planes.size(), 0);
    moved = Touching(planes, gaps, on, free, before, u, model).move(pressures);
    const auto pulls = std::find_if(on.begin(), on.end(), [&](std::size_t p) { return pressures[p] < 0; });
    if (pulls == on.end() || on.size() == 1) continue;
    pressures[*pulls] = 0;
    on.erase(pulls);
    moved = Touching(planes, gaps, on, free, before, u, model).move(pressures);
  }
  for (double& pressure : pressures) pressure = std::max(0.0, pressure);
  return moved;
}

}  // namespace mss
