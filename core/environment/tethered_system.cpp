#include "core/environment/tethered_system.hpp"

#include <algorithm>
#include <cmath>

namespace mss {

namespace {

template <class Real>
void add(Field<Real>& field, std::ptrdiff_t site, const Vec3& value) {
  field.set(site, field.at(site) + value);
}

}  // namespace

Tether stable_tether(double mass, const SpectralBound& bound, std::ptrdiff_t site) {
  const double stiffness = 0.05 * mass * bound.omega * bound.omega;
  return {.site = site, .stiffness = stiffness, .damping = 0.2 * std::sqrt(stiffness * mass)};
}

template <class Real>
void TetheredSystem<Real>::force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) {
  this->other().force(t, x, v, f);
  if (tether_) add(f, tether_->site, tether_->force(x.at(tether_->site), v.at(tether_->site)));
}

template <class Real>
void TetheredSystem<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v,
                                        Field<Real>& a) {
  this->other().acceleration(t, x, v, a);
  if (!tether_) return;
  const std::ptrdiff_t site = tether_->site;
  const double mass = this->mass(site);
  if (events() && events()->collides()) {  // whether it sticks is decided at the end of the step
    if (force_.size() == 0) force_ = Field<Real>(this->size());
    this->other().force(t, x, v, force_);
    a.set(site, force_.at(site) / mass);
  }
  add(a, site, tether_->force(x.at(site), v.at(site)) / mass);
  this->clear_prescribed(a);
}

template <class Real>
void TetheredSystem<Real>::kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) {
  if (tether_)
    System<Real>::kick_drift(update, dt, steps, state);  // in two passes: through acceleration() and apply()
  else
    this->other().kick_drift(update, dt, steps, state);
}

template <class Real>
void TetheredSystem<Real>::TetheredTangents::values(double t, const Field<Real>& x, const Field<Real>& v,
                                                    const TangentCoefficients& sum, SparseMatrix& matrix) {
  other().values(t, x, v, sum, matrix);
  if (!system_.tether_) return;
  const std::ptrdiff_t site = system_.tether_->site;
  const std::vector<FreeDof>& all = unknowns();
  auto unknown = std::lower_bound(all.begin(), all.end(), site,
                                  [](const FreeDof& u, std::ptrdiff_t s) { return u.site < s; });
  for (; unknown != all.end() && unknown->site == site; ++unknown) {
    const auto row = static_cast<int>(unknown - all.begin());
    matrix.coeffRef(row, row) += added(sum);
  }
}

template <class Real>
void TetheredSystem<Real>::TetheredTangents::product(double t, const Field<Real>& x, const Field<Real>& v,
                                                     const TangentCoefficients& sum, const Field<Real>& p,
                                                     Field<Real>& out) {
  other().product(t, x, v, sum, p, out);
  if (!system_.tether_) return;
  const std::ptrdiff_t site = system_.tether_->site;
  add(out, site, added(sum) * p.at(site));
}

template <class Real>
void TetheredSystem<Real>::TetheredTangents::diagonal(double t, const Field<Real>& x, const Field<Real>& v,
                                                      const TangentCoefficients& sum,
                                                      std::vector<Eigen::Matrix3d>& blocks) {
  other().diagonal(t, x, v, sum, blocks);
  if (!system_.tether_) return;
  const auto& sites = system_.particles();
  const auto id = std::lower_bound(sites.begin(), sites.end(), system_.tether_->site) - sites.begin();
  blocks[std::size_t(id)] += added(sum) * Eigen::Matrix3d::Identity();
}

template class TetheredSystem<float>;
template class TetheredSystem<double>;

}  // namespace mss
