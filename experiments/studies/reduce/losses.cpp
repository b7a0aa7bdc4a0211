#include "experiments/studies/reduce/losses.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "integrators/reduction/reduced_system.hpp"

namespace mss::studies::reduce {

namespace {

/// Displacements as ParticleRows has them, by columns: of each control point three of twelve affine
/// functions, along each axis.
Eigen::MatrixXd blended_affine(const Solid& solid, const Body& body, int points) {
  constexpr int functions = 4;
  const auto count = Eigen::Index(body.particle_count());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(3 * count, Eigen::Index(3) * functions * points);
  const double spacing = solid.size[0] / points;
  for (Eigen::Index p = 0; p < count; ++p) {
    const Vec3 x = body.rest_position(body.sites()[std::size_t(p)]);
    for (int j = 0; j < points; ++j) {
      const double away = x[0] - (j + 1) * spacing;
      const double weight = std::max(0.0, 1 - std::abs(away) / spacing);
      const std::array<double, functions> affine{1, away, x[1] - solid.size[1] / 2, x[2] - solid.size[2] / 2};
      for (int f = 0; f < functions; ++f)
        for (int axis = 0; axis < 3; ++axis)
          all(axis * count + p, (j * functions + f) * 3 + axis) = weight * affine[std::size_t(f)];
    }
  }
  return all;
}

/// The square of the slowest frequency of shapes of a body that nothing loads.
double slowest_square(const Body& body, const Environment& held, const Eigen::MatrixXd& displacements) {
  RestBody rest(body, held);
  return shapes_of(rest, displacements).squares[0];
}

/// Regions of a lattice and their rigid motions.
class AdaptiveShapes final : public Mover {
 public:
  AdaptiveShapes(const ReduceScene& scene, const Solid& solid, const Body& body, const State<double>& start,
                 int steps, double alpha)
      : body_(body), start_(start), gravity_(scene.amount), steps_(steps), alpha_(alpha) {
    const std::array<int, 3>& cells = body.lattice().cells;
    const int across = std::min(cells[1], cells[2]);
    for (int i = 0; i < cells[0]; i += across)
      for (int j = 0; j < cells[1]; j += across)
        for (int k = 0; k < cells[2]; k += across) split({i, j, k}, across);
    regions_of_.assign(std::size_t(body.lattice().size), 0);
    for (const Region& region : regions_)
      for (const std::ptrdiff_t site : region.sites) ++regions_of_[std::size_t(site)];
    for (const std::ptrdiff_t site : body.sites())
      if (body.rest_position(site)[0] > 1e-9 * solid.size[0]) free_.push_back(site);
  }

  void restart() override { state_ = start_; }

  Status advance() override {
    for (int n = 0; n < steps_; ++n) step(frame / steps_);
    return is_finite(state_) ? Status::ok : Status::non_finite;
  }
  const Field<double>& draw() override { return state_.x; }
  long steps() const override { return steps_; }

 private:
  struct Region {
    std::vector<std::ptrdiff_t> sites;
    Vec3 centre = Vec3::Zero();  ///< at rest, by mass
    double mass = 0;
  };

  /// A cube of an octree with that corner and edge, in cells, or its parts: those near the clamp are smaller.
  void split(const std::array<int, 3>& corner, int edge) {
    const int smallest = std::max(1, body_.lattice().cells[2] / 4);
    if (edge > smallest && corner[0] < 2 * edge) {
      for (int part = 0; part < 8; ++part)
        split({corner[0] + corner_bit(part, 0) * edge / 2, corner[1] + corner_bit(part, 1) * edge / 2,
               corner[2] + corner_bit(part, 2) * edge / 2},
              edge / 2);
      return;
    }
    const double h = body_.config().cell_size;
    const int margin = (edge + 1) / 2;
    const Vec3 low = h * Vec3(corner[0] - margin, corner[1] - margin, corner[2] - margin);
    Region region{.sites = body_.select(low, low + h * (edge + 2 * margin) * Vec3::Ones())};
    for (const std::ptrdiff_t site : region.sites) {
      region.centre += body_.mass(site) * body_.rest_position(site);
      region.mass += body_.mass(site);
    }
    region.centre /= region.mass;
    regions_.push_back(std::move(region));
  }

  void step(double dt) {
    goals_.assign(std::size_t(body_.lattice().size), Vec3::Zero());
    for (const Region& region : regions_) add_goals(region);
    for (const std::ptrdiff_t site : free_) {
      const Vec3 x = state_.x.at(site);
      const Vec3 goal = goals_[std::size_t(site)] / regions_of_[std::size_t(site)];
      const Vec3 way = dt * state_.v.at(site) + dt * dt * gravity_ + alpha_ * (goal - x);
      state_.x.set(site, x + way);
      state_.v.set(site, way / dt);
    }
  }

  void add_goals(const Region& region) {
    Vec3 centre = Vec3::Zero();
    for (const std::ptrdiff_t site : region.sites) centre += body_.mass(site) * state_.x.at(site);
    centre /= region.mass;
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const std::ptrdiff_t site : region.sites)
      moments += body_.mass(site) * (state_.x.at(site) - centre) *
                 (body_.rest_position(site) - region.centre).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moments, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
    for (const std::ptrdiff_t site : region.sites)
      goals_[std::size_t(site)] += centre + turn * (body_.rest_position(site) - region.centre);
  }

  const Body& body_;
  const State<double>& start_;
  Vec3 gravity_;
  int steps_;
  double alpha_;
  std::vector<Region> regions_;
  std::vector<int> regions_of_;  ///< how many, by site
  std::vector<std::ptrdiff_t> free_;
  std::vector<Vec3> goals_;  ///< sums, by site
  State<double> state_;
};

}  // namespace

std::unique_ptr<Mover> frames_mover(const ReduceScene& scene, const Solid& solid, const LatticeChoice& own,
                                    int points, bool matched, const State<double>& start) {
  LatticeChoice material = own;
  if (matched) {
    const Scene held = scene_on({}, solid, own);
    const Body body(held.body);
    RestBody rest(body, held.environment);
    material.young *= modal_shapes(rest, held.environment, 1).squares[0] /
                      slowest_square(body, held.environment, blended_affine(solid, body, points));
  }
  const Scene now = scene_on(scene, solid, material);
  auto body = std::make_unique<const Body>(now.body);
  RestBody rest(*body, now.environment);
  auto system =
      std::make_unique<ReducedSystem>(*body, now.environment, ReductionChoice{.reduction = Reduction::cubic},
                                      shapes_of(rest, blended_affine(solid, *body, points)));
  return reduced_mover(std::move(body), std::move(system), start);
}

std::unique_ptr<Mover> shape_mover(const ReduceScene& scene, const Solid& solid, const LatticeChoice& lattice,
                                   const ShapeRegions& regions, const Body& body) {
  const Stepper stepper{"shape_matching",
                        {.dt = frame / regions.steps, .region_width = regions.width, .alpha = regions.alpha}};
  return lattice_mover(scene, solid, lattice, body, stepper);
}

std::unique_ptr<Mover> adaptive_shape_mover(const ReduceScene& scene, const Solid& solid, const Body& body,
                                            const State<double>& start, int steps, double alpha) {
  return std::make_unique<AdaptiveShapes>(scene, solid, body, start, steps, alpha);
}

}  // namespace mss::studies::reduce
