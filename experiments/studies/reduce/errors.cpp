#include "experiments/studies/reduce/errors.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace mss::studies::reduce {

namespace {

Eigen::Matrix3Xd points_of(const Body& body, const Field<double>& x) {
  Eigen::Matrix3Xd points(3, Eigen::Index(body.particle_count()));
  Eigen::Index i = 0;
  for (const std::ptrdiff_t site : body.sites()) points.col(i++) = x.at(site);
  return points;
}

Field<double> rest_of(const Body& body) {
  Field<double> rest(body.lattice().size);
  for (const std::ptrdiff_t site : body.sites()) rest.set(site, body.rest_position(site));
  return rest;
}

}  // namespace

MotionErrors::MotionErrors(const Solid& solid, const Body& body, FramePositions reference)
    : aligned_(!solid.clamped), body_(body), reference_(std::move(reference)) {
  const Field<double> rest = rest_of(body);
  for (const Field<double>& x : reference_) scale_ = std::max(scale_, distance(rest, x));
}

double MotionErrors::at(std::size_t frame, const Field<double>& x) const {
  return distance(x, reference_[frame]) / scale_;
}

double MotionErrors::of(const FramePositions& motion) const {
  double largest = 0;
  for (std::size_t i = 0; i < motion.size(); ++i) largest = std::max(largest, at(i, motion[i]));
  return largest;
}

double MotionErrors::distance(const Field<double>& x, const Field<double>& to) const {
  Eigen::Matrix3Xd from = points_of(body_, x);
  const Eigen::Matrix3Xd there = points_of(body_, to);
  if (aligned_) {
    const Eigen::Matrix4d motion = Eigen::umeyama(from, there, false);
    from = (motion.topLeftCorner<3, 3>() * from).colwise() + Vec3(motion.topRightCorner<3, 1>());
  }
  return std::sqrt((from - there).squaredNorm() / double(from.cols()));
}

}  // namespace mss::studies::reduce
