#pragma once

#include <memory>

#include "core/springs/body_system.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/multigrid_level.hpp"

namespace mss {

/// One multigrid V-cycle in single precision as a preconditioner, symmetric and positive definite, for the
/// matrices a M + b C + c K of a body of cells: its springs stand for whatever fills them.
class VCycle {
 public:
  /// Prepares for the projected matrix at a state. The system and its holds must be the same at every call.
  /// `mask`: 1 at unknowns, 0 elsewhere. Status as MultigridLevel::prepare(). Throws InputError if the system
  /// is no body of cells.
  Status prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                 const TangentCoefficients& sum, const Field<double>& mask);

  /// z = P r, 0 where there is no unknown; `norm`, of r, scales it to what single precision can hold.
  void apply(const Field<double>& r, double norm, Field<double>& z);

 private:
  void build(const BodySystem<double>& body_system);
  void place(const BodySystem<double>& body_system, const Field<double>& x);
  void add_penalties(const BodySystem<double>& body_system, double t, const Field<double>& x,
                     const Field<double>& v, const TangentCoefficients& sum);
  /// Calls part(axis, first, last) for ranges of sites, on all threads.
  template <class Part>
  void for_each_coordinate(Part&& part);

  System<double>* system_ = nullptr;
  const Field<double>* mask_ = nullptr;
  std::unique_ptr<MultigridLevel> finest_;
  Field<float> x_, r_, z_;
  SiteBlocks added_;
};

}  // namespace mss
