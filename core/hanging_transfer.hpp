#pragma once

#include <cstdint>
#include <vector>

#include "core/refined_body.hpp"

namespace mss {

/// T and T^T of a RefinedBody on fields of its levels, for every step. `field_of(level)` is the field of that
/// level.
template <class Real>
class HangingTransfer {
 public:
  explicit HangingTransfer(const RefinedBody& body) {
    std::vector<bool> known(std::size_t(body.size()));
    for (const HangingParticle& p : body.hanging()) {
      Group& group = group_of(p);
      group.sites.push_back(std::int32_t(p.site));
      const double mass = body.levels()[p.level].body.mass(p.site);
      for (std::size_t m = 0; m < p.count; ++m) {
        const std::ptrdiff_t site = body.site_in_field(p.level - 1, p.masters[m]);
        group.masters.push_back(std::int32_t(p.masters[m]));
        group.weights.push_back(static_cast<Real>(p.weight()));
        group.shares.push_back(static_cast<Real>(p.weight() * mass / body.mass(site)));
        if (known[std::size_t(site)]) continue;
        known[std::size_t(site)] = true;
        masters_.push_back(
            {p.level - 1, p.masters[m],
             static_cast<Real>(body.levels()[p.level - 1].body.mass(p.masters[m]) / body.mass(site))});
      }
    }
  }

  /// Gives hanging particles the mean of their masters.
  template <class FieldOf>
  void interpolate(FieldOf&& field_of) const {
    for (const Group& group : groups_) {
      const Field<Real>& masters = field_of(group.level - 1);
      Field<Real>& own = field_of(group.level);
      for (int axis = 0; axis < 3; ++axis) {
        if (group.count == 1) interpolate<1>(group, masters.axis(axis), own.axis(axis));
        if (group.count == 2) interpolate<2>(group, masters.axis(axis), own.axis(axis));
        if (group.count == 4) interpolate<4>(group, masters.axis(axis), own.axis(axis));
      }
    }
  }

  /// Adds forces on hanging particles to their masters'.
  template <class FieldOf>
  void hand_over(FieldOf&& field_of) const {
    for (const Group& group : groups_)
      add(group, group.weights, field_of(group.level), field_of(group.level - 1));
  }

  /// The same of accelerations that each level's own masses had under forces.
  template <class FieldOf>
  void hand_over_accelerations(FieldOf&& field_of) const {
    for (const Master& master : masters_)
      for (int axis = 0; axis < 3; ++axis) field_of(master.level).axis(axis)[master.site] *= master.own_share;
    for (const Group& group : groups_)
      add(group, group.shares, field_of(group.level), field_of(group.level - 1));
  }

 private:
  /// Those of a level with so many masters.
  struct Group {
    std::size_t level, count;
    std::vector<std::int32_t> sites, masters;  ///< `count` masters per site, one after the other
    std::vector<Real> weights;                 ///< per master
    std::vector<Real> shares;                  ///< per master: of the particle's mass in the master's whole
  };
  struct Master {
    std::size_t level;
    std::ptrdiff_t site;
    Real own_share;  ///< of its level's cells in its mass
  };

  Group& group_of(const HangingParticle& p) {
    for (Group& group : groups_)
      if (group.level == p.level && group.count == p.count) return group;
    return groups_.emplace_back(Group{p.level, p.count, {}, {}, {}, {}});
  }

  template <std::size_t count>
  static void interpolate(const Group& group, const Real* masters, Real* own) {
    const std::int32_t* m = group.masters.data();
    for (const std::int32_t site : group.sites) {
      Real sum = 0;
      for (std::size_t i = 0; i < count; ++i) sum += masters[m[i]];
      own[site] = Real(1) / Real(count) * sum;
      m += count;
    }
  }

  static void add(const Group& group, const std::vector<Real>& factors, const Field<Real>& from,
                  Field<Real>& masters) {
    for (int axis = 0; axis < 3; ++axis) {
      const Real* own = from.axis(axis);
      Real* to = masters.axis(axis);
      const std::int32_t* m = group.masters.data();
      const Real* factor = factors.data();
      for (const std::int32_t site : group.sites)
        for (const std::int32_t* end = m + group.count; m < end; ++m) to[*m] += *factor++ * own[site];
    }
  }

  std::vector<Group> groups_;
  std::vector<Master> masters_;
};

}  // namespace mss
