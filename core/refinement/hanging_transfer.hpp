#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "core/refinement/refined_body.hpp"

namespace mss {

/// T and T^T of a RefinedBody on fields of its levels, for every step.
template <class Real>
class HangingTransfer {
 public:
  explicit HangingTransfer(const RefinedBody& body) : levels_(body.levels().size()) {
    for (const HangingParticle& p : body.hanging()) {
      Followers& followers = levels_[p.level].followers[p.count / 2];
      followers.sites.push_back(std::int32_t(p.site));
      for (std::size_t m = 0; m < p.count; ++m) followers.masters.push_back(std::int32_t(p.masters[m]));
    }
    for (std::size_t level = 1; level < levels_.size(); ++level) list_masters(body, level);
  }

  /// Gives hanging particles of a level the mean of their masters.
  void interpolate(std::size_t level, const Field<Real>& masters, Field<Real>& own) const {
    const auto& [single, pairs, fours] = levels_[level].followers;
    interpolate<1>(single, masters, own);
    interpolate<2>(pairs, masters, own);
    interpolate<4>(fours, masters, own);
  }
  /// The same on all levels; `field_of(level)` is the field of that level.
  template <class FieldOf>
  void interpolate(FieldOf&& field_of) const {
    for (std::size_t level = 1; level < levels_.size(); ++level)
      interpolate(level, field_of(level - 1), field_of(level));
  }

  /// Adds forces on a level's hanging particles to their masters'.
  void scatter_to_masters(std::size_t level, const Field<Real>& own, Field<Real>& masters) const {
    for (const Master& master : levels_[level].masters)
      add(levels_[level], master, levels_[level].weights, Real(1), own, masters);
  }
  /// The same of accelerations that each level's own masses had under forces.
  void scatter_accelerations_to_masters(std::size_t level, const Field<Real>& own,
                                        Field<Real>& masters) const {
    for (const Master& master : levels_[level].masters)
      add(levels_[level], master, levels_[level].shares, master.own_share, own, masters);
  }

 private:
  /// Hanging particles with equally many masters.
  struct Followers {
    std::vector<std::int32_t> sites, masters;  ///< of each site, one after the other
  };
  struct Master {
    std::ptrdiff_t site;
    std::size_t first, last;  ///< what hangs on it: in the level's sites, weights and shares
    Real own_share;           ///< of its level's cells in its mass
  };
  struct OfLevel {
    std::array<Followers, 3> followers{};  ///< of one, two and four masters
    std::vector<Master> masters{};
    std::vector<std::int32_t> sites{};  ///< those that hang, by master
    std::vector<Real> weights{};        ///< of the master in the particle's position
    std::vector<Real> shares{};         ///< of the particle's mass in the master's whole
  };

  void list_masters(const RefinedBody& body, std::size_t level) {
    std::map<std::ptrdiff_t, std::vector<const HangingParticle*>> of_master;
    for (const HangingParticle& p : body.hanging())
      for (std::size_t m = 0; m < p.count && p.level == level; ++m) of_master[p.masters[m]].push_back(&p);
    OfLevel& of = levels_[level];
    const Body &own = body.levels()[level].body, &larger = body.levels()[level - 1].body;
    for (const auto& [site, particles] : of_master) {
      const double mass = body.mass(body.site_in_field(level - 1, site));
      const std::size_t first = of.sites.size();
      for (const HangingParticle* p : particles) {
        of.sites.push_back(std::int32_t(p->site));
        of.weights.push_back(static_cast<Real>(p->weight()));
        of.shares.push_back(static_cast<Real>(p->weight() * own.mass(p->site) / mass));
      }
      of.masters.push_back({site, first, of.sites.size(), static_cast<Real>(larger.mass(site) / mass)});
    }
  }

  template <std::size_t count>
  static void interpolate(const Followers& followers, const Field<Real>& masters, Field<Real>& own) {
    const Real *x = masters.axis(0), *y = masters.axis(1), *z = masters.axis(2);
    const std::int32_t* m = followers.masters.data();
    for (const std::int32_t site : followers.sites) {
      Real sum[3] = {x[m[0]], y[m[0]], z[m[0]]};
      for (std::size_t i = 1; i < count; ++i) {
        sum[0] += x[m[i]];
        sum[1] += y[m[i]];
        sum[2] += z[m[i]];
      }
      for (int axis = 0; axis < 3; ++axis) own.axis(axis)[site] = Real(1) / Real(count) * sum[axis];
      m += count;
    }
  }

  /// field = own_share field + sum of factor times what hangs on the master.
  static void add(const OfLevel& level, const Master& master, const std::vector<Real>& factors,
                  Real own_share, const Field<Real>& own, Field<Real>& masters) {
    const Real *x = own.axis(0), *y = own.axis(1), *z = own.axis(2);
    Real sum[3] = {0, 0, 0};
    for (std::size_t i = master.first; i < master.last; ++i) {
      const std::int32_t site = level.sites[i];
      sum[0] += factors[i] * x[site];
      sum[1] += factors[i] * y[site];
      sum[2] += factors[i] * z[site];
    }
    for (int axis = 0; axis < 3; ++axis) {
      Real& to = masters.axis(axis)[master.site];
      to = own_share * to + sum[axis];
    }
  }

  std::vector<OfLevel> levels_;
};

}  // namespace mss
