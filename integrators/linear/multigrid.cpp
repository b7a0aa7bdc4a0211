// Conjugate gradients without a matrix, preconditioned by one multigrid V-cycle in single precision on bodies
// of cells twice, four times ... as large. Rounding in the preconditioner costs iterations, not accuracy.
// Briggs, Henson and McCormick, A Multigrid Tutorial; Tatebe, 1993, for its use within conjugate gradients.
#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/springs/body_system.hpp"
#include "integrators/linear/matrix_free.hpp"
#include "integrators/linear/multigrid_level.hpp"

namespace mss {

namespace {

class Multigrid final : public MatrixFree {
 public:
  using MatrixFree::MatrixFree;

 protected:
  Status prepare_preconditioner(System<double>& system, double t, const Field<double>& x,
                                const Field<double>& v, const TangentCoefficients& sum, Work& work) override;
  Products precondition(const std::function<void(Range)>& update, const Field<double>& r, Field<double>& z,
                        double enough) override;

 private:
  void build(const BodySystem<double>& body_system);
  void place(const BodySystem<double>& body_system, const Field<double>& x);
  void add_penalties(const BodySystem<double>& body_system, const Field<double>& x, const Field<double>& v,
                     const TangentCoefficients& sum);
  template <class Part>
  void for_each_coordinate(Part&& part) {
    sum_over_ranges([&](Range range) {
      for (int axis = 0; axis < 3; ++axis) part(axis, range);
      return Products{};
    });
  }

  std::unique_ptr<MultigridLevel> finest_;
  Field<float> x_, r_, z_;
  SiteBlocks added_;
};

void Multigrid::build(const BodySystem<double>& body_system) {
  Field<float> single_mask(body_system.size());
  for (int axis = 0; axis < 3; ++axis)
    std::copy_n(mask().axis(axis), body_system.size(), single_mask.axis(axis));
  finest_ = std::make_unique<MultigridLevel>(body_system.body(), single_mask, body_system.threads());
  for (Field<float>* field : {&x_, &r_, &z_}) *field = Field<float>(body_system.size());
}

/// Single precision keeps what matters, differences of positions, about the body's middle.
void Multigrid::place(const BodySystem<double>& body_system, const Field<double>& x) {
  const std::vector<std::ptrdiff_t>& sites = body_system.particles();
  const Vec3 middle = x.at(sites[sites.size() / 2]);
  for (const std::ptrdiff_t site : sites) x_.set(site, x.at(site) - middle);
}

/// What planes of the law `penalty` add, which lattices of springs do not know of.
void Multigrid::add_penalties(const BodySystem<double>& body_system, const Field<double>& x,
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
    contact->for_each_diagonal(x, v, sum, [&](std::ptrdiff_t site, const Eigen::Matrix3d& block) {
      blocks[std::size_t(body_system.body().particle(site))] += block;
    });
    for (std::size_t p = 0; p < blocks.size(); ++p) set(body_system.particles()[p], blocks[p]);
    return;
  }
  for (const std::ptrdiff_t site : body_system.particles())
    set(site, body_system.contact().tangent({x.at(site), v.at(site)}, sum, body_system.mass(site)));
}

Status Multigrid::prepare_preconditioner(System<double>& system, double, const Field<double>& x,
                                         const Field<double>& v, const TangentCoefficients& sum, Work&) {
  const BodySystem<double>* body_system = system.cells();
  if (!body_system)
    throw InputError(
        "the linear solver 'multigrid' needs a body of cells, which this model is not; choose 'matrix_free' "
        "or 'cholmod'");
  if (!finest_) build(*body_system);
  place(*body_system, x);
  add_penalties(*body_system, x, v, sum);
  z_.array() = 0;
  return finest_->prepare(x_, sum, added_);
}

ConjugateGradients::Products Multigrid::precondition(const std::function<void(Range)>& update,
                                                     const Field<double>& r, Field<double>& z,
                                                     double enough) {
  return precondition_whole(update, r, z, enough, [&](double norm) {
    const double scale = 1 / norm;
    for_each_coordinate([&](int axis, Range range) {
      const double* from = r.axis(axis);
      float* to = r_.axis(axis);
#pragma omp simd
      for (std::ptrdiff_t i = range.first; i < range.last; ++i) to[i] = float(scale * from[i]);
    });
    finest_->cycle(r_, z_);
    for_each_coordinate([&](int axis, Range range) {
      const float* from = z_.axis(axis);
      const double* is_free = mask().axis(axis);
      double* to = z.axis(axis);
#pragma omp simd
      for (std::ptrdiff_t i = range.first; i < range.last; ++i) to[i] = norm * is_free[i] * double(from[i]);
    });
  });
}

}  // namespace

LinearSolverInfo multigrid() {
  return {.name = "multigrid",
          .summary = "conjugate gradients, one V-cycle on coarser lattices in single precision, no matrix",
          .products_only = true,
          .one_lattice = true,
          .make = [](double tolerance) { return std::make_unique<Multigrid>(tolerance); }};
}

}  // namespace mss
