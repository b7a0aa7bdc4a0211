// The scenes of `mss reduce` on a lattice: a beam, a plate, a free cube.
#include "experiments/studies/reduce/scenes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "experiments/simulation/equilibrium.hpp"

namespace mss::studies::reduce {

namespace {

constexpr double density = 1000;
/// eta over mu of a body of 10 MPa [s]; that of others is such that their motions differ in time alone.
constexpr double damping_time = 8e-5, damping_young = 1e7;
/// The plane that a tip meets, of a body whose lower face is at z = 0 [m].
constexpr double plane_height = -0.05;
/// Shares of length and width of the top face that a load presses on.
constexpr double patch_from = 0.4375, patch_to = 0.5625, patch_left = 0.375, patch_right = 0.625;

Box end_face(const Solid& solid) { return {{solid.size[0], 0, 0}, solid.size}; }

/// A force spread evenly over a rectangle of the top face, each of its points shared by the corners of the
/// cell face it is in: the same load on every lattice.
Load patch_load(const Solid& solid, const Vec3& force) {
  constexpr int samples = 32;
  const auto point = [&](double along, double across) {
    return Vec3(solid.size[0] * (patch_from + along * (patch_to - patch_from)),
                solid.size[1] * (patch_left + across * (patch_right - patch_left)), solid.size[2]);
  };
  auto patch = std::make_shared<TriangleMesh>();
  for (int i = 0; i < samples; ++i)
    for (int j = 0; j < samples; ++j) {
      patch->vertices.push_back(point((i + 0.5) / samples, (j + 0.5) / samples));
      const int here = i * samples + j;
      if (i == 0 || j == 0) continue;
      patch->triangles.push_back({here - samples - 1, here - 1, here});
      patch->triangles.push_back({here - samples - 1, here, here - samples});
    }
  return {.box = {point(0, 0), point(1, 1)}, .force = force, .surface = patch};
}

Environment environment_of(const ReduceScene& scene, const Solid& solid) {
  Environment all;
  if (solid.clamped) all.holds.push_back({.box = {{0, 0, 0}, {0, solid.size[1], solid.size[2]}}});
  if (scene.happening == Happening::gravity || scene.happening == Happening::contact)
    all.gravity = scene.amount;
  if (scene.happening == Happening::patch) all.loads.push_back(patch_load(solid, scene.amount));
  if (scene.happening == Happening::contact)
    all.planes.push_back(
        {.point = {0, 0, plane_height}, .contact = ContactLaw::penalty, .restitution = 1, .friction = 0});
  return all;
}

/// What keeps a body where it begins.
Environment kept(const ReduceScene& scene, const Solid& solid, Environment all) {
  if (scene.happening == Happening::release)
    all.loads.push_back({.box = end_face(solid), .force = scene.amount});
  if (scene.happening == Happening::twist)
    all.holds.push_back(
        {.box = end_face(solid),
         .turn = Turn{.axis = Vec3::UnitX(),
                      .centre = {0, solid.size[1] / 2, solid.size[2] / 2},
                      .rate = scene.amount[0] * std::numbers::pi / 180,  // an equilibrium is sought at t = 1
                      .until = 1}});
  return all;
}

/// Roughly where a body begins: turned in proportion to x, or bent as far as it is meant to be.
Vec3 guessed(const ReduceScene& scene, const Solid& solid, const Vec3& rest) {
  const double share = rest[0] / solid.size[0];
  if (scene.happening == Happening::twist) {
    const Vec3 centre(0, solid.size[1] / 2, solid.size[2] / 2);
    const double angle = share * scene.amount[0] * std::numbers::pi / 180;
    return centre + Eigen::AngleAxisd(angle, Vec3::UnitX()) * (rest - centre);
  }
  const double angle = 1.5 * scene.meant * share * (1 - share / 2) * 2;  // of its sections, about -y
  const double sag = scene.meant * solid.size[0] * (3 - share) * share * share / 2;
  const Vec3 across(std::sin(angle), 0, std::cos(angle));
  const double lift = rest[2] - solid.size[2] / 2;
  return {rest[0] - scene.meant * sag / 2 + lift * across[0], rest[1],
          solid.size[2] / 2 - sag + lift * across[2]};
}

}  // namespace

int Solid::cells_along(int axis, int along_x) const {
  return int(std::lround(size[axis] / size[0] * along_x));
}

Scene scene_on(const ReduceScene& scene, const Solid& solid, const LatticeChoice& lattice,
               const std::string& model) {
  Scene all;
  all.name = scene.name;
  all.model = model;
  all.face_share = lattice.face_share;
  all.body.voxels =
      VoxelGrid::box(lattice.cells, solid.cells_along(1, lattice.cells), solid.cells_along(2, lattice.cells));
  all.body.cell_size = solid.size[0] / lattice.cells;
  all.body.density = density;
  all.body.fill({.young = lattice.young, .poisson = lattice.poisson}, lattice.face_share);
  all.body.damping = {
      .law = Damping::Law::viscosity,
      .viscosity = damping_time * std::sqrt(damping_young / solid.young) * all.body.shear_modulus()};
  all.environment = environment_of(scene, solid);
  if (scene.happening == Happening::spin) all.start_angular_velocity = scene.amount;
  all.solve.threads = 1;
  return all;
}

State<double> start_of(const ReduceScene& scene, const Solid& solid, const Scene& on_lattice,
                       const Body& body) {
  const auto system = make_system<double>(spring_model, body, kept(scene, solid, on_lattice.environment), 1);
  State<double> start = system->undeformed_state();
  if (scene.happening == Happening::release || scene.happening == Happening::twist) {
    Equilibrium at_rest =
        find_equilibrium(*system, [&](const Vec3& rest) { return guessed(scene, solid, rest); });
    if (at_rest.status != Status::ok)
      throw std::runtime_error(
          fmt::format("{} has no equilibrium to begin from: {}", scene.name, to_string(at_rest.status)));
    start.x = at_rest.state.x;
  }
  const Vec3 centre = solid.size / 2;
  for (const std::ptrdiff_t site : body.sites())
    start.v.set(site, on_lattice.start_angular_velocity.cross(start.x.at(site) - centre));
  return start;
}

Vec3 end_displacement(const Solid& solid, const Body& body, const Field<double>& x) {
  const Box face = end_face(solid);
  Vec3 sum = Vec3::Zero();
  const std::vector<std::ptrdiff_t> sites = body.select(face.lower, face.upper);
  for (const std::ptrdiff_t site : sites) sum += x.at(site) - body.rest_position(site);
  return sum / double(sites.size());
}

std::string reduce_complaint(const ReduceScene& scene, const Solid& solid, const Body& body,
                             const State<double>& start, const FramePositions& motion) {
  constexpr double close = 0.1;
  const Vec3 along = scene.amount.normalized();
  double reached = along.dot(end_displacement(solid, body, start.x)), gap = 1;
  for (const Field<double>& x : motion) {
    reached = std::max(reached, along.dot(end_displacement(solid, body, x)));
    for (const std::ptrdiff_t site : body.sites()) gap = std::min(gap, x.at(site)[2] - plane_height);
  }
  if (scene.meant > 0 && std::abs(reached / solid.size[0] / scene.meant - 1) > close)
    return fmt::format("its end goes {:.3g} percent of the length, not {:.3g}", 100 * reached / solid.size[0],
                       100 * scene.meant);
  if (scene.happening == Happening::contact && gap >= 0) return "it has not touched the plane";
  return "";
}

}  // namespace mss::studies::reduce
