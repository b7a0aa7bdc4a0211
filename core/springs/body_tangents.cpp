#include "core/springs/body_tangents.hpp"

namespace mss {

template <class Real>
BlockMatrix& BodyTangents<Real>::blocks() {
  if (!blocks_) blocks_ = std::make_unique<BlockMatrix>(body(), system_.held());
  return *blocks_;
}

template <class Real>
const std::vector<FreeDof>& BodyTangents<Real>::unknowns() {
  if (unknowns_.empty()) unknowns_ = unknowns_of(system_);
  return unknowns_;
}

template <class Real>
void BodyTangents<Real>::values(double t, const Field<Real>& x, const Field<Real>& v,
                                const TangentCoefficients& sum, SparseMatrix& matrix) {
  BlockMatrix& m = blocks();
  m.begin(sum.mass);
  add(t, x, v, sum, m);
  if (system_.contact().has_penalties()) add_penalties(t, x, v, sum, m);
  m.write(matrix);
}

template <class Real>
void BodyTangents<Real>::add_penalties(double t, const Field<Real>& x, const Field<Real>& v,
                                       const TangentCoefficients& sum, BlockMatrix& matrix) {
  const SurfaceContact* contact = system_.surface_contact();
  if (!contact) {
    for (const std::ptrdiff_t site : body().sites())
      matrix.add_diagonal(site, penalty_at(t, site, x, v, sum));
    return;
  }
  const EmbeddedSurface& surface = contact->surface();
  contact->for_each_tangent(t, x, v, sum, [&](std::size_t vertex, const Eigen::Matrix3d& tangent) {
    const std::array<double, 8>& weights = surface.weights(vertex);
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 8; ++d)
        matrix.add(surface.site(vertex), c, d, weights[std::size_t(c)] * weights[std::size_t(d)] * tangent);
  });
}

template <class Real>
void BodyTangents<Real>::product(double t, const Field<Real>& x, const Field<Real>& v,
                                 const TangentCoefficients& sum, const Field<Real>& p, Field<Real>& out) {
  multiply(t, x, v, sum, p, out);
  if (system_.contact().has_penalties()) add_penalties(t, x, v, sum, p, out);
}

template <class Real>
void BodyTangents<Real>::add_penalties(double t, const Field<Real>& x, const Field<Real>& v,
                                       const TangentCoefficients& sum, const Field<Real>& p,
                                       Field<Real>& out) {
  const SurfaceContact* contact = system_.surface_contact();
  if (!contact) {
    for_each_particle(system_, [&](std::ptrdiff_t site) {
      out.set(site, out.at(site) + penalty_at(t, site, x, v, sum) * p.at(site));
    });
    return;
  }
  const EmbeddedSurface& surface = contact->surface();
  contact->for_each_tangent(t, x, v, sum, [&](std::size_t vertex, const Eigen::Matrix3d& tangent) {
    surface.distribute(vertex, tangent * surface.at(vertex, p), out);
  });
}

template <class Real>
void BodyTangents<Real>::diagonal(double t, const Field<Real>& x, const Field<Real>& v,
                                  const TangentCoefficients& sum, std::vector<Eigen::Matrix3d>& diagonal) {
  const std::vector<std::ptrdiff_t>& sites = body().sites();
  diagonal.resize(sites.size());
  for (std::size_t p = 0; p < sites.size(); ++p)
    diagonal[p] = sum.mass * body().mass(sites[p]) * Eigen::Matrix3d::Identity();
  add_diagonal(t, x, v, sum, diagonal);
  if (system_.contact().has_penalties()) add_penalties(t, x, v, sum, diagonal);
}

template <class Real>
void BodyTangents<Real>::add_penalties(double t, const Field<Real>& x, const Field<Real>& v,
                                       const TangentCoefficients& sum,
                                       std::vector<Eigen::Matrix3d>& diagonal) {
  const std::vector<std::ptrdiff_t>& sites = body().sites();
  if (const SurfaceContact* contact = system_.surface_contact())
    contact->for_each_diagonal(t, x, v, sum, [&](std::ptrdiff_t site, const Eigen::Matrix3d& block) {
      diagonal[std::size_t(body().particle(site))] += block;
    });
  else
    for (std::size_t p = 0; p < sites.size(); ++p) diagonal[p] += penalty_at(t, sites[p], x, v, sum);
}

template class BodyTangents<float>;
template class BodyTangents<double>;

}  // namespace mss
