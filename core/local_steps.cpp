#include "core/local_steps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mss {

namespace {

/// Chebyshev's polynomials at delta, and w.
struct Damped {
  Damped(int p, double nu) : delta(1 + nu / (double(p) * p)), value{1, delta} {
    double slope = 1, before = 0;  // of T_1 and T_0
    for (int k = 1; k < p; ++k) {
      const double next = 2 * value[std::size_t(k)] + 2 * delta * slope - before;
      value.push_back(2 * delta * value[std::size_t(k)] - value[std::size_t(k) - 1]);
      before = slope;
      slope = next;
    }
    w = 2 * slope / value[std::size_t(p)];
  }
  double delta, w = 0;
  std::vector<double> value;
};

/// What keeps a damped mode at the edge of the filter's range stable: 4 - w^2 dt^2 >= 2 c dt.
double least_nu(double damping, double dt) {
  const double share = damping * dt;
  return std::max(0.01, 1.2 * share / (1 - share));
}

double largest_step(const SpectralBound& slow, const SpectralBound& fast, int p) {
  const double damping = std::max(slow.damping, fast.damping);
  double dt = 4 / (damping + std::hypot(damping, 2 * slow.omega));
  const auto is_stable = [&] {
    if (damping * dt > 0.4) return false;
    const Damped t(p, least_nu(damping, dt));
    return fast.omega * fast.omega * dt * dt <= t.w * (1 + t.delta);
  };
  while (!is_stable()) dt *= 0.99;
  return dt;
}

SpectralBound largest(const SpectralBound& a, const SpectralBound& b) {
  return {std::max(a.omega, b.omega), std::max(a.damping, b.damping)};
}

}  // namespace

LocalStepPlan plan_local_steps(const std::vector<LevelCost>& levels) {
  SpectralBound all;
  std::size_t particles = 0;
  for (const LevelCost& level : levels) {
    all = largest(all, level.bound);
    particles += level.particles;
  }
  LocalStepPlan best{.largest_step = 4 / (all.damping + std::hypot(all.damping, 2 * all.omega))};
  double least = double(particles) / best.largest_step;
  SpectralBound slow;
  std::size_t slow_particles = 0;
  for (std::size_t first = 1; first < levels.size(); ++first) {
    slow = largest(slow, levels[first - 1].bound);
    slow_particles += levels[first - 1].particles;
    if (levels[first].depth != levels[first - 1].depth + 1) continue;  // they do not touch
    const int p = 1 << (levels.back().depth - levels[first - 1].depth);
    const double step = largest_step(slow, all, p);
    const double cost = (double(slow_particles) + p * double(particles - slow_particles)) / step;
    if (cost >= least) continue;
    least = cost;
    best = {.first_fast = first, .substeps = p, .largest_step = step};
  }
  return best;
}

template <class Real>
LocalSteps<Real>::LocalSteps(RefinedSystem<Real>& system, const Environment& of_level, double dt, int threads)
    : SystemWrapper<Real>(system), system_(system), plan_(system.local_step_plan()), dt_(dt) {
  for (const Level& level : system.levels()) {
    const Field<Real> zero(level.body.lattice().size);
    for (Levels* fields : {&slow_force_, &fast_force_, &moved_, &inverse_mass_}) fields->push_back(zero);
    for (const std::ptrdiff_t site : level.body.sites())
      if (const double mass = system.mass(level.first + site); mass > 0)
        inverse_mass_.back().set(site, Vec3::Constant(1 / mass));
  }
  split_cells(of_level, threads);
  find_fast_sites();
}

/// Cells of the slow levels that touch a fast particle are fast.
template <class Real>
void LocalSteps<Real>::split_cells(const Environment& of_level, int threads) {
  const std::vector<Level>& levels = system_.levels();
  for (const Level& level : levels)
    is_fast_.emplace_back(std::size_t(level.body.lattice().size), &level >= &levels[plan_.first_fast]);
  for (const HangingParticle& p : system_.body().hanging())
    for (std::size_t m = 0; m < p.count && p.level == plan_.first_fast; ++m)
      is_fast_[p.level - 1][std::size_t(p.masters[m])] = true;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const Body& body = levels[level].body;
    BodyConfig slow = body.config(), fast = slow;
    const auto [nx, ny, nz] = body.config().voxels.size();
    slow.voxels = fast.voxels = VoxelGrid(nx, ny, nz);
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
          if (!body.config().voxels.at(i, j, k)) continue;
          bool touches = false;
          for (int c = 0; c < 8; ++c)
            touches = touches ||
                      is_fast_[level][std::size_t(body.lattice().site(i, j, k) + body.lattice().corner(c))];
          (touches ? fast : slow).voxels.set(i, j, k, true);
        }
    if (slow.voxels.count() > 0) slow_.push_back(std::make_unique<Part>(level, slow, of_level, threads));
    if (fast.voxels.count() > 0) fast_.push_back(std::make_unique<Part>(level, fast, of_level, threads));
  }
}

/// All that forces of fast cells act on.
template <class Real>
void LocalSteps<Real>::find_fast_sites() {
  std::vector<bool> acts(std::size_t(this->size()));
  for (const auto& part : fast_)
    for (const std::ptrdiff_t site : part->body.sites())
      acts[std::size_t(system_.body().site_in_field(part->level, site))] = true;
  for (const HangingParticle& p : system_.body().hanging())
    for (std::size_t m = 0; m < p.count; ++m)
      if (acts[std::size_t(system_.body().site_in_field(p.level, p.site))])
        acts[std::size_t(system_.body().site_in_field(p.level - 1, p.masters[m]))] = true;
  Field<Real> is_free(this->size());
  is_free.array() = Real(1);
  system_.clear_prescribed(is_free);
  for (std::size_t level = 0; level < system_.levels().size(); ++level) {
    FastLevel fast{.level = level};
    for (const std::ptrdiff_t site : system_.levels()[level].body.sites()) {
      const std::ptrdiff_t in_field = system_.body().site_in_field(level, site);
      if (!acts[std::size_t(in_field)] || system_.mass(in_field) == 0) continue;
      fast.sites.push_back(std::int32_t(site));
      fast.moves.push_back(is_fast_[level][std::size_t(site)] ? Real(1) : Real(0));
      for (int axis = 0; axis < 3; ++axis)
        fast.mobility[std::size_t(axis)].push_back(is_free.axis(axis)[in_field] *
                                                   static_cast<Real>(1 / system_.mass(in_field)));
    }
    fast.before = fast.now = fast.mobility;
    if (!fast.sites.empty()) sites_.push_back(std::move(fast));
  }
}

template <class Real>
void LocalSteps<Real>::add_slow_forces(double t) {
  for (Field<Real>& force : slow_force_) force.array() = 0;
  for (const auto& part : slow_) {
    const State<Real>& state = system_.levels_[part->level]->state;
    part->system.force(t, state.x, state.v, slow_force_[part->level]);
  }
  system_.transfer_.hand_over([&](std::size_t level) -> Field<Real>& { return slow_force_[level]; });
  for (const auto& loaded : system_.loaded_)
    for (int axis = 0; axis < 3; ++axis)
      slow_force_[loaded.level].axis(axis)[loaded.site] += static_cast<Real>(loaded.force[axis]);
}

/// Leaves d_p in the levels' `now`.
template <class Real>
void LocalSteps<Real>::take_substeps(double t) {
  const int p = plan_.substeps;
  const Damped c(p, least_nu(system_.spectral_bound().damping, dt_));
  const double squared = dt_ * dt_;
  for (std::size_t level = 0; level < moved_.size(); ++level) moved_[level] = system_.levels_[level]->state.x;
  for (FastLevel& fast : sites_)
    for (auto* displacements : {&fast.before, &fast.now})
      for (std::vector<Real>& d : *displacements) std::fill(d.begin(), d.end(), Real(0));
  for (int k = 0; k < p; ++k) {
    for (Field<Real>& force : fast_force_) force.array() = 0;
    for (const auto& part : fast_)
      part->system.force(t, moved_[part->level], system_.levels_[part->level]->state.v,
                         fast_force_[part->level]);
    system_.transfer_.hand_over([&](std::size_t level) -> Field<Real>& { return fast_force_[level]; });
    const auto at = [&](int i) { return c.value[std::size_t(i)]; };
    const auto of_now = static_cast<Real>(k == 0 ? 0 : 2 * c.delta * at(k) / at(k + 1)),
               of_before = static_cast<Real>(k == 0 ? 0 : at(k - 1) / at(k + 1)),
               of_force = static_cast<Real>((k == 0 ? 1 / c.delta : 2 * at(k) / at(k + 1)) / c.w * squared);
    displace(of_now, of_before, of_force);
    system_.transfer_.interpolate([&](std::size_t level) -> Field<Real>& { return moved_[level]; });
  }
}

/// d_{k+1} = of_now d_k - of_before d_{k-1} + of_force a.
template <class Real>
void LocalSteps<Real>::displace(Real of_now, Real of_before, Real of_force) {
  for (FastLevel& fast : sites_)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int a = int(axis);
      const Real *slow = slow_force_[fast.level].axis(a), *quick = fast_force_[fast.level].axis(a),
                 *from = system_.levels_[fast.level]->state.x.axis(a);
      Real *to = moved_[fast.level].axis(a), *before = fast.before[axis].data(), *now = fast.now[axis].data();
      for (std::size_t i = 0; i < fast.sites.size(); ++i) {
        const std::int32_t site = fast.sites[i];
        const Real next = of_now * now[i] - of_before * before[i] +
                          of_force * (fast.mobility[axis][i] * (slow[site] + quick[site]));
        before[i] = now[i];
        now[i] = next;
        to[site] = from[site] + fast.moves[i] * next;
      }
    }
}

template <class Real>
void LocalSteps<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  system_.take(x, v);
  add_slow_forces(t);
  take_substeps(t);
  for (std::size_t level = 0; level < inverse_mass_.size(); ++level)
    system_.levels_[level]->a.array() = slow_force_[level].array() * inverse_mass_[level].array();
  const auto factor = static_cast<Real>(2 / (dt_ * dt_));
  for (const FastLevel& fast : sites_)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < fast.sites.size(); ++i)
        system_.levels_[fast.level]->a.axis(int(axis))[fast.sites[i]] = factor * fast.now[axis][i];
  system_.finish_accelerations();
  for (std::size_t level = 0; level < system_.levels().size(); ++level)
    copy_level(system_.levels()[level], system_.levels_[level]->a, a);
}

template class LocalSteps<float>;
template class LocalSteps<double>;

}  // namespace mss
