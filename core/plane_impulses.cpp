#include "core/plane_impulses.hpp"

#include <Eigen/QR>
#include <algorithm>

namespace mss {

PlaneImpulses::PlaneImpulses(std::size_t planes, std::ptrdiff_t sites)
    : given_(planes, Field<double>(sites)),
      force_(sites),
      held_by_(std::size_t(sites), nothing),
      held_since_(std::size_t(sites), 0) {}

Vec3 PlaneImpulses::at(std::size_t plane, std::ptrdiff_t site) const {
  const Vec3 given = given_[plane].at(site);
  return held_by_[std::size_t(site)] == plane ? Vec3(given + pending(site)) : given;
}

void PlaneImpulses::finish(std::ptrdiff_t site) {
  add(held_by_[std::size_t(site)], site, pending(site));
  held_by_[std::size_t(site)] = nothing;
}

void PlaneImpulses::hold(std::size_t plane, std::ptrdiff_t site, const Vec3& force) {
  let_go(site);
  held_by_[std::size_t(site)] = std::uint32_t(plane);
  held_since_[std::size_t(site)] = kicked_;
  force_.set(site, force);
}

void PlaneImpulses::hold_for(double seconds) {
  kicked_ += seconds;
  is_told_ = true;
}

void PlaneImpulses::end_step(double dt) {
  if (!is_told_) kicked_ += dt;
  is_told_ = false;
}

std::vector<Vec3> split_by_plane(const std::vector<Plane>& planes, const std::vector<std::size_t>& on,
                                 const Vec3& free, const Vec3& given) {
  std::vector<Vec3> parts(planes.size(), Vec3::Zero());
  if (on.size() == 1) parts[on[0]] = free.cwiseProduct(given);
  if (on.size() < 2) return parts;
  Eigen::MatrixXd normals(3, on.size());
  for (std::size_t i = 0; i < on.size(); ++i)
    normals.col(Eigen::Index(i)) = free.cwiseProduct(planes[on[i]].normal);
  Vec3 rest = free.cwiseProduct(given);
  const Eigen::VectorXd pressures = normals.completeOrthogonalDecomposition().solve(rest);
  rest -= normals * pressures;
  std::vector<double> shares;
  double sum = 0;
  for (std::size_t i = 0; i < on.size(); ++i) {
    shares.push_back(planes[on[i]].friction * std::max(0.0, pressures[Eigen::Index(i)]));
    sum += shares.back();
  }
  for (std::size_t i = 0; i < on.size(); ++i) {
    const double share = sum > 0 ? shares[i] / sum : 1 / double(on.size());
    parts[on[i]] = pressures[Eigen::Index(i)] * normals.col(Eigen::Index(i)) + share * rest;
  }
  return parts;
}

}  // namespace mss
