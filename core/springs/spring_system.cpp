#include "core/springs/spring_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "core/base/error.hpp"
#include "core/forces/cell_geometry.hpp"
#include "core/forces/fold_guard.hpp"
#include "core/forces/spring_law.hpp"
#include "core/springs/element_tangents.hpp"

namespace mss {

namespace {

static_assert(springs_per_site == int(spring_slots.size()) && weights_per_lane == spring_groups);

template <class Real>
SweepKernel<Real> find_kernel(const std::string& name) {
  const auto& kernels = runnable_copies<SweepKernel<Real>>();
  if (name.empty()) return kernels.back();
  std::string known;
  for (const auto& kernel : kernels) {
    if (kernel.name == name) return kernel;
    known += (known.empty() ? "" : ", ") + std::string(kernel.name);
  }
  throw InputError(
      fmt::format("kernel '{}' is unknown or needs another processor; this one runs {}", name, known));
}

/// The requested number of threads, at most one a plane; by default as many as pay: what a step of 2000
/// springs a thread takes, some 4 us, is a few times what it costs to share it. Where several ranks share the
/// body, they have the cores already.
int team_size(const Body& body, int requested) {
  const int planes = body.own_planes().last;
  if (requested == 0 && body.ranks().are_several()) return 1;
  if (requested > 0) return std::min(requested, planes);
  const int worth_it = int(std::min<std::size_t>(body.spring_count() / 2000, 1024));
  return std::clamp(std::min(available_cores(), worth_it), 1, planes);
}

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
struct alignas(128) SpringSystem<Real>::Slab {
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

/// One kind of pass over the body: what is read, and how a complete force is used.
template <class Real>
struct SpringSystem<Real>::Pass {
  Finish finish;
  double t;  ///< at the beginning of the first step
  double dt;
  const Field<Real>* x;
  const Field<Real>* v;          ///< product: the directions
  Field<Real>* out = nullptr;    ///< but for kick_drift: the result
  State<Real>* state = nullptr;  ///< kick_drift: updated in place
  KickDrift update{};
  TangentSum sum{};     ///< of a product or diagonal
  bool springs = true;  ///< false: as if there were none

  double end_of(long step) const { return t + double(step + 1) * dt; }
  /// Whether what is added up are forces.
  bool takes_loads() const { return finish == Finish::force || moves_particles(); }
  /// Whether planes that sleep are skipped.
  bool moves_particles() const { return finish == Finish::kick_drift || finish == Finish::acceleration; }
};

template <class Real>
SpringSystem<Real>::SpringSystem(const Body& body, const Environment& environment, const Execution& execution)
    : SpringSystem(body, environment, find_kernel<Real>(execution.kernel), execution) {}

template <class Real>
SpringSystem<Real>::SpringSystem(const Body& body, const Environment& environment,
                                 const SweepKernel<Real>& kernel, const Execution& execution)
    : BodySystem<Real>(body, environment, mss::spectral_bound(body), team_size(body, execution.threads),
                       execution.sleep),
      tangents_(*this),
      discrete_gradient_(body),
      kernel_(kernel),
      halo_(body.ranks().are_several() ? std::make_unique<Halo<Real>>(body) : nullptr),
      blocks_(body, kernel.lanes),
      own_dampings_(!body.damping_time()),
      cell_weights_(has_cell_weights()) {
  const Lattice& lattice = body.lattice();
  interior_ = interior_coefficients();
  build_dictionary();
  build_masses();
  const std::ptrdiff_t scratch = lattice.plane;
  nothing_below_ = Field<Real>(scratch);
  const int swept = body.own_planes().last, slabs = this->team().size();  // a ghost plane below them too
  const auto bound = [&](int slab) { return int(std::int64_t(swept) * slab / slabs); };
  for (int slab = 0; slab < slabs; ++slab)
    slabs_.push_back(std::make_unique<Slab>(bound(slab), bound(slab + 1), scratch));
  if (slabs > 1) slabs_.push_back(std::make_unique<Slab>(0, swept, scratch));
}

template <class Real>
SpringSystem<Real>::~SpringSystem() = default;

template <class Real>
InteriorCoefficients<Real> SpringSystem<Real>::interior_coefficients() const {
  const Body& body = this->body();
  InteriorCoefficients<Real> c{};
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    const double k = body.interior_stiffness(s);
    c.stiffness[s] = static_cast<Real>(k);
    c.rest_pull[s] = static_cast<Real>(k * body.rest_length(spring_slots[s].kind) / kernel_.rsqrt_scale);
    c.rest_length[s] = static_cast<Real>(body.rest_length(spring_slots[s].kind) / kernel_.rsqrt_scale);
    c.damping[s] = static_cast<Real>(k * body.damping_time().value_or(0) /
                                     (double(kernel_.rsqrt_scale) * double(kernel_.rsqrt_scale)));
  }
  c.volume = static_cast<Real>(body.interior_volume() / (64 * body.cell_volume()));
  c.guard = static_cast<Real>(guarded_corner_stiffness(body.interior_fold_guard(), body.config().cell_size));
  return c;
}

/// Whether k_vol and k_g have weights of their own, beside those of the body diagonals.
template <class Real>
bool SpringSystem<Real>::has_cell_weights() const {
  const std::vector<SiteWeights>& all = this->body().weights();
  return std::any_of(all.begin(), all.end(), [](const SiteWeights& w) {
    return w.volume != w.spring.back() || w.fold_guard != w.spring.back();
  });
}

/// Blocks with equal sites share an entry: a large box has a few dozen.
template <class Real>
void SpringSystem<Real>::build_dictionary() {
  const Lattice& lattice = this->body().lattice();
  const auto width = std::size_t(kernel_.lanes);
  std::map<std::vector<std::uint32_t>, std::uint32_t> entry_of;
  std::vector<std::uint32_t> kinds(width);
  entry_.reserve(blocks_.before(lattice.planes()) + 2);
  for (int k = 0; k < lattice.planes(); ++k)
    for (const BlockRun& run : blocks_.of(k))
      for (std::ptrdiff_t first = run.first; first < run.last; first += kernel_.lanes) {
        const std::ptrdiff_t site = lattice.plane * k + first;
        for (std::size_t lane = 0; lane < width; ++lane)
          kinds[lane] = this->body().element_kind(site + std::ptrdiff_t(lane));
        entry_.push_back(entry_of.try_emplace(kinds, std::uint32_t(entry_of.size())).first->second);
      }

  entry_.insert(entry_.end(), 2, 0);  // a sweep looks ahead

  content_.assign(entry_of.size(), 0);
  whole_content_ = content_of_all_kinds();
  const std::size_t per_lane =
      weights_per_lane + (own_dampings_ ? springs_per_site : 0U) + (cell_weights_ ? 2U : 0U);
  dictionary_ = AlignedArray<Real>(std::ptrdiff_t(entry_of.size() * width * per_lane));
  for (const auto& [lane_kinds, entry] : entry_of) {
    Real* coefficients = dictionary_.data() + std::size_t(entry) * width * per_lane;
    std::uint32_t content = 0;
    for (std::size_t lane = 0; lane < width; ++lane)
      content |= fill_lane(lane_kinds[lane], coefficients + lane);
    content_[entry] = content;
  }
}

template <class Real>
std::uint32_t SpringSystem<Real>::content_of(const SiteElements& e) {
  std::uint32_t content = (e.volume != 0 ? block_volumes : 0U) | (e.fold_guard != 0 ? block_guards : 0U);
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    if (e.stiffness[s] == 0) continue;
    const auto of = spring_slots[s].kind;
    content |= of == SpringSlot::Class::edge   ? block_edges
               : of == SpringSlot::Class::face ? block_faces
                                               : block_bodies;
  }
  return content;
}

/// Of the whole body, so that all ranks sweep with the same code.
template <class Real>
std::uint32_t SpringSystem<Real>::content_of_all_kinds() const {
  std::uint32_t content = 0;
  for (std::uint32_t kind = 0; kind < this->body().weights().size(); ++kind)
    content |= content_of(this->body().elements(kind));
  return content;
}

/// Writes one lane of a block's coefficients and returns its contents.
template <class Real>
std::uint32_t SpringSystem<Real>::fill_lane(std::uint32_t kind, Real* coefficients) const {
  const std::ptrdiff_t width = kernel_.lanes;
  const double scale2 = double(kernel_.rsqrt_scale) * double(kernel_.rsqrt_scale);
  const SiteWeights& weights = this->body().weights()[kind];
  const SiteElements e = this->body().elements(kind);
  for (const double weight : weights.spring) {
    *coefficients = static_cast<Real>(weight);
    coefficients += width;
  }
  for (std::size_t s = 0; own_dampings_ && s < spring_slots.size(); ++s) {
    *coefficients = static_cast<Real>(e.damping[s] / scale2);
    coefficients += width;
  }
  if (cell_weights_) {
    coefficients[0] = static_cast<Real>(weights.volume);
    coefficients[width] = static_cast<Real>(weights.fold_guard);
  }
  return content_of(e);
}

template <class Real>
void SpringSystem<Real>::build_masses() {
  inverse_mass_ = AlignedArray<Real>(this->body().lattice().size);
  for (const std::ptrdiff_t site : this->body().sites())
    inverse_mass_[site] = static_cast<Real>(1 / this->body().mass(site));
}

template <class Real>
StoredEnergy SpringSystem<Real>::stored_energy(const Field<Real>& x) const {
  StoredEnergy energy;
  const Ranks& ranks = this->body().ranks();
  ranks.add_in_order(energy, [&] { add_energy_of_springs(x, energy); });
  ranks.add_in_order(energy, [&] { add_energy_of_cells(x, energy); });
  return energy;
}

template <class Real>
void SpringSystem<Real>::add_energy_of_springs(const Field<Real>& x, StoredEnergy& energy) const {
  this->body().for_each_spring(
      [&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot& slot, double stiffness, double) {
        energy.elastic +=
            spring_energy(stiffness, this->body().rest_length(slot.kind), (x.at(b) - x.at(a)).norm());
      });
}

template <class Real>
void SpringSystem<Real>::add_energy_of_cells(const Field<Real>& x, StoredEnergy& energy) const {
  const double rest = this->body().cell_volume(), size = this->body().config().cell_size;
  this->body().for_each_cell([&](std::ptrdiff_t site) {
    const SiteWeights& weights = this->body().weights_at(site);
    const double volume = weights.volume * this->body().interior_volume(),
                 guard = weights.fold_guard * this->body().interior_fold_guard();
    const double change = thesis_volume(corners_of(this->body(), x, site)) - rest;
    energy.volume += 0.5 * volume * change * change / rest;
    if (guard != 0)
      energy.elastic += fold_guard_energy(guarded_corner_stiffness(guard, size), guarded_length(size),
                                          corners_of(this->body(), x, site));
  });
}

template <class Real>
void SpringSystem<Real>::force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) {
  run({.finish = Finish::force, .t = t, .dt = 0, .x = &x, .v = &v, .out = &f}, 1);
  this->add_gravity(f);
  this->add_penalty_force(x, v, f);
}

template <class Real>
void SpringSystem<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  run({.finish = Finish::acceleration, .t = t, .dt = 0, .x = &x, .v = &v, .out = &a}, 1);
  stop_sleeping(a);
  this->add_penalty_acceleration(x, v, a);
  this->stop_sticking(x, v, a);
  this->held().clear(a);
}

/// Zeroes the accelerations of planes that sleep.
template <class Real>
void SpringSystem<Real>::stop_sleeping(Field<Real>& a) const {
  if (!this->sleep_tracker()) return;
  const Lattice& lattice = this->body().lattice();
  for (int plane = 0; plane < lattice.planes(); ++plane)
    for (int axis = 0; axis < 3 && this->sleep_tracker()->asleep(plane); ++axis)
      std::fill_n(a.axis(axis) + lattice.plane * plane, lattice.plane, Real(0));
}

template <class Real>
void SpringSystem<Real>::SpringTangents::add(const Field<Real>& x, const Field<Real>& v,
                                             const TangentSum& sum, BlockMatrix& blocks) const {
  add_tangent(this->body(), x, v, sum, blocks);
}

template <class Real>
void SpringSystem<Real>::SpringTangents::add_diagonal(const Field<Real>& x, const Field<Real>&,
                                                      const TangentSum& sum,
                                                      std::vector<Eigen::Matrix3d>& diagonal) {
  if (straight_.size() == 0) straight_ = mixed_ = Field<Real>(system_.size());
  system_.diagonal_blocks(x, sum, straight_, mixed_);
  for (std::size_t p = 0; p < diagonal.size(); ++p) {
    const std::ptrdiff_t site = system_.particles()[p];
    diagonal[p].diagonal() += straight_.at(site);
    const Vec3 mixed = mixed_.at(site);
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      diagonal[p](b, c) += mixed[a];
      diagonal[p](c, b) += mixed[a];
    }
  }
}

template <class Real>
void SpringSystem<Real>::SpringTangents::multiply(double t, const Field<Real>& x, const Field<Real>&,
                                                  const TangentSum& sum, const Field<Real>& p,
                                                  Field<Real>& out) {
  system_.run({.finish = Finish::product, .t = t, .dt = 0, .x = &x, .v = &p, .out = &out, .sum = sum}, 1);
}

template <class Real>
void SpringSystem<Real>::diagonal_blocks(const Field<Real>& x, const TangentSum& sum, Field<Real>& straight,
                                         Field<Real>& mixed, bool springs) {
  Pass pass{.finish = Finish::straight_diagonal, .t = 0, .dt = 0, .x = &x, .v = &x, .out = &straight};
  pass.sum = sum;
  pass.springs = springs;
  if (!springs) pass.sum.damping = 0;
  run(pass, 1);
  pass.finish = Finish::mixed_diagonal;
  pass.out = &mixed;
  run(pass, 1);
}

template <class Real>
void SpringSystem<Real>::kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) {
  if (this->contact().has_penalties()) return System<Real>::kick_drift(update, dt, steps, state);
  run({.finish = Finish::kick_drift,
       .t = state.t,
       .dt = dt,
       .x = &state.x,
       .v = &state.v,
       .state = &state,
       .update = update},
      steps);
  state.t += double(steps) * dt;
}

/// For blocks of a plane, whose forces are still to be set.
template <class Real>
FinishPlane<Real> SpringSystem<Real>::update_of(int plane, std::span<const BlockRun> runs,
                                                const KickDrift& update, State<Real>& state) const {
  const std::ptrdiff_t offset = this->body().lattice().plane * plane;
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
FinishPlane<Real> SpringSystem<Real>::result_of(int plane, std::span<const BlockRun> runs,
                                                const Pass& pass) const {
  const std::ptrdiff_t offset = this->body().lattice().plane * plane;
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
void SpringSystem<Real>::apply(const KickDrift& update, const Field<Real>& a, double dt,
                               State<Real>& state) const {
  const auto [first, last] = this->body().own_planes();
  for (int plane = first; plane < last; ++plane) {
    FinishPlane<Real> p = update_of(plane, blocks_.of(plane), update, state);
    p.own = const_streams(a, this->body().lattice().plane * plane);
    kernel_.kick_drift_stored(p);
  }
  kicked_for(*this, update.kick_before + update.kick_after);
  state.t += dt;
  this->constrain(state.t, state.x, state.v);
}

template <class Real>
void SpringSystem<Real>::run(const Pass& pass, long steps) {
  Team& team = this->team();
  constexpr long together = 16;  // they end together, which costs a hand-over
  for (long done = 0; done < steps;) {
    if (halo_) halo_->exchange(*pass.x, *pass.v);
    if (team.works_alone()) {
      Slab& all = *slabs_.back();
      sweep_planes(pass, all, all.first, all.last, done++);
      continue;
    }
    const long some = halo_ ? 1 : std::min(together, steps - done);
    const auto task = [&, done](int slab, SlabPart part, long step) {
      sweep_part(pass, slab, part, done + step);
    };
    team.run_steps(some, std::ref(task));
    done += some;
  }
}

/// Whether a plane is swept for what its cells add to the next one alone: a ghost, or asleep.
template <class Real>
bool SpringSystem<Real>::stays_unfinished(const Pass& pass, int plane) const {
  if (plane < this->body().own_planes().first) return true;
  return this->sleep_tracker() && pass.moves_particles() && this->sleep_tracker()->asleep(plane);
}

template <class Real>
bool SpringSystem<Real>::needs_cells(const Pass& pass, int plane) const {
  return !this->sleep_tracker() || !pass.moves_particles() || this->sleep_tracker()->needs_cells(plane);
}

template <class Real>
void SpringSystem<Real>::sweep_part(const Pass& pass, int index, SlabPart part, long step) {
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
void SpringSystem<Real>::sweep_planes(const Pass& pass, Slab& slab, int first, int last, long step) {
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
Sweep<Real> SpringSystem<Real>::sweep_for(const Pass& pass) const {
  const Sweeps<Real>& sweeps = this->body().config().fold_guard != 0 ? kernel_.guarded : kernel_.plain;
  const bool projected = pass.sum.kind == Tangent::projected;
  const auto& diagonal = projected ? sweeps.projected_diagonal : sweeps.elastic_diagonal;
  switch (pass.finish) {
    case Finish::product:
      return projected ? sweeps.projected : sweeps.elastic;
    case Finish::straight_diagonal:
      return diagonal.straight;
    case Finish::mixed_diagonal:
      return diagonal.mixed;
    default:
      if (own_dampings_) return sweeps.own_dampings.for_content(whole_content_);
      return (this->body().config().is_damped() ? sweeps.weighted_dampers : sweeps.undamped)
          .for_content(whole_content_);
  }
}

/// Sweeps a plane in pieces and, if `below` is given, finishes each at once: no later block reads those
/// particles again.
template <class Real>
void SpringSystem<Real>::sweep_plane(const Pass& pass, int plane, const Streams<Real>& own,
                                     const Streams<Real>& above, const ConstStreams<Real>* below, double t) {
  const Lattice& lattice = this->body().lattice();
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
  p.entry = entry_.data() + blocks_.before(plane);
  p.dictionary = dictionary_.data();
  p.entry_size = dictionary_.size() / std::ptrdiff_t(content_.size());
  p.own_dampings = own_dampings_;
  const std::ptrdiff_t of_bodies = kernel_.lanes * (weights_per_lane - 1);
  p.volume_weight = cell_weights_ ? p.entry_size - 2 * kernel_.lanes : of_bodies;
  p.guard_weight = cell_weights_ ? p.entry_size - kernel_.lanes : of_bodies;
  p.content = content_.data();
  p.interior = interior_;
  if (!pass.springs) {
    std::fill(std::begin(p.interior.stiffness), std::end(p.interior.stiffness), Real(0));
    std::fill(std::begin(p.interior.rest_pull), std::end(p.interior.rest_pull), Real(0));
  }
  p.rest_volume = static_cast<Real>(this->body().cell_volume());
  p.guarded_length = static_cast<Real>(guarded_length(this->body().config().cell_size));
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
void SpringSystem<Real>::clear_between_blocks(int plane, Field<Real>& out) const {
  const std::ptrdiff_t offset = this->body().lattice().plane * plane;
  std::ptrdiff_t end = 0;
  const auto clear_to = [&](std::ptrdiff_t next) {
    for (int a = 0; a < 3; ++a) std::fill(out.axis(a) + offset + end, out.axis(a) + offset + next, Real(0));
  };
  for (const BlockRun& run : blocks_.of(plane)) {
    clear_to(run.first);
    end = run.last;
  }
  clear_to(std::max(end, this->body().lattice().used()));
}

template <class Real>
void SpringSystem<Real>::finish_runs(const Pass& pass, int plane, std::span<const BlockRun> runs,
                                     const Streams<Real>& own, const ConstStreams<Real>& below, double t) {
  if (runs.empty()) return;
  const std::ptrdiff_t offset = this->body().lattice().plane * plane, first = runs.front().first,
                       last = runs.back().last;
  if (!this->loads().empty() && pass.takes_loads())
    this->loads().add(offset + first, offset + last,
                      std::array<Real*, 3>{own.axis[0] + first, own.axis[1] + first, own.axis[2] + first});
  const bool moves = pass.finish == Finish::kick_drift;
  FinishPlane<Real> p =
      moves ? update_of(plane, runs, pass.update, *pass.state) : result_of(plane, runs, pass);
  p.own = read_only(own);
  p.below = below;
  p.inverse_mass = inverse_mass_.data() + offset;
  for (int a = 0; a < 3; ++a) p.gravity[a] = static_cast<Real>(this->environment().gravity[a]);
  if (!moves) {
    (pass.finish == Finish::acceleration ? kernel_.store_acceleration
     : pass.finish == Finish::product    ? kernel_.store_product
                                         : kernel_.store_force)(p);
    return;
  }
  kernel_.kick_drift(p);
  if (!this->held().empty())
    this->held().apply(t, offset + first, offset + last, pass.state->x, pass.state->v);
}

template class SpringSystem<float>;
template class SpringSystem<double>;

}  // namespace mss
