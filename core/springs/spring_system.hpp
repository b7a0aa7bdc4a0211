#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/springs/body_system.hpp"
#include "core/springs/body_tangents.hpp"
#include "core/springs/discrete_gradient.hpp"

namespace mss {

template <class Real>
struct SweepKernel;
template <class Real>
struct SweepPass;
template <class Real>
class SweepPipeline;
template <class Real>
class MaxwellBranches;

/// How a SpringSystem computes. The kernel changes results by rounding, the number of threads not at all, and
/// sleep within the rule's bound.
struct Execution {
  int threads = 0;       ///< 0: as many as pay
  std::string kernel{};  ///< name of a sweep kernel; empty: the fastest this processor runs
  SleepRule sleep{};
};

/// A mass-spring body in its environment, driven through the structured sweep (sweep_pipeline.hpp).
template <class Real>
class SpringSystem final : public BodySystem<Real> {
 public:
  /// The body must outlive the system. Throws InputError for an unknown kernel.
  SpringSystem(const Body& body, const Environment& environment, const Execution& execution = {});
  /// With a given sweep in place of a named kernel's, for benchmarks.
  SpringSystem(const Body& body, const Environment& environment, const SweepKernel<Real>& kernel,
               const Execution& execution);
  ~SpringSystem() override;

  StoredEnergy stored_energy(const Field<Real>& x) const override;
  double dissipated_by_relaxation() const override;
  StepMemory<Real>* memory() override;
  void remember(Record& record) override;
  std::optional<std::vector<Eigen::Matrix3d>> cell_virials(const Field<Real>& x,
                                                           const Field<Real>& v) const override;
  const char* kernel_name() const override;
  /// The sweep that it computes with.
  const SweepKernel<Real>& kernel() const;
  void update_ghosts(const State<Real>& state) const override;

  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override;
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  const SpringSystem<Real>* springs() const override { return this; }
  Tangents<Real>* tangents() override { return &tangents_; }
  DiscreteGradient<Real>* discrete_gradient() override { return &discrete_gradient_; }
  void apply(const KickDrift& update, const Field<Real>& a, double dt, State<Real>& state) const override;
  void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) override;

  /// The symmetric 3 x 3 blocks on the diagonal of b C + c K at positions x, one per site, of springs and
  /// cells alone, or without `springs` of cells alone: overwritten with their xx, yy, zz and their yz, zx,
  /// xy, 0 where there is no particle. Of Tangent::exact there are none; the elastic ones are returned.
  void diagonal_blocks(const Field<Real>& x, const TangentCoefficients& sum, Field<Real>& straight,
                       Field<Real>& mixed, bool springs = true);

 private:
  class SpringTangents final : public BodyTangents<Real> {
   public:
    explicit SpringTangents(SpringSystem& system) : BodyTangents<Real>(system), system_(system) {}

   private:
    void add(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
             BlockMatrix& blocks) override;
    void add_diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                      std::vector<Eigen::Matrix3d>& diagonal) override;
    void multiply(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                  const Field<Real>& p, Field<Real>& out) override;

    SpringSystem& system_;
    Field<Real> straight_, mixed_;  ///< of the diagonal
  };

  using Pass = SweepPass<Real>;
  void stop_sleeping(Field<Real>& a) const;
  void add_energy_of_springs(const Field<Real>& x, StoredEnergy& energy) const;
  void add_energy_of_cells(const Field<Real>& x, StoredEnergy& energy) const;

  SpringTangents tangents_;
  SpringDiscreteGradient<Real> discrete_gradient_;
  std::unique_ptr<SweepPipeline<Real>> pipeline_;
  std::unique_ptr<MaxwellBranches<Real>> branches_;  ///< nullptr: nothing relaxes
};

}  // namespace mss
