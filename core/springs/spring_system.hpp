#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/kernels/sweep.hpp"
#include "core/springs/body_system.hpp"
#include "core/springs/body_tangents.hpp"
#include "core/springs/discrete_gradient.hpp"
#include "core/springs/halo.hpp"
#include "core/springs/sweep_blocks.hpp"

namespace mss {

/// How a SpringSystem computes. The kernel changes results by rounding, the number of threads not at all, and
/// sleep within the rule's bound.
struct Execution {
  int threads = 0;       ///< 0: as many as pay
  std::string kernel{};  ///< name of a sweep kernel; empty: the fastest this processor runs
  SleepRule sleep{};
};

/// A mass-spring body in its environment, driven through the structured sweep.
///
/// Each thread has a slab of planes (team.hpp). A slab's first plane is finished last, after the slab below
/// has added its contribution. Where several ranks share the body, ghost planes are exchanged before each
/// pass (halo.hpp).
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
  const char* kernel_name() const override { return kernel_.name; }
  void update_ghosts(const State<Real>& state) const override {
    if (halo_) halo_->exchange(state.x, state.v);
  }

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
  void diagonal_blocks(const Field<Real>& x, const TangentSum& sum, Field<Real>& straight, Field<Real>& mixed,
                       bool springs = true);

 private:
  class SpringTangents final : public BodyTangents<Real> {
   public:
    explicit SpringTangents(SpringSystem& system) : BodyTangents<Real>(system), system_(system) {}

   private:
    void add(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
             BlockMatrix& blocks) const override;
    void add_diagonal(const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                      std::vector<Eigen::Matrix3d>& diagonal) override;
    void multiply(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                  const Field<Real>& p, Field<Real>& out) override;

    SpringSystem& system_;
    Field<Real> straight_, mixed_;  ///< of the diagonal
  };

  struct Slab;
  enum class Finish { force, acceleration, product, straight_diagonal, mixed_diagonal, kick_drift };
  struct Pass;
  bool stays_unfinished(const Pass& pass, int plane) const;
  bool needs_cells(const Pass& pass, int plane) const;

  void stop_sleeping(Field<Real>& a) const;
  void add_energy_of_springs(const Field<Real>& x, StoredEnergy& energy) const;
  void add_energy_of_cells(const Field<Real>& x, StoredEnergy& energy) const;
  InteriorCoefficients<Real> interior_coefficients() const;
  bool has_cell_weights() const;
  static std::uint32_t content_of(const SiteElements& e);
  std::uint32_t content_of_all_kinds() const;
  std::uint32_t fill_lane(std::uint32_t kind, Real* coefficients) const;
  void build_dictionary();
  Sweep<Real> sweep_for(const Pass& pass) const;
  void build_masses();
  void run(const Pass& pass, long steps);
  void sweep_part(const Pass& pass, int slab, SlabPart part, long step);
  void sweep_planes(const Pass& pass, Slab& slab, int first, int last, long step);
  void sweep_plane(const Pass& pass, int plane, const Streams<Real>& own, const Streams<Real>& above,
                   const ConstStreams<Real>* below, double t);
  void finish_runs(const Pass& pass, int plane, std::span<const BlockRun> runs, const Streams<Real>& own,
                   const ConstStreams<Real>& below, double t);
  FinishPlane<Real> update_of(int plane, std::span<const BlockRun> runs, const KickDrift& update,
                              State<Real>& state) const;
  FinishPlane<Real> result_of(int plane, std::span<const BlockRun> runs, const Pass& pass) const;
  void clear_between_blocks(int plane, Field<Real>& out) const;

  SpringTangents tangents_;
  SpringDiscreteGradient<Real> discrete_gradient_;
  SweepKernel<Real> kernel_;
  std::unique_ptr<Halo<Real>> halo_;  ///< nullptr: no other process has a part of the body
  SweepBlocks blocks_;
  bool own_dampings_, cell_weights_;  ///< what a block's coefficients contain beside weights

  std::vector<std::uint32_t> entry_;    ///< per block, and two more: dictionary entry
  std::vector<std::uint32_t> content_;  ///< per entry
  std::uint32_t whole_content_ = 0;     ///< of all entries together
  AlignedArray<Real> dictionary_;
  InteriorCoefficients<Real> interior_;
  AlignedArray<Real> inverse_mass_;
  Field<Real> nothing_below_;                 ///< contribution from below to the lowest plane: zero
  std::vector<std::unique_ptr<Slab>> slabs_;  ///< one a thread, and if there are several, one of all planes
};

}  // namespace mss
