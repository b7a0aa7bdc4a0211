// Figs. 2-1 and 2-2: cubes with fewer springs a cell, deformed and released, and loaded in several
// directions.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/measures/measures.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/landing.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/uniform_stress.hpp"
#include "experiments/studies/thesis/thesis.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/statics/linear_response.hpp"

namespace mss::studies::thesis {

namespace {

constexpr double edge = 0.6;  ///< of the released cubes [m]
constexpr int cells = 3;

BodyConfig released_cube(const CellSprings& s) {
  return {.voxels = VoxelGrid::box(cells, cells, cells),
          .cell_size = edge / cells,
          .topology = s.topology,
          .sharing = Sharing::uniform,
          .density = 1,
          .springs = s.springs,
          .damping = {.law = Damping::Law::ratio, .zeta = 0.3}};
}

/// The upper plate arrives after a second, in which waves cross the cube some sixty times.
Environment plates(const Deformation& d) {
  const double rate = d.turn * std::numbers::pi / 180;
  return {.holds = {{.box = {{0, 0, 0}, {edge, edge, 0}}},
                    {.box = {{0, 0, edge}, {edge, edge, edge}},
                     .velocity = edge * d.shift,
                     .turn = Turn{.centre = {edge / 2, edge / 2, 0}, .rate = rate}}}};
}

/// Root mean square distance of particles from their rest positions after the best rigid motion [m].
double deformation(const Body& body, const Field<double>& x) {
  Eigen::Matrix3Xd rest(3, body.particle_count()), now = rest;
  for (std::size_t p = 0; p < body.particle_count(); ++p) {
    rest.col(Eigen::Index(p)) = body.rest_position(body.sites()[p]);
    now.col(Eigen::Index(p)) = x.at(body.sites()[p]);
  }
  const Eigen::Matrix4d motion = Eigen::umeyama(rest, now, false);
  const Eigen::Matrix3Xd moved =
      (motion.topLeftCorner<3, 3>() * rest).colwise() + motion.topRightCorner<3, 1>().col(0);
  return std::sqrt((now - moved).colwise().squaredNorm().mean());
}

/// Motions that no spring resists, beside the six rigid ones; to first order.
int mechanisms(const Body& body) {
  const auto system = make_system<double>(spring_model, body, {}, 1);
  Work work;
  const int unknowns = 3 * int(body.particle_count());
  const Modes found = slowest_modes(*system, system->undeformed_state(), unknowns / 2, work);
  const double fast = system->body_bound().omega;
  return int(std::count_if(found.modes.begin(), found.modes.end(),
                           [&](const Mode& mode) { return mode.omega < 1e-5 * fast; })) -
         6;
}

void add_release(const CellSprings& springs, int mechanisms, const Deformation& d, Table& rows) {
  const Body body(released_cube(springs));
  const auto held = make_system<double>(spring_model, body, plates(d), 1);
  const auto released = make_system<double>(spring_model, body, {}, 1);
  State<double> state = held->rest_state();
  const double dt = trial_step(*held);
  Work work;
  Status status = find_integrator("verlet").make<double>({.dt = dt})->advance(*held, state, 1, work);
  const double loaded = deformation(body, state.x);
  state.t = 0;
  state.v = Field<double>(released->size());
  if (status == Status::ok && settle(*released, state, dt).outcome == Recovery::non_finite)
    status = Status::non_finite;
  const bool ok = status == Status::ok;
  const Measures m = measure(*released, state);
  const double remaining = deformation(body, state.x);
  rows.add({springs.name, d.name, mechanisms, ok ? loaded / edge : no_value, ok ? remaining / edge : no_value,
            ok ? remaining / loaded : no_value, ok ? m.elastic : no_value, ok ? m.volume_ratio : no_value,
            ok ? m.min_jacobian : no_value, std::string(to_string(status))});
}

}  // namespace

std::vector<CellSprings> cell_springs() {
  SpringConstants all = thesis_springs;
  all.volume = 0;  // chapter 2 has none
  SpringConstants edges = all;
  edges.face = edges.body = 0;
  return {{"full", Topology::full, all},
          {"one face diagonal", Topology::one_diagonal, all},
          {"no face diagonals", Topology::edges_body, all},
          {"edges alone", Topology::full, edges}};
}

Table measure_unloading(const ThesisConfig& config, const Progress& progress) {
  Table rows({{"springs"},
              {"deformation"},
              {"mechanisms"},
              {"loaded"},
              {"remaining"},
              {"share"},
              {"stored", "J"},
              {"volume_ratio"},
              {"min_jacobian"},
              {"status"}});
  for (const CellSprings& springs : cell_springs()) {
    const int free_motions = progress.stopped() ? 0 : mechanisms(Body(released_cube(springs)));
    for (const Deformation& d : config.deformations) {
      if (progress.stopped()) return rows;
      add_release(springs, free_motions, d, rows);
    }
  }
  return rows;
}

Eigen::Matrix<double, 6, 6> lattice_stiffness(const Body& body) {
  using Voigt = Eigen::Matrix<double, 6, 1>;
  const double h = body.config().cell_size;
  Voigt volumetric;
  volumetric << 1, 1, 1, 0, 0, 0;
  Eigen::Matrix<double, 6, 6> c = body.config().springs.volume * volumetric * volumetric.transpose();
  for (std::size_t s = 0; s < spring_slots.size(); ++s) {
    Vec3 u;
    for (int a = 0; a < 3; ++a) u[a] = corner_bit(spring_slots[s].b, a) - corner_bit(spring_slots[s].a, a);
    u.normalize();
    Voigt q;  // rate of stretch of a spring along u by strain
    q << u[0] * u[0], u[1] * u[1], u[2] * u[2], u[1] * u[2], u[2] * u[0], u[0] * u[1];
    const double length = body.rest_length(spring_slots[s].kind);
    c += body.kinds().interior_stiffness(s) * length * length / (h * h * h) * q * q.transpose();
  }
  return c;
}

namespace {

/// A uniform stress and the modulus whose inverse is its compliance.
struct UniformLoad {
  std::string modulus, direction;
  Eigen::Matrix3d stress;
};

UniformLoad tension(const std::string& direction, const Vec3& along) {
  const Vec3 n = along.normalized();
  return {"E", direction, n * n.transpose()};
}
UniformLoad shear(const std::string& direction, const Vec3& along, const Vec3& normal) {
  const Vec3 n = normal.normalized(), m = along.normalized();
  return {"G", direction, n * m.transpose() + m * n.transpose()};
}

std::vector<UniformLoad> uniform_loads() {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  return {tension("[1 0 0]", x),
          tension("[1 1 0]", x + y),
          tension("[1 -1 0]", x - y),
          tension("[1 1 1]", x + y + z),
          tension("[1 1 -1]", x + y - z),
          shear("[1 0 0] in (0 1 0)", x, y),
          shear("[1 1 0] in (1 -1 0)", x + y, x - y),
          shear("[1 1 0] in (0 0 1)", x + y, z),
          shear("[1 -1 0] in (0 0 1)", x - y, z)};
}

/// A cube of 1 m of such springs, shared `weighted`; where a face has one diagonal, it is as stiff as two.
BodyConfig loaded_cube(Topology topology, SpringConstants springs, int n) {
  if (topology == Topology::one_diagonal) springs.face *= 2;
  return {.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n, .topology = topology, .springs = springs};
}

double closed_form(const Body& body, const UniformLoad& load) {
  const Eigen::Matrix3d& s = load.stress;
  Eigen::Matrix<double, 6, 1> voigt;
  voigt << s(0, 0), s(1, 1), s(2, 2), s(1, 2), s(2, 0), s(0, 1);
  return 1 / voigt.dot(lattice_stiffness(body).inverse() * voigt);
}

void add_modulus(int n, const std::string& material, const std::string& springs, const Body& body,
                 const UniformLoad& load, Table& rows) {
  constexpr double traction = 1e3;  // [Pa]; the response is linear
  const auto system = make_system<double>(spring_model, body, uniform_stress(traction * load.stress), 1);
  Work work;
  const LinearResponse r = linear_response(*system, {}, work);
  const double compliance = inner(*system, r.load, r.displacement) / (traction * traction);
  rows.add({n, material, springs, load.modulus, load.direction,
            r.status == Status::ok ? 1 / compliance : no_value, closed_form(body, load),
            std::string(to_string(r.status))});
}

}  // namespace

Table measure_directions(const ThesisConfig& config, const Progress& progress) {
  Table rows({{"cells"},
              {"material"},
              {"springs"},
              {"modulus"},
              {"direction"},
              {"measured", "Pa"},
              {"closed_form", "Pa"},
              {"status"}});
  for (const int n : config.direction_cells) {
    SpringConstants of_thesis = thesis_springs;
    of_thesis.volume = 0;
    for (double* k : {&of_thesis.edge, &of_thesis.face, &of_thesis.body}) *k *= 5.0 / n;  // the same material
    const SpringConstants isotropic = calibrate({.young = 1e4, .poisson = 0.25}, 1.0 / n, 0.5);
    for (const auto& [material, springs] :
         {std::pair<std::string, SpringConstants>{"thesis's", of_thesis}, {"calibrated", isotropic}})
      for (const auto& [name, topology] : {std::pair<std::string, Topology>{"full", Topology::full},
                                           {"one face diagonal", Topology::one_diagonal}}) {
        if (progress.stopped()) return rows;
        const Body body(loaded_cube(topology, springs, n));
        for (const UniformLoad& load : uniform_loads()) add_modulus(n, material, name, body, load, rows);
      }
  }
  return rows;
}

}  // namespace mss::studies::thesis
