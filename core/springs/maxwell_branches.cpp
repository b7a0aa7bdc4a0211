#include "core/springs/maxwell_branches.hpp"

#include <algorithm>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "core/kernels/branch_kernel.hpp"

namespace mss {

template <class Real>
MaxwellBranches<Real>::MaxwellBranches(System<Real>& system, const Body& body)
    : system_(system),
      body_(body),
      relaxation_(body.config().relaxation),
      kernel_(fastest_copy<BranchKernel<Real>>()),
      stiffness_(index(spring_slots.size(), 0)),
      length_(stiffness_.size()),
      tension_(stiffness_.size()),
      mobility_(std::size_t(body.lattice().sites)),
      force_(body.lattice().size) {
  if (body.ranks().are_several())
    throw InputError("material.relaxation is for one process, and several share the body; leave one out");
  const Lattice& lattice = body.lattice();
  for (std::ptrdiff_t site = 0; site < lattice.sites; ++site) {
    if (body.mass(site) > 0) mobility_[std::size_t(site)] = Real(1 / body.mass(site));
    if (body.kind(site) == 0) continue;
    const SiteElements elements = body.elements_at(site);
    for (std::size_t slot = 0; slot < spring_slots.size(); ++slot)
      stiffness_[index(slot, site)] = Real(relaxation_.ratio * elements.stiffness[slot]);
  }
}

template <class Real>
template <class Visit>
void MaxwellBranches<Real>::for_each_branch(Visit&& visit) const {
  for (std::ptrdiff_t site = 0; site < body_.lattice().sites; ++site)
    for (std::size_t slot = 0; body_.kind(site) != 0 && slot < spring_slots.size(); ++slot)
      if (const std::size_t at = index(slot, site); stiffness_[at] > 0) visit(site, spring_slots[slot], at);
}

/// Of one slot of a plane's sites.
template <class Real>
BranchRow<Real> MaxwellBranches<Real>::row(std::size_t slot, int plane, const BranchStep& step,
                                           const Field<Real>& x) {
  const Lattice& lattice = body_.lattice();
  const std::ptrdiff_t first = lattice.plane * plane;
  const std::size_t at = index(slot, first);
  BranchRow<Real> row{.count = lattice.used(),
                      .stiffness = &stiffness_[at],
                      .decay = Real(step.decay),
                      .gain = Real(step.gain),
                      .a = {},
                      .b = {},
                      .length = &length_[at],
                      .tension = &tension_[at]};
  for (int axis = 0; axis < 3; ++axis) {
    row.a[axis] = x.axis(axis) + first + lattice.corner(spring_slots[slot].a);
    row.b[axis] = x.axis(axis) + first + lattice.corner(spring_slots[slot].b);
  }
  return row;
}

template <class Real>
void MaxwellBranches<Real>::add_plane(int plane, const BranchStep& step, const Field<Real>& x,
                                      Field<Real>& f) {
  const Lattice& lattice = body_.lattice();
  const std::ptrdiff_t first = lattice.plane * plane, count = lattice.used();
  thread_local std::vector<Real> force;
  force.resize(std::size_t(3 * count));
  for (std::size_t slot = 0; slot < spring_slots.size(); ++slot) {
    kernel_.pull(row(slot, plane, step, x), force.data(), count);
    for (int axis = 0; axis < 3; ++axis) {
      const Real* along = force.data() + axis * count;
      Real* target = f.axis(axis) + first;
      kernel_.add(count, Real(1), along, target + lattice.corner(spring_slots[slot].a));
      kernel_.add(count, Real(-1), along, target + lattice.corner(spring_slots[slot].b));
    }
  }
}

/// A plane's springs pull at the next one too: so every second plane at a time, in an order that does not
/// depend on threads.
template <class Real>
void MaxwellBranches<Real>::add_force(double t, const Field<Real>& x, Field<Real>& f) {
  if (is_relaxed()) return;
  const BranchStep step = step_to(t);
  const int planes = body_.lattice().planes();
  for (int odd = 0; odd < 2; ++odd)
    system_.parallel((planes + 1 - odd) / 2,
                     [&](std::ptrdiff_t pair) { add_plane(int(2 * pair) + odd, step, x, f); });
}

template <class Real>
void MaxwellBranches<Real>::add_acceleration(double t, const Field<Real>& x, Field<Real>& a) {
  if (is_relaxed()) return;
  force_.array().setZero();
  add_force(t, x, force_);
  const std::ptrdiff_t sites = body_.lattice().sites;
  const Eigen::Map<const Eigen::Array<Real, Eigen::Dynamic, 1>> mobility(mobility_.data(), sites);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Map<Eigen::Array<Real, Eigen::Dynamic, 1>> along(a.axis(axis), sites);
    along += mobility * Eigen::Map<const Eigen::Array<Real, Eigen::Dynamic, 1>>(force_.axis(axis), sites);
  }
}

template <class Real>
template <class Visit>
void MaxwellBranches<Real>::for_each_tangent(double t, const Field<Real>& x, const TangentCoefficients& sum,
                                             Visit&& visit) const {
  if (is_relaxed()) return;
  constexpr double shortest = 1e-9;  // of the length where the last step ended, as of springs at rest
  const BranchStep step = step_to(t);
  for_each_branch([&](std::ptrdiff_t site, const SpringSlot& slot, std::size_t at) {
    const Vec3 d = ends_apart(x, site, slot);
    const double length = std::max(d.norm(), shortest * double(length_[at]));
    const double along = step.gain * double(stiffness_[at]);
    const double tension = step.decay * double(tension_[at]) + along * (length - double(length_[at]));
    const double across = sum.kind == Tangent::projected ? std::max(0.0, tension / length) : tension / length;
    const Vec3 u = d / length;
    Eigen::Matrix3d tangent = (sum.stiffness * (along - across)) * u * u.transpose();
    tangent.diagonal().array() += sum.stiffness * across;
    visit(site, slot, tangent);
  });
}

template <class Real>
void MaxwellBranches<Real>::add_tangent(double t, const Field<Real>& x, const TangentCoefficients& sum,
                                        BlockMatrix& blocks) const {
  for_each_tangent(t, x, sum,
                   [&](std::ptrdiff_t site, const SpringSlot& slot, const Eigen::Matrix3d& tangent) {
                     blocks.add(site, slot.a, slot.a, tangent);
                     blocks.add(site, slot.b, slot.b, tangent);
                     blocks.add(site, slot.a, slot.b, -tangent);
                     blocks.add(site, slot.b, slot.a, -tangent);
                   });
}

template <class Real>
void MaxwellBranches<Real>::add_diagonal(double t, const Field<Real>& x, const TangentCoefficients& sum,
                                         std::vector<Eigen::Matrix3d>& diagonal) const {
  for_each_tangent(
      t, x, sum, [&](std::ptrdiff_t site, const SpringSlot& slot, const Eigen::Matrix3d& tangent) {
        for (const int corner : {slot.a, slot.b})
          diagonal[std::size_t(body_.particle(site + body_.lattice().corner(corner)))] += tangent;
      });
}

template <class Real>
void MaxwellBranches<Real>::add_product(double t, const Field<Real>& x, const TangentCoefficients& sum,
                                        const Field<Real>& p, Field<Real>& out) const {
  for_each_tangent(t, x, sum,
                   [&](std::ptrdiff_t site, const SpringSlot& slot, const Eigen::Matrix3d& tangent) {
                     const std::ptrdiff_t a = site + body_.lattice().corner(slot.a),
                                          b = site + body_.lattice().corner(slot.b);
                     const Vec3 pull = tangent * (p.at(a) - p.at(b));
                     out.set(a, out.at(a) + pull);
                     out.set(b, out.at(b) - pull);
                   });
}

template <class Real>
double MaxwellBranches<Real>::energy(const Field<Real>& x) const {
  double energy = 0;
  if (is_relaxed()) return energy;
  for_each_branch([&](std::ptrdiff_t site, const SpringSlot& slot, std::size_t at) {
    const double k = stiffness_[at],
                 q = double(tension_[at]) + k * (ends_apart(x, site, slot).norm() - double(length_[at]));
    energy += q * q / (2 * k);
  });
  return energy;
}

/// What dissipates meanwhile [J].
template <class Real>
double MaxwellBranches<Real>::advance_plane(int plane, const BranchStep& step, const Field<Real>& x) {
  const auto count = std::size_t(body_.lattice().used());
  thread_local std::vector<Real> before, stretched;
  before.resize(count);
  stretched.resize(count);
  double dissipated = 0;
  for (std::size_t slot = 0; slot < spring_slots.size(); ++slot) {
    const BranchRow<Real> branches = row(slot, plane, step, x);
    kernel_.advance(branches, before.data(), stretched.data());
    for (std::size_t i = 0; i < count; ++i)
      if (branches.stiffness[i] > 0)
        dissipated +=
            step.dissipated(double(before[i]), double(stretched[i])) / double(branches.stiffness[i]);
  }
  return dissipated;
}

template <class Real>
void MaxwellBranches<Real>::come_to(const State<Real>& state) {
  const BranchStep step = step_to(state.t);
  if (is_relaxed()) std::fill(tension_.begin(), tension_.end(), Real(0));
  std::vector<double> by_plane(std::size_t(body_.lattice().planes()));
  system_.parallel(std::ptrdiff_t(by_plane.size()), [&](std::ptrdiff_t plane) {
    by_plane[std::size_t(plane)] = advance_plane(int(plane), step, state.x);
  });
  for (const double dissipated : by_plane) dissipated_ += dissipated;
  t_ = state.t;
}

template <class Real>
void MaxwellBranches<Real>::remember(Record& record) {
  record.begin("relaxation");
  record.keep(t_, dissipated_);
  record.keep_values(std::span(length_));
  record.keep_values(std::span(tension_));
}

template class MaxwellBranches<float>;
template class MaxwellBranches<double>;

}  // namespace mss
