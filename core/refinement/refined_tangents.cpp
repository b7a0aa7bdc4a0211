#include <algorithm>
#include <set>

#include "core/refinement/refined_system.hpp"
#include "core/springs/element_tangents.hpp"

namespace mss {

namespace {

TangentCoefficients without_mass(TangentCoefficients sum) {
  sum.mass = 0;
  return sum;
}

/// Of a number that a matrix has.
int index_of(const SparseMatrix& matrix, int row, int column) {
  const int* columns = matrix.innerIndexPtr();
  const int *first = columns + matrix.outerIndexPtr()[row], *last = columns + matrix.outerIndexPtr()[row + 1];
  return int(std::lower_bound(first, last, column) - columns);
}

}  // namespace

template <class Real>
const std::vector<FreeDof>& RefinedSystem<Real>::RefinedTangents::unknowns() {
  if (unknowns_.empty()) unknowns_ = unknowns_of(system_);
  return unknowns_;
}

/// T's rows at a level's unknowns.
template <class Real>
auto RefinedSystem<Real>::RefinedTangents::expand(std::size_t level) const -> std::vector<Weights> {
  const RefinedBody& body = system_.body_;
  std::vector<int> number(3 * std::size_t(body.size()), -1);
  const auto number_of = [&](std::size_t l, std::ptrdiff_t site, int axis) -> int& {
    return number[3 * std::size_t(body.site_in_field(l, site)) + std::size_t(axis)];
  };
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    number[3 * std::size_t(unknowns_[i].site) + std::size_t(unknowns_[i].axis)] = int(i);
  std::vector<const HangingParticle*> hanging(std::size_t(body.levels()[level].body.lattice().size));
  for (const HangingParticle& p : body.hanging())
    if (p.level == level) hanging[std::size_t(p.site)] = &p;

  std::vector<Weights> rows;
  for (const auto [site, axis] : system_.levels_[level]->system.tangents()->unknowns()) {
    Weights& row = rows.emplace_back();
    const HangingParticle* p = hanging[std::size_t(site)];
    if (!p) row.emplace_back(number_of(level, site, axis), 1);
    for (std::size_t m = 0; p && m < p->count; ++m)
      if (const int unknown = number_of(level - 1, p->masters[m], axis); unknown >= 0)
        row.emplace_back(unknown, p->weight());
  }
  return rows;
}

template <class Real>
void RefinedSystem<Real>::RefinedTangents::build() {
  unknowns();
  std::vector<std::vector<Weights>> rows;
  std::vector<Eigen::Triplet<double>> entries;
  const auto for_each_share = [&](std::size_t level, auto&& visit) {
    const SparseMatrix& matrix = levels_[level].matrix;
    for (int i = 0; i < int(matrix.rows()); ++i)
      for (int source = matrix.outerIndexPtr()[i]; source < matrix.outerIndexPtr()[i + 1]; ++source)
        for (const auto& [row, row_weight] : rows[level][std::size_t(i)])
          for (const auto& [column, weight] : rows[level][std::size_t(matrix.innerIndexPtr()[source])])
            visit(source, row, column, row_weight * weight);
  };
  for (std::size_t level = 0; level < system_.levels_.size(); ++level) {
    levels_.push_back({system_.levels_[level]->system.tangents()->pattern(), {}});
    rows.push_back(expand(level));
    for_each_share(level, [&](int, int row, int column, double) { entries.emplace_back(row, column, 0); });
  }
  const auto size = Eigen::Index(unknowns_.size());
  pattern_ = SparseMatrix(size, size);
  pattern_.setFromTriplets(entries.begin(), entries.end());
  for (std::size_t level = 0; level < levels_.size(); ++level)
    for_each_share(level, [&](int source, int row, int column, double weight) {
      levels_[level].shares.push_back({source, index_of(pattern_, row, column), weight});
    });
}

template <class Real>
SparseMatrix RefinedSystem<Real>::RefinedTangents::pattern() {
  if (levels_.empty()) build();
  return pattern_;
}

template <class Real>
void RefinedSystem<Real>::RefinedTangents::values(double t, const Field<Real>& x, const Field<Real>& v,
                                                  const TangentCoefficients& sum, SparseMatrix& matrix) {
  if (levels_.empty()) build();
  system_.load_state(x, v);
  std::fill_n(matrix.valuePtr(), matrix.nonZeros(), 0.0);
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    LevelState& part = *system_.levels_[level];
    SparseMatrix& of_level = levels_[level].matrix;
    part.system.tangents()->values(t, part.state.x, part.state.v, without_mass(sum), of_level);
    for (const auto& [source, target, weight] : levels_[level].shares)
      matrix.valuePtr()[target] += weight * of_level.valuePtr()[source];
  }
  for (int i = 0; i < int(unknowns_.size()); ++i)
    matrix.valuePtr()[index_of(matrix, i, i)] += sum.mass * system_.mass(unknowns_[std::size_t(i)].site);
}

template <class Real>
void RefinedSystem<Real>::RefinedTangents::product(double t, const Field<Real>& x, const Field<Real>& v,
                                                   const TangentCoefficients& sum, const Field<Real>& p,
                                                   Field<Real>& out) {
  const RefinedBody& body = system_.body_;
  system_.load_state(x, v);
  for (std::size_t level = 0; level < body.levels().size(); ++level) {
    LevelState& part = *system_.levels_[level];
    if (part.p.size() == 0) part.p = Field<Real>(part.system.size());
    copy_level(p, body.levels()[level], part.p);
  }
  system_.transfer_.interpolate([&](std::size_t level) -> Field<Real>& { return system_.levels_[level]->p; });
  for (std::size_t level = 0; level < body.levels().size(); ++level) {
    LevelState& part = *system_.levels_[level];
    part.system.tangents()->product(t, part.state.x, part.state.v, without_mass(sum), part.p, part.a);
    copy_level(body.levels()[level], part.a, out);
  }
  body.scatter_to_masters(out);
  for_each_particle(system_, [&](std::ptrdiff_t site) {
    out.set(site, out.at(site) + sum.mass * body.mass(site) * p.at(site));
  });
}

/// A master's block has those of what hangs on it, and of pairs of these that springs and cells join.
template <class Real>
void RefinedSystem<Real>::RefinedTangents::diagonal(double t, const Field<Real>& x, const Field<Real>& v,
                                                    const TangentCoefficients& sum,
                                                    std::vector<Eigen::Matrix3d>& blocks) {
  const RefinedBody& body = system_.body_;
  system_.load_state(x, v);
  std::vector<Eigen::Matrix3d> by_site(std::size_t(body.size()), Eigen::Matrix3d::Zero()), of_level;
  for (std::size_t level = 0; level < body.levels().size(); ++level) {
    LevelState& part = *system_.levels_[level];
    part.system.tangents()->diagonal(t, part.state.x, part.state.v, without_mass(sum), of_level);
    for (std::size_t i = 0; i < of_level.size(); ++i)
      by_site[std::size_t(body.site_in_field(level, part.system.particles()[i]))] = of_level[i];
  }
  for (const HangingParticle& p : body.hanging())
    for (std::size_t m = 0; m < p.count; ++m)
      by_site[std::size_t(body.site_in_field(p.level - 1, p.masters[m]))] +=
          p.weight() * p.weight() * by_site[std::size_t(body.site_in_field(p.level, p.site))];
  for (std::size_t level = 1; level < body.levels().size(); ++level) add_hanging(level, sum, by_site);
  blocks.clear();
  for (const std::ptrdiff_t site : system_.particles())
    blocks.push_back(by_site[std::size_t(site)] + sum.mass * body.mass(site) * Eigen::Matrix3d::Identity());
}

/// Adds, of a level, the blocks between different particles that hang on one master.
template <class Real>
void RefinedSystem<Real>::RefinedTangents::add_hanging(std::size_t level, const TangentCoefficients& sum,
                                                       std::vector<Eigen::Matrix3d>& blocks) const {
  const Body& body = system_.levels()[level].body;
  const LevelState& part = *system_.levels_[level];
  std::vector<const HangingParticle*> hanging(std::size_t(body.lattice().size));
  std::set<std::ptrdiff_t> sites;  // whose cells have a hanging corner
  for (const HangingParticle& p : system_.body_.hanging()) {
    if (p.level != level) continue;
    hanging[std::size_t(p.site)] = &p;
    for (int c = 0; c < 8; ++c)
      if (const std::ptrdiff_t site = p.site - body.lattice().corner(c); site >= 0) sites.insert(site);
  }
  const auto add = [&](std::ptrdiff_t site, int c, int d, const Eigen::Matrix3d& block) {
    const HangingParticle* p = hanging[std::size_t(site + body.lattice().corner(c))];
    const HangingParticle* q = hanging[std::size_t(site + body.lattice().corner(d))];
    if (c == d || !p || !q) return;
    for (std::size_t m = 0; m < p->count; ++m)
      for (std::size_t n = 0; n < q->count; ++n)
        if (p->masters[m] == q->masters[n])
          blocks[std::size_t(system_.body_.site_in_field(level - 1, p->masters[m]))] +=
              p->weight() * q->weight() * block;
  };
  for (const std::ptrdiff_t site : sites)
    for_each_tangent_block(body, site, part.state.x, part.state.v, sum, add);
}

template class RefinedSystem<float>::RefinedTangents;
template class RefinedSystem<double>::RefinedTangents;

}  // namespace mss
