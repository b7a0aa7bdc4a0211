// Chapter 3, Fig. 5-1 and eq. 1-2: what the estimate of the volume saves and costs, and what a volume force
// does to volume and shape.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>

#include "core/forces/cell_geometry.hpp"
#include "core/measures/measures.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/equilibrium.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/thesis/thesis.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "reference/mollemans.hpp"

namespace mss::studies::thesis {

namespace {

/// Scenes of Fig. 5-1, from left to right.
constexpr std::array figure_5_1{"fig5_1_stretch", "fig5_1_compress", "fig5_1_twist"};

Scene scene_of(const char* name, const std::vector<std::string>& overrides = {}) {
  return load_scene(scene_file(name), overrides);
}

/// The largest error of the estimate for one cell, over the cell's volume at rest.
double worst_estimate(const Scene& scene, const SimulationResult& result) {
  const Body body(scene.body);
  Field<double> x(body.lattice().size);
  for (std::size_t p = 0; p < result.particles.size(); ++p) x.set(body.sites()[p], result.particles[p].x);
  double worst = 0;
  body.for_each_cell([&](std::ptrdiff_t site) {
    const auto corners = corners_of(body, x, site);
    worst =
        std::max(worst, std::abs(thesis_volume(corners) - trilinear_volume(corners)) / body.cell_volume());
  });
  return worst;
}

/// The twist of Fig. 5-1 to an angle [degrees] at the same rate, in finer cells; springs are proportional to
/// the cell's size, so that the material is the same. A guard that acts needs shorter steps.
Scene twisted(int n, bool guarded, double angle) {
  const double k = 100 * 5.0 / n, dt = 1e-3 * 5.0 / n * (guarded ? 0.3 : 1);
  return scene_of("fig5_1_twist",
                  {fmt::format("body.cells=[{0},{0},{0}]", n), fmt::format("body.cell_size={}", 1.0 / n),
                   fmt::format("material.springs={{edge={0:.17g},face={0:.17g},body={1:.17g}}}", k, 3 * k),
                   fmt::format("material.fold_guard={}", guarded ? default_fold_guard : 0.0),
                   fmt::format("solve.dt={:.17g}", dt), "hold.1.turn.until=1.5",
                   fmt::format("solve.duration={}", angle / 60), "solve.every=0.025", "solve.threads=1"});
}

}  // namespace

Table measure_figure_5_1(const Progress& progress) {
  Table rows({{"scene"},
              {"volume_ratio"},
              {"volume_ratio_estimate"},
              {"error_of_change"},
              {"worst_cell_error"},
              {"min_jacobian"},
              {"max_stretch"},
              {"status"}});
  for (const char* name : figure_5_1) {
    if (progress.stopped()) break;
    const Scene scene = scene_of(name);
    Progress quiet;
    const SimulationResult result = simulate(scene, quiet);
    const Measures& m = result.series.back();
    rows.add({std::string(name), m.volume_ratio, m.volume_ratio_thesis,
              (m.volume_ratio_thesis - m.volume_ratio) / std::abs(m.volume_ratio - 1),
              worst_estimate(scene, result), m.min_jacobian, m.max_stretch,
              std::string(to_string(result.status))});
  }
  return rows;
}

Table measure_twists(const ThesisConfig& config, const Progress& progress) {
  Table rows({{"cells"},
              {"guarded"},
              {"angle", "degrees"},
              {"volume_ratio"},
              {"min_jacobian"},
              {"max_stretch"},
              {"status"}});
  for (const int n : config.twist_cells)
    for (const bool guarded : {false, true}) {
      if (progress.stopped()) return rows;
      Progress quiet;
      const SimulationResult result = simulate(twisted(n, guarded, config.twist_angle), quiet);
      for (const Measures& m : result.series)
        rows.add(
            {n, guarded ? 1 : 0, m.t * 60, m.volume_ratio, m.min_jacobian, m.max_stretch, std::string("ok")});
      if (result.status != Status::ok)
        rows.add({n, guarded ? 1 : 0, result.simulated_seconds * 60, no_value, no_value, no_value,
                  std::string(to_string(result.status))});
    }
  return rows;
}

namespace {

/// A cell cut into a tetrahedron in the middle and four at its corners, the classical way: exact where faces
/// are flat.
double five_tetrahedra_volume(const std::array<Vec3, 8>& p) {
  constexpr std::array<std::array<std::size_t, 4>, 5> tetrahedra{
      {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 1, 4, 7}, {6, 4, 2, 7}, {1, 2, 4, 7}}};
  double sum = 0;
  for (const auto& [a, b, c, d] : tetrahedra) sum += (p[b] - p[a]).dot((p[c] - p[a]).cross(p[d] - p[a]));
  return sum / 6;
}

struct VolumeFormula {
  const char* name;
  double (*volume)(const std::array<Vec3, 8>&);
};
constexpr std::array volume_formulas{VolumeFormula{"estimate (3-5, 3-6)", thesis_volume},
                                     VolumeFormula{"exact, trilinear", trilinear_volume},
                                     VolumeFormula{"five tetrahedra", five_tetrahedra_volume}};

/// The thesis's cube with 7 cells per edge, its particles moved by up to a tenth of a cell at random.
struct WarpedCube {
  static BodyConfig config() {
    BodyConfig cube = thesis_cube();
    cube.voxels = VoxelGrid::box(7, 7, 7);
    cube.cell_size = 1.0 / 7;
    return cube;
  }
  WarpedCube()
      : body(config()), system(make_system<double>(spring_model, body, {}, 1)), state(system->rest_state()) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<> share(-0.1, 0.1);
    for (const std::ptrdiff_t site : body.sites()) {
      const double x = share(random), y = share(random), z = share(random);
      state.x.set(site, state.x.at(site) + body.config().cell_size * Vec3(x, y, z));
    }
  }
  double volume(const VolumeFormula& formula) const {
    double sum = 0;
    body.for_each_cell([&](std::ptrdiff_t site) { sum += formula.volume(corners_of(body, state.x, site)); });
    return sum;
  }

  Body body;
  std::unique_ptr<BodySystem<double>> system;
  State<double> state;
};

}  // namespace

Table measure_volume_time(const ThesisConfig& config, const Progress& progress) {
  constexpr int passes = 200;
  WarpedCube cube;
  const IntegratorInfo& method = find_integrator("verlet");
  const double dt = 0.5 * stable_step(method, cube.system->spectral_bound());
  const auto verlet = method.make<double>({.dt = dt});
  State<double> moving = cube.state;
  Work work;
  volatile double sink = 0;
  const std::size_t formulas = volume_formulas.size();
  const auto seconds =
      measure_interleaved(config.timing_repetitions, formulas + 1, progress, [&](std::size_t i) {
        const Stopwatch watch;
        for (int pass = 0; pass < passes; ++pass)
          if (i < formulas)
            sink = sink + cube.volume(volume_formulas[i]);
          else
            verlet->advance(*cube.system, moving, moving.t + dt, work);
        return watch.seconds();
      });
  (void)sink;
  Table rows({{"computed"}, {"median", "s"}, {"q1", "s"}, {"q3", "s"}, {"relative_error"}, {"status"}});
  const double per = 1.0 / (passes * double(cube.body.cell_count()));
  const double exact = cube.volume(volume_formulas[1]);
  for (std::size_t i = 0; i <= formulas; ++i) {
    const bool measured = int(seconds[i].size()) == config.timing_repetitions;
    const Quartiles q = measured ? quartiles(seconds[i]) : Quartiles{no_value, no_value, no_value};
    const bool formula = i < formulas;
    rows.add({std::string(formula ? volume_formulas[i].name : "step of verlet, all forces"), q.median * per,
              q.q1 * per, q.q3 * per, formula ? cube.volume(volume_formulas[i]) / exact - 1 : 0.0,
              std::string(measured ? "ok" : "interrupted")});
  }
  return rows;
}

namespace {

/// A cube of 1 m between plates that it is glued to, stretched.
struct StretchedCube {
  Status status = Status::ok;
  double volume_ratio = no_value;
  std::vector<Vec3> displacement{};
  double omega = no_value;  ///< bound on frequencies [rad/s]
  double alpha = 0;         ///< of eq. 1-2 with the same pressure [N/m^3]
};

StretchedCube stretch(const ThesisConfig& config, const std::string& model, const BodyConfig& cube) {
  const double strain = config.shape_strain;
  const Environment plates{.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}},
                                     {.box = {{0, 0, 1}, {1, 1, 1}}, .displacement = {0, 0, strain}}}};
  const Body body(cube);
  const auto system = make_system<double>(model, body, plates, config.threads);
  const auto [status, state] = find_equilibrium(*system, [&](const Vec3& rest) -> Vec3 {
    return {rest[0], rest[1], (1 + strain) * rest[2]};
  });
  StretchedCube result{.status = status, .omega = system->body_bound().omega};
  result.alpha = MollemansSystem(body, {}).alpha();
  if (status != Status::ok) return result;
  result.volume_ratio = volume_ratio(body, state.x);
  for (const std::ptrdiff_t site : body.sites())
    result.displacement.push_back(state.x.at(site) - body.rest_position(site));
  return result;
}

double root_mean_square(const std::vector<Vec3>& a) {
  double sum = 0;
  for (const Vec3& v : a) sum += v.squaredNorm();
  return std::sqrt(sum / double(a.size()));
}

std::vector<Vec3> difference(std::vector<Vec3> a, const std::vector<Vec3>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

/// Springs beside which k_vol is varied, and the law of the volume force.
struct ShapeCase {
  std::string name, model;
  BodyConfig cube;
};

std::vector<ShapeCase> shape_cases(int n) {
  const double k = 100 * 5.0 / n;
  BodyConfig cube{.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n, .density = 1};
  cube.springs = {.edge = k, .face = k, .body = 3 * k};
  std::vector<ShapeCase> cases{{"thesis's springs, force 3-7", spring_model, cube}};
  cube.springs = calibrate({.young = 1416.67, .poisson = 0.25}, cube.cell_size, 0.5);
  cases.push_back({"calibrated springs, force 3-7", spring_model, cube});
  cases.push_back({"calibrated springs, force 1-1", mollemans_model, cube});
  return cases;
}

void add_shape(const ShapeCase& c, double share, const StretchedCube& cube, const StretchedCube& without,
               Table& rows) {
  const bool ok = cube.status == Status::ok && without.status == Status::ok;
  const double change = cube.volume_ratio - 1, free = without.volume_ratio - 1;
  const double moved = ok ? root_mean_square(difference(cube.displacement, without.displacement)) /
                                root_mean_square(without.displacement)
                          : no_value;
  rows.add({c.name, share, share * cubic_stiffness(c.cube.springs, c.cube.cell_size).c44, cube.alpha,
            ok ? change : no_value, ok ? 1 - change / free : no_value, moved, without.omega / cube.omega,
            std::string(to_string(ok ? Status::ok : cube.status))});
}

}  // namespace

Table measure_shape(const ThesisConfig& config, const Progress& progress) {
  Table rows({{"case"},
              {"k_vol_over_shear"},
              {"k_vol", "Pa"},
              {"alpha", "N/m^3"},
              {"volume_change"},
              {"volume_corrected"},
              {"shape_change"},
              {"step_over_plain"},
              {"status"}});
  for (const ShapeCase& c : shape_cases(config.shape_cells)) {
    StretchedCube without;
    for (const double share : config.volume_shares) {
      if (progress.stopped()) return rows;
      BodyConfig cube = c.cube;
      cube.springs.volume = share * cubic_stiffness(cube.springs, cube.cell_size).c44;
      const StretchedCube found = stretch(config, c.model, cube);
      if (share == config.volume_shares.front()) without = found;
      add_shape(c, share, found, without, rows);
    }
  }
  return rows;
}

}  // namespace mss::studies::thesis
