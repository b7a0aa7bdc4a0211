#include "core/body_tangents.hpp"

namespace mss {

template <class Real>
BlockMatrix& BodyTangents<Real>::blocks() {
  if (!blocks_) blocks_ = std::make_unique<BlockMatrix>(body(), system_.held());
  return *blocks_;
}

template <class Real>
const std::vector<Unknown>& BodyTangents<Real>::unknowns() {
  if (unknowns_.empty()) unknowns_ = unknowns_of(system_);
  return unknowns_;
}

template <class Real>
void BodyTangents<Real>::values(double, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                                SparseMatrix& matrix) {
  BlockMatrix& m = blocks();
  m.begin(sum.mass);
  add(x, v, sum, m);
  if (system_.contact().has_penalties())
    for (const std::ptrdiff_t site : body().sites()) m.add_diagonal(site, penalty_at(site, x, v, sum));
  m.write(matrix);
}

template <class Real>
void BodyTangents<Real>::product(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                                 const Field<Real>& p, Field<Real>& out) {
  multiply(t, x, v, sum, p, out);
  if (!system_.contact().has_penalties()) return;
  for_each_particle(system_, [&](std::ptrdiff_t site) {
    out.set(site, out.at(site) + penalty_at(site, x, v, sum) * p.at(site));
  });
}

template <class Real>
void BodyTangents<Real>::diagonal(double, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                                  std::vector<Eigen::Matrix3d>& diagonal) {
  const std::vector<std::ptrdiff_t>& sites = body().sites();
  diagonal.resize(sites.size());
  for (std::size_t p = 0; p < sites.size(); ++p)
    diagonal[p] = sum.mass * body().mass(sites[p]) * Eigen::Matrix3d::Identity();
  add_diagonal(x, v, sum, diagonal);
  if (!system_.contact().has_penalties()) return;
  for (std::size_t p = 0; p < sites.size(); ++p) diagonal[p] += penalty_at(sites[p], x, v, sum);
}

template class BodyTangents<float>;
template class BodyTangents<double>;

}  // namespace mss
