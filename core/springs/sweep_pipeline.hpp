#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/springs/body_system.hpp"
#include "core/springs/halo.hpp"
#include "core/springs/sweep_coefficients.hpp"

namespace mss {

/// One kind of pass over a body: what is read, and how a complete force is used.
template <class Real>
struct SweepPass {
  enum Finish { force, acceleration, product, straight_diagonal, mixed_diagonal, kick_drift };
  Finish finish;
  double t;  ///< at the beginning of the first step
  double dt;
  const Field<Real>* x;
  const Field<Real>* v;          ///< product: the directions
  Field<Real>* out = nullptr;    ///< but for kick_drift: the result
  State<Real>* state = nullptr;  ///< kick_drift: updated in place
  KickDrift update{};
  TangentCoefficients sum{};  ///< of a product or diagonal
  bool springs = true;        ///< false: as if there were none

  double end_of(long step) const { return t + double(step + 1) * dt; }
  /// Whether what is added up are forces.
  bool takes_loads() const { return finish == force || moves_particles(); }
  /// Whether planes that sleep are skipped.
  bool moves_particles() const { return finish == kick_drift || finish == acceleration; }
};

/// Sweeps a body with threads, slab by slab (thread_team.hpp), and uses a particle's force as soon as it is
/// complete.
///
/// Each thread has a slab of planes. A slab's first plane is finished last, after the slab below has added
/// its contribution. Where several ranks share the body, ghost planes are exchanged before each pass
/// (halo.hpp).
template <class Real>
class SweepPipeline {
 public:
  /// For a system, and its team and sleep (nullptr: nothing sleeps), which must outlive it.
  SweepPipeline(const BodySystem<Real>& system, ThreadTeam& team, const SleepTracker<Real>* sleep_tracker,
                const SweepKernel<Real>& kernel);
  ~SweepPipeline();

  void run(const SweepPass<Real>& pass, long steps);
  /// The update alone, from given accelerations.
  void apply(const KickDrift& update, const Field<Real>& a, State<Real>& state) const;
  const SweepKernel<Real>& kernel() const { return kernel_; }
  /// Fills the ghost planes of a state.
  void update_ghosts(const State<Real>& state) const {
    if (halo_) halo_->exchange(state.x, state.v);
  }

 private:
  struct Slab;
  bool stays_unfinished(const SweepPass<Real>& pass, int plane) const;
  bool needs_cells(const SweepPass<Real>& pass, int plane) const;
  Sweep<Real> sweep_for(const SweepPass<Real>& pass) const;
  void build_masses();
  void sweep_part(const SweepPass<Real>& pass, int slab, SlabPart part, long step);
  void sweep_planes(const SweepPass<Real>& pass, Slab& slab, int first, int last, long step);
  void sweep_plane(const SweepPass<Real>& pass, int plane, const Streams<Real>& own,
                   const Streams<Real>& above, const ConstStreams<Real>* below, double t);
  void finish_runs(const SweepPass<Real>& pass, int plane, std::span<const BlockRun> runs,
                   const Streams<Real>& own, const ConstStreams<Real>& below, double t);
  FinishPlane<Real> update_of(int plane, std::span<const BlockRun> runs, const KickDrift& update,
                              State<Real>& state) const;
  FinishPlane<Real> result_of(int plane, std::span<const BlockRun> runs, const SweepPass<Real>& pass) const;
  void clear_between_blocks(int plane, Field<Real>& out) const;

  const BodySystem<Real>& system_;
  const Body& body_;
  ThreadTeam& team_;
  const SleepTracker<Real>* sleep_tracker_;
  SweepKernel<Real> kernel_;
  std::unique_ptr<Halo<Real>> halo_;  ///< nullptr: no other process has a part of the body
  SweepBlocks blocks_;
  SweepCoefficients<Real> coefficients_;
  AlignedArray<Real> inverse_mass_;
  Field<Real> nothing_below_;                 ///< contribution from below to the lowest plane: zero
  std::vector<std::unique_ptr<Slab>> slabs_;  ///< one a thread, and if there are several, one of all planes
};

}  // namespace mss
