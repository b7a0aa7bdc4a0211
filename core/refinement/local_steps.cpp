#include "core/refinement/local_steps.hpp"

#include <algorithm>

#include "core/kernels/sweep.hpp"

namespace mss {

template <class Real>
LocalSteps<Real>::LocalSteps(RefinedSystem<Real>& system, const Environment& of_level, double dt, int threads)
    : SystemWrapper<Real>(system),
      system_(system),
      plan_(system.local_step_plan()),
      dt_(dt),
      short_step_(system.kernel().short_step) {
  for (const Level& level : system.levels()) {
    moved_.emplace_back(level.body.lattice().size);
    inverse_mass_.emplace_back(level.body.lattice().size);
    for (const std::ptrdiff_t site : level.body.sites())
      if (const double mass = system.mass(level.first + site); mass > 0)
        inverse_mass_.back().set(site, Vec3::Constant(1 / mass));
  }
  rates_.resize(1 + plan_.rates.size());
  for (std::size_t r = 0; r < plan_.rates.size(); ++r) rates_[r + 1].first_level = plan_.rates[r].first_level;
  const std::vector<Flags> fast = find_fast();
  split_cells(fast, of_level, threads);
  find_spans(fast);
  find_short_steps();
}

/// By rate: which particles take its steps or shorter ones.
template <class Real>
auto LocalSteps<Real>::find_fast() const -> std::vector<Flags> {
  std::vector<Flags> fast(rates_.size());
  for (std::size_t r = 0; r < rates_.size(); ++r) {
    for (std::size_t level = 0; level < system_.levels().size(); ++level)
      fast[r].emplace_back(std::size_t(system_.levels()[level].body.lattice().size),
                           level >= rates_[r].first_level);
    for (const HangingParticle& p : system_.body().hanging())
      for (std::size_t m = 0; m < p.count && p.level == rates_[r].first_level; ++m)
        fast[r][p.level - 1][std::size_t(p.masters[m])] = true;
  }
  return fast;
}

/// A cell has the quickest rate of its corners.
template <class Real>
void LocalSteps<Real>::split_cells(const std::vector<Flags>& fast, const Environment& of_level, int threads) {
  for (std::size_t level = 0; level < system_.levels().size(); ++level) {
    const Body& body = system_.levels()[level].body;
    const Lattice& lattice = body.lattice();
    const auto [nx, ny, nz] = body.config().voxels.size();
    std::vector<BodyConfig> of_rate(rates_.size(), body.config());
    for (BodyConfig& config : of_rate) config.voxels = VoxelGrid(nx, ny, nz);
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
          if (!body.config().voxels.at(i, j, k)) continue;
          std::size_t rate = rates_.size() - 1;
          const auto touches = [&] {
            for (int c = 0; c < 8; ++c)
              if (fast[rate][level][std::size_t(lattice.site(i, j, k) + lattice.corner(c))]) return true;
            return false;
          };
          while (!touches()) --rate;
          of_rate[rate].voxels.set(i, j, k, true);
        }
    for (std::size_t r = 0; r < rates_.size(); ++r)
      if (of_rate[r].voxels.count() > 0)
        rates_[r].parts.push_back(std::make_unique<Part>(level, of_rate[r], of_level, threads));
  }
}

/// What forces of a rate's cells act on, or of quicker ones.
template <class Real>
void LocalSteps<Real>::find_spans(const std::vector<Flags>& fast) {
  const std::vector<Level>& levels = system_.levels();
  const auto in_field = [&](std::size_t level, std::ptrdiff_t site) {
    return std::size_t(system_.body().site_in_field(level, site));
  };
  Field<Real> is_free(this->size());
  is_free.array() = Real(1);
  system_.clear_prescribed(is_free);
  std::vector<bool> acts(std::size_t(this->size()));
  for (std::size_t r = rates_.size(); r-- > 0;) {
    for (const auto& part : rates_[r].parts)
      for (const std::ptrdiff_t site : part->body.sites()) acts[in_field(part->level, site)] = true;
    for (const HangingParticle& p : system_.body().hanging())
      for (std::size_t m = 0; m < p.count; ++m)
        if (acts[in_field(p.level, p.site)]) acts[in_field(p.level - 1, p.masters[m])] = true;
    for (std::size_t level = 0; level < levels.size(); ++level) {
      const Lattice& lattice = levels[level].body.lattice();
      const auto acts_in = [&](int plane) {
        const auto from = acts.begin() + std::ptrdiff_t(in_field(level, lattice.plane * plane));
        return std::find(from, from + lattice.used(), true) != from + lattice.used();
      };
      int first = 0, last = lattice.planes();
      while (first < last && !acts_in(first)) ++first;
      while (first < last && !acts_in(last - 1)) --last;
      rates_[r].force.emplace_back(r == 0 || first < last ? Field<Real>(lattice.size) : Field<Real>());
      if (r == 0 || first == last) continue;
      Span& span = rates_[r].spans.emplace_back(level, lattice, first, last);
      for (std::ptrdiff_t site = lattice.plane * first, i = 0; site < lattice.plane * last; ++site, ++i) {
        for (int axis = 0; axis < 3; ++axis)
          span.mobility.axis(axis)[i] = is_free.axis(axis)[std::ptrdiff_t(in_field(level, site))] *
                                        inverse_mass_[level].axis(axis)[site];
        if (level < rates_[r].first_level)
          span.moves.push_back(Real(fast[r][level][std::size_t(site)] ? 1 : 0));
      }
    }
  }
}

template <class Real>
void LocalSteps<Real>::find_short_steps() {
  const std::vector<ChebyshevFilter> filters = filters_of(plan_.rates, system_.spectral_bound().damping, dt_);
  double dt = dt_;
  for (std::size_t r = 1; r < rates_.size(); ++r) {
    const ChebyshevFilter& c = filters[r - 1];
    const auto at = [&](int k) { return c.value[std::size_t(k)]; };
    const int p = plan_.rates[r - 1].substeps;
    for (int k = 0; k < p; ++k)
      rates_[r].short_steps.push_back(
          {.of_now = static_cast<Real>(k == 0 ? 0 : 2 * c.delta * at(k) / at(k + 1)),
           .of_before = static_cast<Real>(k < 2 ? 0 : at(k - 1) / at(k + 1)),  // d_0 = 0
           .of_acceleration =
               static_cast<Real>((k == 0 ? 1 / c.delta : 2 * at(k) / at(k + 1)) / c.w * dt * dt)});
    rates_[r].acceleration_of_move = static_cast<Real>(2 / (dt * dt));
    dt /= p;
  }
}

/// Leaves in the rate's forces, and in the moves of the next one, what gives the accelerations at the present
/// positions.
template <class Real>
void LocalSteps<Real>::respond(std::size_t r, double t) {
  sum_forces(r, t);
  if (r + 1 < rates_.size()) take_short_steps(r + 1, t);
}

template <class Real>
void LocalSteps<Real>::sum_forces(std::size_t r, double t) {
  Levels& force = rates_[r].force;
  std::vector<std::unique_ptr<Part>>& parts = rates_[r].parts;
  for (std::size_t level = 0, i = 0; level < force.size(); ++level) {
    const bool has_part = i < parts.size() && parts[i]->level == level;
    if (has_part)
      parts[i++]->system.force(t, moved_[level], system_.levels_[level]->state.v, force[level]);
    else
      force[level].array() = Real(0);
  }
  for (const auto& part : parts)
    if (part->level > 0 && force[part->level - 1].size() > 0)
      system_.transfer_.scatter_to_masters(part->level, force[part->level], force[part->level - 1]);
  if (r > 0) return;
  for (const auto& loaded : system_.loaded_)
    for (int axis = 0; axis < 3; ++axis)
      force[loaded.level].axis(axis)[loaded.site] += static_cast<Real>(loaded.force[axis]);
}

/// Leaves d_p in `now`, and positions as they are, but for those of particles that hang.
template <class Real>
void LocalSteps<Real>::take_short_steps(std::size_t r, double t) {
  freeze(r);
  const std::size_t count = rates_[r].short_steps.size();
  for (std::size_t k = 0; k < count; ++k) {
    respond(r, t);
    displace(r, k);
    for (std::size_t level = rates_[r].first_level; level < moved_.size() && k + 1 < count; ++level)
      system_.transfer_.interpolate(level, moved_[level - 1], moved_[level]);
  }
}

template <class Real>
void LocalSteps<Real>::freeze(std::size_t r) {
  for (Span& span : rates_[r].spans) {
    const std::ptrdiff_t plane = system_.levels()[span.level].body.lattice().plane;
    const Span* outer = span_of(r - 1, span.level);
    for (int axis = 0; axis < 3; ++axis) {
      const std::ptrdiff_t count = plane * (span.last - span.first);
      const Real* slower = rates_[r - 1].force[span.level].axis(axis) + plane * span.first;
      Real* frozen = span.frozen.axis(axis);
      if (!outer) {
        std::copy_n(slower, count, frozen);
        continue;
      }
      const Real* frozen_there = outer->frozen.axis(axis) + plane * (span.first - outer->first);
      for (std::ptrdiff_t i = 0; i < count; ++i) frozen[i] = frozen_there[i] + slower[i];
    }
  }
}

/// From d_k to d_{k+1}, with accelerations under the forces, or those that a quicker rate has found from
/// them.
template <class Real>
void LocalSteps<Real>::displace(std::size_t r, std::size_t k) {
  for (Span& span : rates_[r].spans) {
    for (int plane = span.first; plane < span.last; ++plane) displace_plane(r, k, span, plane);
    std::swap(span.before, span.now);
  }
}

template <class Real>
void LocalSteps<Real>::displace_plane(std::size_t r, std::size_t k, Span& span, int plane) {
  const Rate& rate = rates_[r];
  const ShortStep& step = rate.short_steps[k];
  const Lattice& lattice = system_.levels()[span.level].body.lattice();
  const Span* inner = r + 1 < rates_.size() ? span_of(r + 1, span.level) : nullptr;
  if (inner && (plane < inner->first || plane >= inner->last)) inner = nullptr;
  const std::ptrdiff_t at = lattice.plane * (plane - span.first), in_level = lattice.plane * plane;
  ShortStepPlane<Real> p{};
  p.count = lattice.used();
  p.of_now = step.of_now;
  p.of_before = step.of_before;
  p.of_acceleration = step.of_acceleration;
  if (inner) p.of_acceleration *= rates_[r + 1].acceleration_of_move;
  p.moves = span.moves.empty() ? nullptr : span.moves.data() + at;
  p.last = k + 1 == rate.short_steps.size();
  for (int axis = 0; axis < 3; ++axis) {
    p.acceleration = inner ? inner->now.axis(axis) + lattice.plane * (plane - inner->first) : nullptr;
    p.mobility = span.mobility.axis(axis) + at;
    p.frozen = span.frozen.axis(axis) + at;
    p.force = rate.force[span.level].axis(axis) + in_level;
    p.now = k == 0 ? nullptr : span.now.axis(axis) + at;
    p.next = span.before.axis(axis) + at;
    p.position = moved_[span.level].axis(axis) + in_level;
    short_step_(p);
  }
}

template <class Real>
auto LocalSteps<Real>::span_of(std::size_t r, std::size_t level) const -> const Span* {
  for (const Span& span : rates_[r].spans)
    if (span.level == level) return &span;
  return nullptr;
}

/// Of all levels, from their positions and velocities.
template <class Real>
void LocalSteps<Real>::accelerate(double t) {
  for (std::size_t level = 0; level < moved_.size(); ++level) moved_[level] = system_.levels_[level]->state.x;
  respond(0, t);
  for (std::size_t level = 0; level < inverse_mass_.size(); ++level)
    system_.levels_[level]->a.array() = rates_[0].force[level].array() * inverse_mass_[level].array();
  for (const Span& span : rates_[1].spans) {
    const std::ptrdiff_t plane = system_.levels()[span.level].body.lattice().plane;
    for (int axis = 0; axis < 3; ++axis)
      std::transform(span.now.axis(axis), span.now.axis(axis) + plane * (span.last - span.first),
                     system_.levels_[span.level]->a.axis(axis) + plane * span.first,
                     [&](Real move) { return rates_[1].acceleration_of_move * move; });
  }
  system_.finish_accelerations(t);
}

template <class Real>
void LocalSteps<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  if (!has_short_steps()) return system_.acceleration(t, x, v, a);
  system_.load_state(x, v);
  accelerate(t);
  system_.store_accelerations(a);
}

template <class Real>
double LocalSteps<Real>::threads_working() const {
  double most = 1;
  for (const Rate& rate : rates_)
    for (const auto& part : rate.parts) most = std::max(most, part->system.threads_working());
  return most;
}

template <class Real>
void LocalSteps<Real>::kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) {
  if (!has_short_steps()) return system_.kick_drift(update, dt, steps, state);
  system_.step_levels(update, dt, steps, state, [this](double t) { accelerate(t); });
}

template class LocalSteps<float>;
template class LocalSteps<double>;

}  // namespace mss
