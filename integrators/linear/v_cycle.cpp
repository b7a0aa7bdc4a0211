#include "integrators/linear/v_cycle.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"

namespace mss {

void VCycle::build(const BodySystem<double>& body_system) {
  Field<float> single_mask(body_system.size());
  for (int axis = 0; axis < 3; ++axis)
    std::copy_n(mask_->axis(axis), body_system.size(), single_mask.axis(axis));
  finest_ = std::make_unique<MultigridLevel>(body_system.body(), single_mask, body_system.threads());
  for (Field<float>* field : {&x_, &r_, &z_}) *field = Field<float>(body_system.size());
}

/// Single precision keeps what matters, differences of positions, about the body's middle.
void VCycle::place(const BodySystem<double>& body_system, const Field<double>& x) {
  const std::vector<std::ptrdiff_t>& sites = body_system.particles();
  const Vec3 middle = x.at(sites[sites.size() / 2]);
  for (const std::ptrdiff_t site : sites) x_.set(site, x.at(site) - middle);
}

/// What planes of the law `penalty` add, which lattices of springs do not know of.
void VCycle::add_penalties(const BodySystem<double>& body_system, double t, const Field<double>& x,
                           const Field<double>& v, const TangentCoefficients& sum) {
  if (!body_system.contact().has_penalties()) return;
  if (added_.straight.size() == 0)
    added_ = {Field<float>(body_system.size()), Field<float>(body_system.size())};
  const auto set = [&](std::ptrdiff_t site, const Eigen::Matrix3d& block) {
    added_.straight.set(site, block.diagonal());
    added_.mixed.set(site, Vec3(block(1, 2), block(2, 0), block(0, 1)));
  };
  if (const SurfaceContact* contact = body_system.surface_contact()) {
    std::vector<Eigen::Matrix3d> blocks(body_system.particles().size(), Eigen::Matrix3d::Zero());
    contact->for_each_diagonal(t, x, v, sum, [&](std::ptrdiff_t site, const Eigen::Matrix3d& block) {
      blocks[std::size_t(body_system.body().particle(site))] += block;
    });
    for (std::size_t p = 0; p < blocks.size(); ++p) set(body_system.particles()[p], blocks[p]);
    return;
  }
  for (const std::ptrdiff_t site : body_system.particles())
    set(site, body_system.contact().tangent({x.at(site), v.at(site)}, t, sum, body_system.mass(site)));
}

Status VCycle::prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                       const TangentCoefficients& sum, const Field<double>& mask) {
  const BodySystem<double>* body_system = system.cells();
  if (!body_system)
    throw InputError(
        "the linear solver 'multigrid' needs a body of cells, which this model is not; choose 'matrix_free' "
        "or 'cholmod'");
  if (!body_system->body().config().is_solid())
    throw InputError(fmt::format(
        "the linear solver 'multigrid' halves cells of three dimensions, and this body is {}; choose "
        "'cholmod'",
        body_system->body().config().noun()));
  system_ = &system;
  mask_ = &mask;
  if (!finest_) build(*body_system);
  place(*body_system, x);
  add_penalties(*body_system, t, x, v, sum);
  z_.array() = 0;
  return finest_->prepare(x_, sum, added_);
}

template <class Part>
void VCycle::for_each_coordinate(Part&& part) {
  constexpr std::ptrdiff_t sites = 1024, together = 4;  // some 2 us
  const std::ptrdiff_t size = system_->size();
  parallel_in_groups(*system_, (size + sites - 1) / sites, together, [&](std::ptrdiff_t i) {
    for (int axis = 0; axis < 3; ++axis) part(axis, i * sites, std::min((i + 1) * sites, size));
  });
}

void VCycle::apply(const Field<double>& r, double norm, Field<double>& z) {
  const double scale = 1 / norm;
  for_each_coordinate([&](int axis, std::ptrdiff_t first, std::ptrdiff_t last) {
    const double* from = r.axis(axis);
    float* to = r_.axis(axis);
#pragma omp simd
    for (std::ptrdiff_t i = first; i < last; ++i) to[i] = float(scale * from[i]);
  });
  finest_->cycle(r_, z_);
  for_each_coordinate([&](int axis, std::ptrdiff_t first, std::ptrdiff_t last) {
    const float* from = z_.axis(axis);
    const double* is_free = mask_->axis(axis);
    double* to = z.axis(axis);
#pragma omp simd
    for (std::ptrdiff_t i = first; i < last; ++i) to[i] = norm * is_free[i] * double(from[i]);
  });
}

}  // namespace mss
