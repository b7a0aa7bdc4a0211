#include "core/refinement/marking.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/refinement/displacement_recovery.hpp"

namespace mss {

std::vector<std::size_t> doerfler_marking(const std::vector<double>& indicators, double share,
                                          const std::vector<double>& costs) {
  std::vector<std::size_t> ids(indicators.size());
  std::iota(ids.begin(), ids.end(), 0);
  const auto rank = [&](std::size_t id) {
    return costs.empty() ? indicators[id] : indicators[id] / costs[id];
  };
  std::stable_sort(ids.begin(), ids.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
  const double enough = share * std::accumulate(indicators.begin(), indicators.end(), 0.0);
  double sum = 0;
  std::size_t count = 0;
  while (count < ids.size() && sum < enough) sum += indicators[ids[count++]];
  ids.resize(count);
  return ids;
}

RefinementMap split_by_estimate(const RefinedBody& body, const Field<double>& displacement,
                                const Field<double>* dual, Saved saved) {
  Field<double> u = displacement, z = dual != nullptr ? *dual : displacement;
  body.interpolate(u);
  body.interpolate(z);
  std::vector<double> indicators, costs;
  std::vector<std::pair<int, RefinementMap::Cell>> cells;  // with their depths
  for (std::size_t level = 0; level < body.levels().size(); ++level) {
    const Level& of = body.levels()[level];
    Field<double> rest(of.body.lattice().size), u_here = rest, z_here = rest;
    for (const std::ptrdiff_t site : of.body.sites()) rest.set(site, of.body.rest_position(site));
    copy_level(u, of, u_here);
    copy_level(z, of, z_here);
    const DisplacementRecovery recovery(of.body);
    for (const double part : recovery.products({rest, &u_here}, {rest, &z_here}).error)
      indicators.push_back(std::abs(part));
    for (const std::ptrdiff_t site : recovery.cells())
      cells.emplace_back(body.depth(level), body.cell(level, site));
    costs.resize(cells.size(), saved == Saved::time ? std::ldexp(1, 2 * body.depth(level)) : 1);
  }
  RefinementMap map = body.map();
  for (const std::size_t marked : doerfler_marking(indicators, 0.5, costs))
    map.split(cells[marked].first, cells[marked].second);
  return map;
}

}  // namespace mss
