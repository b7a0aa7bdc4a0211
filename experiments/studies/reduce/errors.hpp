#pragma once

#include "experiments/studies/reduce/scenes.hpp"

namespace mss::studies::reduce {

/// How far motions of a body are from a reference: the largest root mean square over particles of the
/// distance at a frame, over the largest displacement of the reference. Of a free body after the rigid motion
/// that fits best, over the largest deformation.
class MotionErrors {
 public:
  /// The body must outlive it.
  MotionErrors(const Solid& solid, const Body& body, FramePositions reference);

  /// Of the positions at the end of one frame, counted from 0.
  double at(std::size_t frame, const Field<double>& x) const;
  /// Of a motion of as many frames.
  double of(const FramePositions& motion) const;
  const FramePositions& reference() const { return reference_; }

 private:
  double distance(const Field<double>& x, const Field<double>& to) const;

  bool aligned_;
  const Body& body_;
  FramePositions reference_;
  double scale_ = 0;  ///< [m]
};

}  // namespace mss::studies::reduce
