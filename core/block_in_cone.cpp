#include "core/block_in_cone.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace mss {

namespace {

using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>;
using Small = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;

constexpr int friction_rounds = 5;

/// A particle on some planes.
class Touching {
 public:
  Touching(const std::vector<Plane>& planes, const std::vector<std::size_t>& on, const Vec3& free,
           const Vec3& before, const Vec3& u, const VertexModel& model)
      : planes_(planes), on_(on), u_(u), model_(model), normals_(3, 0), along_(3, 0), onto_(Vec3::Zero()) {
    Columns basis(3, 0);
    for (const std::size_t p : on_) {
      Vec3 n = free.cwiseProduct(planes_[p].normal);
      append(normals_, n);
      n -= basis * (basis.transpose() * n);
      if (n.norm() < 1e-6 || basis.cols() == 3) continue;
      onto_ -= planes_[p].gap(before + u + onto_) / n.squaredNorm() * n;
      append(basis, n.normalized());
    }
    for (int axis = 0; axis < 3; ++axis) {  // the rest of the free directions
      Vec3 t = free[axis] * Vec3::Unit(axis);
      t -= basis * (basis.transpose() * t) + along_ * (along_.transpose() * t);
      if (t.norm() > 0.5 && basis.cols() + along_.cols() < 3) append(along_, t.normalized());
    }
    if (basis.cols() + along_.cols() < int(free.sum())) complete(basis, free);
  }

  /// Moves onto the planes and along them as Coulomb's cones let it.
  Vec3 move(std::vector<double>& pressures) const {
    if (along_.cols() == 0) return with(onto_, pressures);
    const Vec3 stuck = onto_ - along_ * (along_.transpose() * (u_ + onto_));
    Vec3 d = with(stuck, pressures);
    const Small held = along_.transpose() * reaction(d);
    double limit = friction_limit(pressures);
    if (limit > 0 && held.norm() <= limit) return d;
    Small direction = held.norm() > 0 ? Small(held.normalized()) : Small(Small::Zero(along_.cols()));
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> block =
        along_.transpose() * model_.hessian * along_;
    for (int round = 0; round < friction_rounds; ++round) {
      const Small force = along_.transpose() * (model_.force - model_.hessian * onto_) + limit * direction;
      d = with(onto_ + along_ * Small(block.ldlt().solve(force)), pressures);
      if (limit == 0 && round > 0) break;
      const Small slid = along_.transpose() * (u_ + d);
      if (limit > 0 && slid.dot(direction) >= 0) return with(stuck, pressures);
      limit = friction_limit(pressures);
      if (slid.norm() > 0) direction = -slid.normalized();
    }
    return d;
  }

 private:
  static void append(Columns& columns, const Vec3& column) {
    columns.conservativeResize(3, columns.cols() + 1);
    columns.rightCols<1>() = column;
  }
  /// Of free directions that no axis comes near to.
  void complete(const Columns& basis, const Vec3& free) {
    for (int axis = 0; axis < 3 && basis.cols() + along_.cols() < int(free.sum()); ++axis) {
      Vec3 t = free[axis] * Vec3::Unit(axis);
      t -= basis * (basis.transpose() * t) + along_ * (along_.transpose() * t);
      if (t.norm() > 0.1) append(along_, t.normalized());
    }
  }
  Vec3 reaction(const Vec3& d) const { return model_.hessian * d - model_.force; }
  /// d itself, with the pressures that it takes.
  Vec3 with(const Vec3& d, std::vector<double>& pressures) const {
    const Eigen::VectorXd p = normals_.completeOrthogonalDecomposition().solve(reaction(d));
    for (std::size_t i = 0; i < on_.size(); ++i) pressures[on_[i]] = p[Eigen::Index(i)];
    return d;
  }
  double friction_limit(const std::vector<double>& pressures) const {
    double limit = 0;
    for (const std::size_t p : on_) limit += planes_[p].friction * std::max(0.0, pressures[p]);
    return limit;
  }

  const std::vector<Plane>& planes_;
  const std::vector<std::size_t>& on_;
  const Vec3& u_;
  const VertexModel& model_;
  Columns normals_;  ///< of the planes, along free axes
  Columns along_;    ///< orthonormal, in all planes
  Vec3 onto_;        ///< the shortest way onto the planes
};

}  // namespace

Vec3 move_in_cone(const std::vector<Plane>& planes, const Vec3& free, const Vec3& before, const Vec3& u,
                  const VertexModel& model, std::vector<double>& pressures) {
  pressures.assign(planes.size(), 0);
  std::vector<std::size_t> on;
  Vec3 d = model.hessian.ldlt().solve(model.force);
  for (std::size_t round = 0; round < 2 * planes.size() + 1; ++round) {
    std::size_t worst = planes.size();
    double deepest = 0;
    for (std::size_t p = 0; p < planes.size(); ++p) {
      if (std::find(on.begin(), on.end(), p) != on.end()) continue;
      if (const double gap = planes[p].gap(before + u + d); gap < deepest) deepest = gap, worst = p;
    }
    if (worst == planes.size()) break;
    on.push_back(worst);
    pressures.assign(planes.size(), 0);
    d = Touching(planes, on, free, before, u, model).move(pressures);
    const auto pulls = std::find_if(on.begin(), on.end(), [&](std::size_t p) { return pressures[p] < 0; });
    if (pulls == on.end() || on.size() == 1) continue;
    pressures[*pulls] = 0;
    on.erase(pulls);
    d = Touching(planes, on, free, before, u, model).move(pressures);
  }
  for (double& pressure : pressures) pressure = std::max(0.0, pressure);
  return d;
}

}  // namespace mss
