// The bodies of `mss shape`, their free vibrations and their largest steps.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "core/mesh/mesh_fill.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/harness/case_rows.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/studies/shape/shape.hpp"
#include "integrators/analysis/modes.hpp"
#include "reference/sphere_modes.hpp"

namespace mss::studies::shape {

namespace {

constexpr int rigid = 6, bar_modes = 6, sphere_modes = 14;

/// Frequencies of a kind [rad/s], as many as are compared.
struct Frequencies {
  std::string mode;
  std::vector<double> measured, exact;
  double rms_error() const {
    double sum = 0;
    for (std::size_t i = 0; i < measured.size(); ++i) sum += std::pow(measured[i] / exact[i] - 1, 2);
    return std::sqrt(sum / double(measured.size()));
  }
};

/// The share of a mode q, q.M q = 1, that lies in the span of five fields.
class Projection {
 public:
  Projection(const Body& body, const reference::SphereVibration& vibration, const Vec3& centre)
      : body_(body) {
    for (const std::ptrdiff_t site : body.sites())
      fields_.push_back(vibration.displacements(body.rest_position(site) - centre));
    Eigen::Matrix<double, 5, 5> gram = Eigen::Matrix<double, 5, 5>::Zero();
    for (std::size_t p = 0; p < fields_.size(); ++p)
      for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
          gram(i, j) += mass(p) * fields_[p][std::size_t(i)].dot(fields_[p][std::size_t(j)]);
    factor_.compute(gram);
  }
  double share(const Mode& mode) const {
    Eigen::Matrix<double, 5, 1> b = Eigen::Matrix<double, 5, 1>::Zero();
    for (std::size_t p = 0; p < fields_.size(); ++p)
      for (int i = 0; i < 5; ++i)
        b[i] += mass(p) * fields_[p][std::size_t(i)].dot(mode.shape.at(body_.sites()[p]));
    return b.dot(factor_.solve(b));
  }

 private:
  double mass(std::size_t particle) const { return body_.mass(body_.sites()[particle]); }

  const Body& body_;
  std::vector<std::array<Vec3, 5>> fields_{};
  Eigen::LLT<Eigen::Matrix<double, 5, 5>> factor_{};
};

/// Of the elastic modes, the five that are most of a kind.
Frequencies of_kind(const ShapeConfig& config, const ShapeBody& body, const Body& cells,
                    const std::vector<Mode>& modes, reference::SphereMode kind, const std::string& name) {
  const reference::SphereVibration vibration(
      {.material = config.material, .density = config.density, .radius = body.across / 2}, kind);
  const Projection projection(cells, vibration, Vec3::Zero());
  std::vector<std::pair<double, double>> shares;  // and frequencies
  for (std::size_t i = rigid; i < modes.size(); ++i)
    shares.emplace_back(projection.share(modes[i]), modes[i].omega);
  std::sort(shares.rbegin(), shares.rend());
  Frequencies found{.mode = name, .measured = {}, .exact = std::vector<double>(5, vibration.omega())};
  for (std::size_t i = 0; i < 5; ++i) found.measured.push_back(shares[i].second);
  return found;
}

std::vector<Frequencies> frequencies(const ShapeConfig& config, const ShapeBody& body, const Body& cells,
                                     const std::vector<Mode>& modes, const std::vector<double>& bar) {
  if (body.sphere)
    return {of_kind(config, body, cells, modes, reference::SphereMode::torsional, "torsional"),
            of_kind(config, body, cells, modes, reference::SphereMode::spheroidal, "spheroidal")};
  Frequencies found{.mode = "bar", .measured = {}, .exact = bar};
  for (std::size_t i = rigid; i < modes.size(); ++i) found.measured.push_back(modes[i].omega);
  return {found};
}

Modes elastic_modes(const Body& body, int count) {
  SpringSystem<double> system(body, {}, {.threads = 1});
  Work work;
  return slowest_modes(system, system.rest_state(), rigid + count, work);
}

/// Places in the lattice [cells]; a body that is aligned has one.
std::vector<Vec3> places(const ShapeConfig& config, const ShapeBody& body, int count) {
  if (body.aligned) return {Vec3::Zero()};
  std::mt19937_64 random(config.seed);
  std::vector<Vec3> chosen;
  for (int i = 0; i < count; ++i) {
    const auto share = [&] { return std::uniform_real_distribution<>(0, 1)(random); };
    const double x = share(), y = share(), z = share();
    chosen.emplace_back(x, y, z);
  }
  return chosen;
}

double slowest_frequency(const BodyConfig& cells, Status& status) {
  const Modes modes = elastic_modes(Body(cells), 1);
  status = modes.status;
  return status == Status::ok ? modes.modes[rigid].omega : no_value;
}

/// Frequencies of the aligned bar; none if they are not found.
std::vector<double> bar_frequencies(const ShapeConfig& config, int across) {
  const auto bar = std::find_if(config.bodies.begin(), config.bodies.end(),
                                [](const ShapeBody& body) { return body.aligned; });
  const Body body(
      in_cells(config, *bar, {.name = "staircase"}, across, Vec3::Zero(), config.material.poisson));
  const Modes modes = elastic_modes(body, bar_modes);
  std::vector<double> found;
  for (std::size_t i = rigid; modes.status == Status::ok && i < modes.modes.size(); ++i)
    found.push_back(modes.modes[i].omega);
  return found;
}

/// Every part of a study computes them: errors of all bars are about them.
std::vector<Case> bar_cases(const ShapeConfig& config) {
  std::vector<Case> cases;
  for (const int across : config.reference_cells)
    cases.push_back({fmt::format("aligned bar, {} cells", across),
                     [&config, across] { return Json(bar_frequencies(config, across)); }});
  return cases;
}

/// The limits of the aligned bar's frequencies from three sizes, each with half the cells of the next
/// (Aitken's extrapolation); none if one has no modes.
std::vector<double> bar_limits(const ShapeConfig& config, const Journal& journal, Table& table) {
  std::vector<std::vector<double>> by_size;
  for (const Case& one : bar_cases(config)) {
    by_size.push_back(journal.find(one.name)->get<std::vector<double>>());
    if (by_size.back().empty()) return {};
  }
  std::vector<double> limits;
  for (std::size_t i = 0; i < std::size_t(bar_modes); ++i) {
    const double a = by_size[0][i], b = by_size[1][i], c = by_size[2][i];
    limits.push_back(c - (c - b) * (c - b) / ((c - b) - (b - a)));
    for (std::size_t size = 0; size < by_size.size(); ++size)
      table.add({std::int64_t(config.reference_cells[size]), std::int64_t(i + 1), by_size[size][i],
                 by_size[size][i] / limits[i] - 1});
  }
  return limits;
}

/// The slowest vibration that there is, of the material with this ratio: of a sphere the true one, of a bar
/// that of the aligned bar in as many cells, which are full.
double slowest_expected(const ShapeConfig& config, const ShapeBody& body, int across, double poisson,
                        Status& status) {
  if (body.sphere) {
    const auto omega = [&](reference::SphereMode kind) {
      const ElasticConstants material{.young = config.material.young, .poisson = poisson};
      return reference::SphereVibration(
                 {.material = material, .density = config.density, .radius = body.across / 2}, kind)
          .omega();
    };
    return std::min(omega(reference::SphereMode::torsional), omega(reference::SphereMode::spheroidal));
  }
  const auto aligned = std::find_if(config.bodies.begin(), config.bodies.end(),
                                    [](const ShapeBody& other) { return other.aligned; });
  return slowest_frequency(in_cells(config, *aligned, {.name = "staircase"}, across, Vec3::Zero(), poisson),
                           status);
}

double largest_frequency(const BodyConfig& cells, Status& status) {
  const Body body(cells);
  SpringSystem<double> system(body, {}, {.threads = 1});
  Work work;
  const Modes fastest = fastest_mode(system, system.rest_state(), work);
  status = fastest.status;
  return status == Status::ok ? fastest.modes.front().omega : no_value;
}

void add_steps(const ShapeConfig& config, const ShapeBody& body, const Filling& filling, int across,
               Table& steps) {
  constexpr int full_cells = 6;
  for (const double poisson : config.step_poissons) {
    BodyConfig full{.voxels = VoxelGrid::box(full_cells, full_cells, full_cells),
                    .cell_size = body.across / across,
                    .density = config.density};
    full.fill({.young = config.material.young, .poisson = poisson}, config.face_share);
    std::array<Status, 4> status{};
    const double full_omega = largest_frequency(full, status[0]);
    const double expected = slowest_expected(config, body, across, poisson, status[1]);
    const std::vector<Vec3> chosen = places(config, body, config.step_offsets);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const BodyConfig cells = in_cells(config, body, filling, across, chosen[i], poisson);
      const double omega = largest_frequency(cells, status[2]);
      const double slowest = slowest_frequency(cells, status[3]);
      const auto failed =
          std::find_if(status.begin(), status.end(), [](Status s) { return s != Status::ok; });
      steps.add({body.name, filling.label(), std::int64_t(across), poisson, std::int64_t(i), omega,
                 full_omega / omega, slowest / expected,
                 std::string(to_string(failed == status.end() ? Status::ok : *failed))});
    }
  }
}

void add_frequencies(const ShapeConfig& config, const ShapeBody& body, const Filling& filling, int across,
                     const std::vector<double>& bar, Table& rows) {
  const std::vector<Vec3> chosen = places(config, body, config.offsets);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const Body cells(in_cells(config, body, filling, across, chosen[i], config.material.poisson));
    const Modes modes = elastic_modes(cells, body.sphere ? sphere_modes : bar_modes);
    const double volume = cells.total_mass() / config.density / enclosed_volume(body.mesh) - 1;
    const bool has_reference = body.sphere || !bar.empty();
    const std::string status =
        modes.status == Status::ok && !has_reference ? "no reference" : std::string(to_string(modes.status));
    const auto add = [&](const std::string& mode, double error) {
      rows.add({body.name, filling.label(), std::int64_t(across), mode, std::int64_t(i), error, volume,
                std::int64_t(cells.cell_count()), std::int64_t(cells.particle_count()), status});
    };
    if (status != "ok")
      add("all", no_value);
    else
      for (const Frequencies& f : frequencies(config, body, cells, modes.modes, bar))
        add(f.mode, f.rms_error());
  }
}

ShapeTables empty_tables() {
  return {Table({{"body"},
                 {"fill"},
                 {"cells"},
                 {"mode"},
                 {"place"},
                 {"error"},
                 {"volume_error"},
                 {"cell_count"},
                 {"particles"},
                 {"status"}}),
          Table({{"body"},
                 {"fill"},
                 {"cells"},
                 {"poisson"},
                 {"place"},
                 {"omega_max", "rad/s"},
                 {"step_over_full"},
                 {"slowest_over_expected"},
                 {"status"}}),
          Table({{"cells"}, {"mode"}, {"omega", "rad/s"}, {"error"}})};
}

/// Results have the rows of frequencies and of steps.
std::vector<Case> body_cases(const ShapeConfig& config, const std::vector<double>& bar) {
  std::vector<Case> cases;
  for (const ShapeBody& body : config.bodies)
    for (const int across : config.cells)
      for (const Filling& filling : config.fillings) {
        if (across > body.most_cells) continue;
        if (body.aligned && &filling != &config.fillings.front()) continue;  // its cells are full
        cases.push_back({fmt::format("{}, {} cells, {}", body.name, across, filling.label()), [&, across]() {
                           ShapeTables tables = empty_tables();
                           add_frequencies(config, body, filling, across, bar, tables.rows);
                           if (across == config.cells.front())
                             add_steps(config, body, filling, across, tables.steps);
                           return Json{{"rows", rows_of(tables.rows)}, {"steps", rows_of(tables.steps)}};
                         }});
      }
  for (Case& one : cases) one.group = one.name;
  return cases;
}

}  // namespace

std::string Filling::label() const {
  return blend_mass ? fmt::format("{}, b = {:g}", name, *blend_mass) : name;
}

BodyConfig in_cells(const ShapeConfig& config, const ShapeBody& body, const Filling& filling, int across,
                    const Vec3& place, double poisson) {
  const double h = body.across / across;
  MeshFill fill = fill_mesh(body.mesh,
                            {.cell_size = h,
                             .offset = place,
                             .mode = filling.name == "staircase" ? FillMode::staircase : FillMode::local},
                            body.name);
  BodyConfig cells{.voxels = fill.voxels,
                   .contents = std::move(fill.contents),
                   .content_of = std::move(fill.content_of),
                   .cell_size = h,
                   .origin = fill.origin,
                   .density = config.density};
  if (filling.name == "even")
    for (CellContent& content : cells.contents)
      for (PartFill& part : content) part.fill = CellFill::even(part.fill.share());
  cells.fill_blend_mass = filling.blend_mass;
  cells.fill({.young = config.material.young, .poisson = poisson}, config.face_share);
  return cells;
}

ShapeTables measure_shape(const ShapeConfig& config, int processes, Journal& journal, Progress& progress) {
  ShapeTables tables = empty_tables();
  std::vector<double> bar;
  const std::vector<Case> cases = body_cases(config, bar);
  if (!compute_cases(bar_cases(config), processes, journal, progress)) {
    tables.status = Status::interrupted;
    return tables;
  }
  bar = bar_limits(config, journal, tables.reference);
  tables.status = gather_cases(cases, processes, journal, progress, [&](const Json& found) {
    add_rows(found["rows"], tables.rows);
    add_rows(found["steps"], tables.steps);
  });
  return tables;
}

}  // namespace mss::studies::shape
