#include "core/springs/sweep_pipeline.hpp"

#include <algorithm>

namespace mss {

namespace {

template <class Real>
Streams<Real> streams(Field<Real>& f, std::ptrdiff_t offset = 0) {
  return {{f.axis(0) + offset, f.axis(1) + offset, f.axis(2) + offset}};
}
template <class Real>
ConstStreams<Real> const_streams(const Field<Real>& f, std::ptrdiff_t offset = 0) {
  return {{f.axis(0) + offset, f.axis(1) + offset, f.axis(2) + offset}};
}
template <class Real>
ConstStreams<Real> read_only(const Streams<Real>& s) {
  return {{s.axis[0], s.axis[1], s.axis[2]}};
}

}  // namespace

/// Planes [first, last) that one thread sweeps at a time, and scratch planes.
template <class Real>
struct alignas(128) SweepPipeline<Real>::Slab {
  Slab(int first_plane, int last_plane, std::ptrdiff_t scratch)
      : first(first_plane), last(last_plane), own(scratch), first_own(scratch), outgoing(scratch) {
    for (auto& field : above) field = Field<Real>(scratch);
  }
  int first;
  int last;
  Field<Real> own;                   ///< sums of the current plane
  Field<Real> first_own;             ///< sums of the first plane, kept until the slab below is done
  Field<Real> outgoing;              ///< contribution of the last plane to the slab above
  std::array<Field<Real>, 2> above;  ///< contributions between planes, alternating
};

template <class Real>
SweepPipeline<Real>::SweepPipeline(const BodySystem<Real>& system, ThreadTeam& team,
                                   const SleepTracker<Real>* sleep_tracker, const SweepKernel<Real>& kernel)
    : system_(system),
      body_(system.body()),
      team_(team),
      sleep_tracker_(sleep_tracker),
      kernel_(kernel),
      halo_(body_.ranks().are_several() ? std::make_unique<Halo<Real>>(body_) : nullptr),
      blocks_(body_, kernel.lanes),
      coefficients_(body_, blocks_, kernel) {
  build_masses();
  const std::ptrdiff_t scratch = body_.lattice().plane;
  nothing_below_ = Field<Real>(scratch);
  const int swept = body_.own_planes().last, slabs = team.size();  // a ghost plane below them too
  const auto bound = [&](int slab) { return int(std::int64_t(swept) * slab / slabs); };
  for (int slab = 0; slab < slabs; ++slab)
    slabs_.push_back(std::make_unique<Slab>(bound(slab), bound(slab + 1), scratch));
  if (slabs > 1) slabs_.push_back(std::make_unique<Slab>(0, swept, scratch));
}

template <class Real>
SweepPipeline<Real>::~SweepPipeline() = default;

/// For blocks of a plane, whose forces are still to be set.
template <class Real>
FinishPlane<Real> SweepPipeline<Real>::update_of(int plane, std::span<const BlockRun> runs,
                                                 const KickDrift& update, State<Real>& state) const {
  const std::ptrdiff_t offset = body_.lattice().plane * plane;
  FinishPlane<Real> p{};
  p.first_run = runs.data();
  p.last_run = runs.data() + runs.size();
  p.x = streams(state.x, offset);
  p.v = streams(state.v, offset);
  p.kick_before = static_cast<Real>(update.kick_before);
  p.kick_after = static_cast<Real>(update.kick_after);
  p.drift_old = static_cast<Real>(update.drift_old);
  p.drift_new = static_cast<Real>(update.drift_new);
  return p;
}

/// The same where a result is stored.
template <class Real>
FinishPlane<Real> SweepPipeline<Real>::result_of(int plane, std::span<const BlockRun> runs,
                                                 const SweepPass<Real>& pass) const {
  const std::ptrdiff_t offset = body_.lattice().plane * plane;
  FinishPlane<Real> p{};
  p.first_run = runs.data();
  p.last_run = runs.data() + runs.size();
  // NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): a pass that stores a result has it
  p.out = streams(*pass.out, offset);
  p.direction = const_streams(*pass.v, offset);
  p.mass = static_cast<Real>(pass.sum.mass);
  return p;
}

template <class Real>
void SweepPipeline<Real>::run(const SweepPass<Real>& pass, long steps) {
  constexpr long together = 16;  // they end together, which costs a hand-over
  for (long done = 0; done < steps;) {
    if (halo_) halo_->exchange(*pass.x, *pass.v);
    if (team_.works_alone()) {
      Slab& all = *slabs_.back();
      sweep_planes(pass, all, all.first, all.last, done++);
      continue;
    }
    const long some = halo_ ? 1 : std::min(together, steps - done);
    const auto task = [&, done](int slab, SlabPart part, long step) {
      sweep_part(pass, slab, part, done + step);
    };
    team_.run_steps(some, std::ref(task));
    done += some;
  }
}

/// Whether a plane is swept for what its cells add to the next one alone: a ghost, or asleep.
template <class Real>
bool SweepPipeline<Real>::stays_unfinished(const SweepPass<Real>& pass, int plane) const {
  if (plane < body_.own_planes().first) return true;
  return sleep_tracker_ && pass.moves_particles() && sleep_tracker_->asleep(plane);
}

template <class Real>
bool SweepPipeline<Real>::needs_cells(const SweepPass<Real>& pass, int plane) const {
  return !sleep_tracker_ || !pass.moves_particles() || sleep_tracker_->needs_cells(plane);
}

template <class Real>
void SweepPipeline<Real>::sweep_part(const SweepPass<Real>& pass, int index, SlabPart part, long step) {
  Slab& slab = *slabs_[std::size_t(index)];
  if (part != SlabPart::seam) {
    const int edge = slab.last - 1;
    sweep_planes(pass, slab, part == SlabPart::inner ? slab.first : edge,
                 part == SlabPart::inner ? edge : slab.last, step);
  } else if (slab.first > 0 && !stays_unfinished(pass, slab.first)) {
    const Slab& lower = *slabs_[std::size_t(index) - 1];
    finish_runs(pass, slab.first, blocks_.of(slab.first), streams(slab.first_own),
                const_streams(lower.outgoing), pass.end_of(step));
  }
}

/// Some planes of a slab, whose first one stays unfinished unless it is the lowest of all.
template <class Real>
void SweepPipeline<Real>::sweep_planes(const SweepPass<Real>& pass, Slab& slab, int first, int last,
                                       long step) {
  for (int plane = first; plane < last; ++plane) {
    if (!needs_cells(pass, plane)) continue;
    const auto turn = std::size_t(plane & 1);
    const Streams<Real> above = streams(plane + 1 == slab.last ? slab.outgoing : slab.above[turn]);
    if (plane == slab.first && plane > 0) {
      sweep_plane(pass, plane, streams(slab.first_own), above, nullptr, pass.end_of(step));
    } else {
      const ConstStreams<Real> below = const_streams(plane == 0 ? nothing_below_ : slab.above[1 - turn]);
      sweep_plane(pass, plane, streams(slab.own), above, stays_unfinished(pass, plane) ? nullptr : &below,
                  pass.end_of(step));
    }
  }
}

template <class Real>
Sweep<Real> SweepPipeline<Real>::sweep_for(const SweepPass<Real>& pass) const {
  const Sweeps<Real>& sweeps = body_.config().fold_guard != 0 ? kernel_.guarded : kernel_.plain;
  const bool projected = pass.sum.kind == Tangent::projected;
  const auto& diagonal = projected ? sweeps.projected_diagonal : sweeps.elastic_diagonal;
  switch (pass.finish) {
    case SweepPass<Real>::product:
      return projected ? sweeps.projected : sweeps.elastic;
    case SweepPass<Real>::straight_diagonal:
      return diagonal.straight;
    case SweepPass<Real>::mixed_diagonal:
      return diagonal.mixed;
    default:
      return coefficients_.force_sweep(sweeps);
  }
}

/// Sweeps a plane in pieces and, if `below` is given, finishes each at once: no later block reads those
/// particles again.
template <class Real>
void SweepPipeline<Real>::sweep_plane(const SweepPass<Real>& pass, int plane, const Streams<Real>& own,
                                      const Streams<Real>& above, const ConstStreams<Real>* below, double t) {
  const Lattice& lattice = body_.lattice();
  const std::ptrdiff_t offset = lattice.plane * plane;
  for (const BlockRun& run : blocks_.zeroed(plane))
    for (int a = 0; a < 3; ++a) {
      std::fill(own.axis[a] + run.first, own.axis[a] + run.last, Real(0));
      std::fill(above.axis[a] + run.first, above.axis[a] + run.last, Real(0));
    }
  if (pass.out) clear_between_blocks(plane, *pass.out);
  const Sweep<Real> sweep = sweep_for(pass);
  SweepPlane<Real> p{};
  p.row = lattice.row;
  p.plane = lattice.plane;
  coefficients_.describe(blocks_.before(plane), pass.springs, p);
  p.x = const_streams(*pass.x, offset);
  p.v = const_streams(*pass.v, offset);
  p.stiffness = static_cast<Real>(pass.sum.stiffness);
  p.damping = static_cast<Real>(pass.sum.damping);
  p.own = own;
  p.above = above;
  const std::span<const BlockRun> runs = blocks_.of(plane);
  for (std::size_t first = 0, next = 0; first < runs.size(); first = next) {
    std::ptrdiff_t blocks = 0;
    while (next < runs.size() && blocks + blocks_.count(runs[next]) <= SweepBlocks::piece)
      blocks += blocks_.count(runs[next++]);
    const auto piece = runs.subspan(first, next - first);
    p.first_run = piece.data();
    p.last_run = piece.data() + piece.size();
    sweep(p);
    p.entry += blocks;
    if (below) finish_runs(pass, plane, piece, own, *below, t);
  }
}

/// Zeroes the sites of a plane that no block holds.
template <class Real>
void SweepPipeline<Real>::clear_between_blocks(int plane, Field<Real>& out) const {
  const std::ptrdiff_t offset = body_.lattice().plane * plane;
  std::ptrdiff_t end = 0;
  const auto clear_to = [&](std::ptrdiff_t next) {
    for (int a = 0; a < 3; ++a) std::fill(out.axis(a) + offset + end, out.axis(a) + offset + next, Real(0));
  };
  for (const BlockRun& run : blocks_.of(plane)) {
    clear_to(run.first);
    end = run.last;
  }
  clear_to(std::max(end, body_.lattice().used()));
}

template <class Real>
void SweepPipeline<Real>::finish_runs(const SweepPass<Real>& pass, int plane, std::span<const BlockRun> runs,
                                      const Streams<Real>& own, const ConstStreams<Real>& below, double t) {
  if (runs.empty()) return;
  const std::ptrdiff_t offset = body_.lattice().plane * plane, first = runs.front().first,
                       last = runs.back().last;
  const bool moves = pass.finish == SweepPass<Real>::kick_drift;
  if (!system_.loads().empty() && pass.takes_loads())
    system_.loads().add(moves ? t - pass.dt : t, offset + first, offset + last,
                        std::array<Real*, 3>{own.axis[0] + first, own.axis[1] + first, own.axis[2] + first});
  FinishPlane<Real> p =
      moves ? update_of(plane, runs, pass.update, *pass.state) : result_of(plane, runs, pass);
  p.own = read_only(own);
  p.below = below;
  p.inverse_mass = inverse_mass_.data() + offset;
  for (int a = 0; a < 3; ++a) p.gravity[a] = static_cast<Real>(system_.environment().gravity[a]);
  if (!moves) {
    (pass.finish == SweepPass<Real>::acceleration ? kernel_.store_acceleration
     : pass.finish == SweepPass<Real>::product    ? kernel_.store_product
                                                  : kernel_.store_force)(p);
    return;
  }
  kernel_.kick_drift(p);
  if (!system_.held().empty())
    system_.held().apply(t, offset + first, offset + last, pass.state->x, pass.state->v);
}

template <class Real>
void SweepPipeline<Real>::build_masses() {
  inverse_mass_ = AlignedArray<Real>(body_.lattice().size);
  for (const std::ptrdiff_t site : body_.sites())
    inverse_mass_[site] = static_cast<Real>(1 / body_.mass(site));
}

template <class Real>
void SweepPipeline<Real>::apply(const KickDrift& update, const Field<Real>& a, State<Real>& state) const {
  const auto [first, last] = body_.own_planes();
  for (int plane = first; plane < last; ++plane) {
    FinishPlane<Real> p = update_of(plane, blocks_.of(plane), update, state);
    p.own = const_streams(a, body_.lattice().plane * plane);
    kernel_.kick_drift_stored(p);
  }
}

template class SweepPipeline<float>;
template class SweepPipeline<double>;

}  // namespace mss
