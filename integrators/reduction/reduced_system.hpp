#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/springs/spring_system.hpp"
#include "integrators/reduction/reduced_shapes.hpp"
#include "integrators/reduction/subspace_motion.hpp"

namespace mss {

/// How a body is reduced to few coordinates.
enum class Reduction { modal, warped, cubic };

struct ReductionChoice {
  Reduction reduction = Reduction::modal;
  int modes = 0;  ///< 0: 8 of `modal` and `warped`, 16 of `cubic`, 18 of free bodies
};

/// The shapes that a body is reduced to; a free one has those of FloatingMotion, whatever the reduction.
/// Throws InputError as RestBody does.
ReducedShapes shapes_for(const Body& body, const Environment& environment, const ReductionChoice& choice);

/// A body of springs whose particles follow the coordinates of a ReducedMotion. Forces, and with them what
/// holds exert, are those of the whole lattice where its particles are; energy is that of the coordinates.
class ReducedSystem final : public BodySystem<double> {
 public:
  /// The body must outlive it. Throws InputError for planes of other laws than `penalty`, materials that
  /// relax, and free bodies by `cubic` or `warped`.
  ReducedSystem(const Body& body, const Environment& environment, const ReductionChoice& choice,
                const ReducedShapes& shapes);

  ReducedMotion* reduced() override { return motion_.get(); }
  /// What the lattice it stands for is.
  SpringSystem<double>& lattice() { return lattice_; }
  /// See ElasticMotion::lost().
  double lost() const { return motion_->lost(); }

  StoredEnergy stored_energy(const Field<double>& x) const override;
  SpectralBound spectral_bound() const override { return {.omega = motion_->fastest()}; }
  const char* kernel_name() const override { return lattice_.kernel_name(); }
  std::optional<std::vector<Eigen::Matrix3d>> cell_virials(const Field<double>& x,
                                                           const Field<double>& v) const override {
    return lattice_.cell_virials(x, v);
  }
  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override {
    lattice_.force(t, x, v, f);
  }

 private:
  void add_outer(double t, const State<double>& state, Field<double>& f);

  SpringSystem<double> lattice_;
  std::unique_ptr<ElasticMotion> motion_;
};

}  // namespace mss
