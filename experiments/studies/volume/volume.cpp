// Change of a body's volume: against resolution, strain, twist and the stiffness of the volume force, for the
// thesis's springs, calibrated ones, Mollemans's force and finite elements, beside the prediction of
// elasticity. In elasticity a material of Poisson's ratio nu gains volume in tension, (1 - 2 nu) of the
// strain where its ends may contract: less change of volume is an improvement only down to that value.
#include "experiments/studies/volume/volume.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/forces/cell_geometry.hpp"
#include "core/measures/measures.hpp"
#include "experiments/harness/case_rows.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/simulation/equilibrium.hpp"
#include "experiments/simulation/model.hpp"
#include "integrators/analysis/modes.hpp"
#include "reference/calculix/calculix.hpp"

namespace mss::studies::volume {

namespace {

constexpr double young = 1416.67;  ///< of the thesis's springs along an edge [Pa]
constexpr double degree = std::numbers::pi / 180;

/// One way to deform the cube.
struct Loading {
  Study study = Study::cells;
  double strain = 0;
  double angle = 0;  ///< [degrees]
};

bool is_free(Study study) { return study == Study::free || study == Study::tension; }

const Box lower_plate{{0, 0, 0}, {1, 1, 0}}, upper_plate{{0, 0, 1}, {1, 1, 1}};

/// Between plates without friction; two planes of symmetry fix the rigid motions.
Environment free_stretch(double strain) {
  return {.holds = {{.box = {{0, 0, 0}, {0, 1, 1}}, .axes = {true, false, false}},
                    {.box = {{0, 0, 0}, {1, 0, 1}}, .axes = {false, true, false}},
                    {.box = lower_plate, .axes = {false, false, true}},
                    {.box = upper_plate, .axes = {false, false, true}, .displacement = {0, 0, strain}}}};
}

/// Clamped to both plates; the upper one moves and rotates, and is in place after a second.
Environment clamped(const Loading& load) {
  return {
      .holds = {{.box = lower_plate},
                {.box = upper_plate,
                 .displacement = {0, 0, load.strain},
                 .turn = Turn{
                     .axis = {0, 0, 1}, .centre = {0.5, 0.5, 0}, .rate = load.angle * degree, .until = 1}}}};
}

Vec3 deformed(const Loading& load, const Vec3& rest) {
  const Vec3 centre(0.5, 0.5, 0);
  const Vec3 turned = Eigen::AngleAxisd(load.angle * degree * rest[2], Vec3::UnitZ()) * (rest - centre);
  return centre + turned + Vec3(0, 0, load.strain * rest[2]);
}

/// Relative change of volume by elasticity, to first order; 0 where there is no prediction.
double predicted(const VolumeModel& model, const Loading& load, const BodyConfig& body) {
  if (is_free(load.study)) {
    const CubicStiffness c = cubic_stiffness(body.springs, body.cell_size);
    const double poisson = model.poisson ? *model.poisson : c.c12 / (c.c11 + c.c12);  // along an edge
    return (1 - 2 * poisson) * load.strain;
  }
  if (!model.poisson) return 0;
  return reference::calculix_value("glued_stretch", *model.poisson, "swelling").value * load.strain;
}

void add_equilibrium(Table& rows, const VolumeConfig& config, const VolumeModel& model, int n,
                     const Loading& load) {
  const Body body(volume_cube(model, n));
  const Environment environment = is_free(load.study) ? free_stretch(load.strain) : clamped(load);
  const auto system = config.make(model.model, body, environment);
  auto [status, state] = find_equilibrium(*system, [&](const Vec3& rest) { return deformed(load, rest); });
  // Far from rest an equilibrium need not be one that a body keeps.
  Work work;
  if (status == Status::ok && load.study == Study::tension)
    status = slowest_modes(*system, state, 1, work).status;
  const Measures m = measure(*system, state);
  add_row(rows, {.study = load.study,
                 .model = model.name,
                 .integrator = "static",
                 .cells = n,
                 .strain = load.strain,
                 .angle = load.angle,
                 .springs = body.config().springs,
                 .drift = m.volume_ratio - 1,
                 .drift_thesis = m.volume_ratio_thesis - 1,
                 .worst_cell = worst_cell(body, state.x),
                 .predicted = predicted(model, load, body.config()),
                 .status = status});
}

VolumeModel thesis(double k_vol) {
  return {.name = fmt::format("thesis's, k_vol = {:g}", k_vol),
          .filling = Filling::thesis_springs,
          .model = spring_model,
          .thesis_volume = k_vol};
}

VolumeModel springs(double poisson) {
  return {.name = fmt::format("springs, nu = {:g}", poisson),
          .filling = Filling::springs,
          .model = spring_model,
          .poisson = poisson};
}

VolumeModel mollemans(double poisson) {
  return {.name = fmt::format("Mollemans's, nu = {:g}", poisson),
          .filling = Filling::mollemans,
          .model = "mollemans",
          .poisson = poisson};
}

VolumeModel elements(double poisson) {
  return {.name = fmt::format("elements, nu = {:g}", poisson),
          .filling = Filling::elements,
          .model = "corotational",
          .poisson = poisson};
}

/// That do not lock where nu is near 1/2.
VolumeModel mean_elements(double poisson) {
  return {.name = fmt::format("elements, mean dilatation, nu = {:g}", poisson),
          .filling = Filling::mean_elements,
          .model = "corotational_mean_dilatation",
          .poisson = poisson};
}

/// Every model once, in the order of first use.
Table model_table(const VolumeConfig& config) {
  Table table({{"model"}, {"filling"}, {"law"}, {"poisson"}, {"status"}});
  std::vector<std::string> done;
  for (const auto* models : {&config.models, &config.materials, &config.stretched})
    for (const VolumeModel& m : *models) {
      if (std::find(done.begin(), done.end(), m.name) != done.end()) continue;
      done.push_back(m.name);
      table.add({m.name, std::string(to_string(m.filling)), m.model, m.poisson.value_or(no_value),
                 std::string(m.poisson ? "ok" : "anisotropic")});
    }
  return table;
}

Json configuration(const VolumeConfig& c) {
  const auto names = [](const std::vector<VolumeModel>& models) {
    Json json = Json::array();
    for (const VolumeModel& m : models) json.push_back({{"name", m.name}, {"model", m.model}});
    return json;
  };
  return {{"body", "cube of 1 m between two plates, one moved; at rest"},
          {"cells", c.cells},
          {"small_strain", c.small_strain},
          {"strains", c.strains},
          {"angles", c.angles},
          {"models", names(c.models)},
          {"free", names(c.materials)},
          {"tiny_strain", c.tiny_strain},
          {"stretched", names(c.stretched)},
          {"tensions", c.tensions},
          {"study_cells", c.study_cells},
          {"bounce", "the cube, damping ratio 0.05, falls tilted at 0.5 m/s; penalty contact, restitution 1"},
          {"integrators", c.integrators},
          {"steps", c.step_shares},
          {"prediction", "clamped: CalculiX C3D20; free: 1 - 2 nu; to first order in the strain"}};
}

constexpr const char* caption =
    "Change of a cube's volume at equilibrium between two plates: clamped to them and stretched, compressed "
    "or twisted, or free to contract. Volume changes in elasticity too; less change than it predicts is an "
    "error as well. Predictions: clamped, quadratic finite elements (CalculiX) to first order in the strain; "
    "free, 1 - 2 nu. The thesis's springs are scaled to be the same material as at five cells per edge. "
    "Rows of the study `tension` are far stretched between plates without friction: below nu = 1/4 the sides "
    "give way at some strain, beyond which there is no equilibrium, or none that is stable. "
    "Mollemans's force is eq. 1-1 with the sign that restores volume, calibrated like k_vol. Volumes are "
    "exact (trilinear cells); the thesis's estimate and the worst cell are in the table and in a chart. Rows "
    "of the study `bounce` have the largest change of volume during the motion, and its largest difference "
    "from RK4 with a tenth of the limit of central differences; steps are relative to that limit, 0 are "
    "those of adaptive methods.";

/// The effect of the thesis's volume force on the change of volume, in a sentence.
std::string volume_force_line(const Table& rows) {
  double without = no_value, with = no_value;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "study") != to_string(Study::free) || rows.text(r, "status") != "ok") continue;
    if (rows.text(r, "model") == thesis(0).name) without = rows.number(r, "drift");
    if (rows.text(r, "model") == thesis(0.1).name) with = rows.number(r, "drift");
  }
  if (!std::isfinite(without) || !std::isfinite(with)) return {};
  return fmt::format(
      "the thesis's k_vol = 0.1 changes its cube's change of volume by {:.1e} of it: a negligible effect\n",
      std::abs(with / without - 1));
}

std::string summary(const Table& rows, const VolumeConfig& config) {
  std::string lines;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "study") != to_string(Study::cells) || rows.number(r, "cells") != config.cells.back() ||
        rows.text(r, "status") != "ok")
      continue;
    const double strain = rows.number(r, "strain"), prediction = rows.number(r, "predicted");
    lines += fmt::format("{:<26} change of volume / strain {:.4f} at n = {}; elasticity: {}\n",
                         rows.text(r, "model"), rows.number(r, "drift") / strain, config.cells.back(),
                         prediction == 0 ? "not isotropic" : fmt::format("{:.4f}", prediction / strain));
  }
  return lines + volume_force_line(rows);
}

ExperimentResult run_volume(const ExperimentOptions& options, Progress& progress) {
  const VolumeConfig config = volume_config(options);
  Journal journal = open_journal(options, configuration(config));
  VolumeTables tables = measure_volume(config, options.processes, journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables.rows, config);
  result.tables = volume_files(config, std::move(tables));
  return result;
}

}  // namespace

const char* to_string(Study study) {
  switch (study) {
    case Study::cells:
      return "cells";
    case Study::strain:
      return "strain";
    case Study::twist:
      return "twist";
    case Study::free:
      return "free";
    case Study::tension:
      return "tension";
    case Study::bounce:
      return "bounce";
  }
  return "";
}

const char* to_string(Filling filling) {
  switch (filling) {
    case Filling::thesis_springs:
      return "thesis's springs";
    case Filling::springs:
      return "calibrated springs";
    case Filling::mollemans:
      return "springs and Mollemans's force";
    case Filling::elements:
      return "finite elements";
    case Filling::mean_elements:
      return "finite elements, mean dilatation";
  }
  return "";
}

std::vector<NamedTable> volume_files(const VolumeConfig& config, VolumeTables tables) {
  return {{"volume", std::move(tables.rows)},
          {"volume_bounce", std::move(tables.bounce)},
          {"volume_limit", std::move(tables.limit)},
          {"volume_models", model_table(config)}};
}

double worst_cell(const Body& body, const Field<double>& x) {
  double worst = 0;
  body.for_each_cell([&](std::ptrdiff_t site) {
    worst = std::max(worst, std::abs(trilinear_volume(corners_of(body, x, site)) / body.cell_volume() - 1));
  });
  return worst;
}

void add_row(Table& rows, const VolumeRow& r) {
  const auto measured = [&](double value) { return r.status == Status::ok && !r.refused ? value : no_value; };
  const double shear = cubic_stiffness(r.springs, 1.0 / r.cells).c44;
  rows.add({std::string(to_string(r.study)), r.model, r.integrator, r.cells, r.strain, r.angle, r.step,
            r.springs.volume, r.springs.volume / shear, measured(r.drift), measured(r.drift_thesis),
            measured(r.worst_cell), r.predicted, measured(r.difference),
            std::string(r.refused ? "refused" : to_string(r.status))});
}

BodyConfig volume_cube(const VolumeModel& model, int cells) {
  BodyConfig body{.voxels = VoxelGrid::box(cells, cells, cells), .cell_size = 1.0 / cells};
  if (model.poisson) {
    body.fill({.young = young, .poisson = *model.poisson}, 0.5);
  } else {
    const double k = 100 * 5.0 / cells;
    body.springs = {.edge = k, .face = k, .body = 3 * k, .volume = model.thesis_volume};
  }
  return body;
}

VolumeConfig volume_config(const ExperimentOptions& options) {
  const bool quick = options.quick;
  VolumeConfig config;
  config.cells = options.cells;
  if (config.cells.empty())
    config.cells = quick ? std::vector<int>{1, 2, 4} : std::vector<int>{1, 2, 3, 4, 6, 8, 12, 20};
  config.strains = quick ? std::vector<double>{-0.2, 0.3}
                         : std::vector<double>{-0.3, -0.2, -0.1, -0.05, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5};
  config.angles = quick ? std::vector<double>{30} : std::vector<double>{10, 20, 30, 40, 50};
  config.models = {thesis(0),       thesis(0.1),   springs(0.3),   springs(0.45),
                   mollemans(0.45), elements(0.3), elements(0.45), mean_elements(0.45)};
  config.stretched = {springs(-0.2), springs(0), springs(0.1), springs(0.3)};
  config.tensions = quick ? std::vector<double>{0.05, 0.3}
                          : std::vector<double>{0.05, 0.08, 0.1, 0.15, 0.18, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5};
  config.materials = {thesis(0), thesis(0.1)};
  for (int half_decade = 0; half_decade <= 10; ++half_decade)
    config.materials.push_back(thesis(std::pow(10, half_decade / 2.0)));
  for (const double poisson : {0.25, 0.26, 0.3, 0.35, 0.4, 0.45, 0.48, 0.49}) {
    config.materials.push_back(springs(poisson));
    config.materials.push_back(mollemans(poisson));
    config.materials.push_back(elements(poisson));
  }
  if (quick) config.study_cells = 3;
  config.integrators = options.integrators;
  if (config.integrators.empty())
    for (const IntegratorInfo& info : integrators())
      if (info.moves_particles() && info.has_modulus) config.integrators.push_back(info.name);
  config.step_shares =
      quick ? std::vector<double>{0.4, 3.2} : std::vector<double>{0.2, 0.4, 0.8, 1.6, 3.2, 6.4};
  config.make = [](const std::string& model, const Body& body, const Environment& environment) {
    return make_system<double>(model, body, environment, 1);
  };
  return config;
}

Table empty_rows() {
  return Table({{"study"},
                {"model"},
                {"integrator"},
                {"cells"},
                {"strain"},
                {"angle", "degrees"},
                {"step"},
                {"k_vol", "Pa"},
                {"k_vol_over_shear"},
                {"drift"},
                {"drift_thesis"},
                {"worst_cell"},
                {"predicted"},
                {"difference"},
                {"status"}});
}

Table empty_bounce() {
  return Table(
      {{"model"}, {"integrator"}, {"step"}, {"t", "s"}, {"drift"}, {"drift_thesis"}, {"worst_cell"}});
}

Table empty_limit() {
  return Table({{"model"}, {"limit", "s"}, {"guaranteed", "s"}, {"limit_over_guaranteed"}, {"status"}});
}

namespace {

/// A body at rest under a load.
struct Rest {
  VolumeModel model;
  int cells;
  Loading load;

  std::string name() const {
    return fmt::format("{}: {}, n = {}, strain {:g}, angle {:g}", to_string(load.study), model.name, cells,
                       load.strain, load.angle);
  }
};

std::vector<Rest> rests_of(const VolumeConfig& config) {
  std::vector<Rest> all;
  for (const int n : config.cells)
    for (const VolumeModel& m : config.models)
      all.push_back({m, n, {.study = Study::cells, .strain = config.small_strain}});
  for (const double strain : config.strains)
    for (const VolumeModel& m : config.models)
      all.push_back({m, config.study_cells, {.study = Study::strain, .strain = strain}});
  for (const double angle : config.angles)
    for (const VolumeModel& m : config.models)
      all.push_back({m, config.study_cells, {.study = Study::twist, .angle = angle}});
  for (const double strain : config.tensions)
    for (const VolumeModel& m : config.stretched)
      all.push_back({m, config.study_cells, {.study = Study::tension, .strain = strain}});
  for (const VolumeModel& m : config.materials)
    all.push_back({m, config.study_cells, {.study = Study::free, .strain = config.tiny_strain}});
  return all;
}

/// Results have the rows of the tables, those of falling models of all three.
std::vector<Case> cases_of(const VolumeConfig& config) {
  std::vector<Case> cases;
  for (const Rest& rest : rests_of(config))
    cases.push_back({rest.name(), [&config, rest]() -> Json {
                       Table rows = empty_rows();
                       add_equilibrium(rows, config, rest.model, rest.cells, rest.load);
                       return {{"rows", rows_of(rows)}};
                     }});
  for (const VolumeModel& model : config.models)
    cases.push_back({"bounce: " + model.name, [&]() -> Json {
                       const VolumeTables tables = measure_bounce(config, model);
                       return {{"rows", rows_of(tables.rows)},
                               {"bounce", rows_of(tables.bounce)},
                               {"limit", rows_of(tables.limit)}};
                     }});
  for (Case& one : cases) one.group = one.name;
  return cases;
}

}  // namespace

VolumeTables measure_volume(const VolumeConfig& config, int processes, Journal& journal, Progress& progress) {
  VolumeTables tables{empty_rows(), empty_bounce(), empty_limit()};
  tables.status = gather_cases(cases_of(config), processes, journal, progress, [&](const Json& found) {
    add_rows(found["rows"], tables.rows);
    add_rows(found.value("bounce", Json::array()), tables.bounce);
    add_rows(found.value("limit", Json::array()), tables.limit);
  });
  return tables;
}

namespace {

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  VolumeConfig config = volume_config({.quick = options.quick});
  if (options.quick) {
    config.integrators = {"velocity_verlet", "backward_euler"};
  } else {
    config.cells = {1, 2, 4, 8};
    config.study_cells = 4;
    // What a method that chooses its steps rejects on one processor, by rounding, it takes on another.
    std::erase_if(config.integrators, [](const std::string& name) {
      return find_integrator(name).stepping == Stepping::adaptive;
    });
  }
  Journal journal;
  return measure_volume(config, 1, journal, progress).rows;
}

}  // namespace

ExperimentInfo experiment() {
  return {
      .name = "volume",
      .summary =
          "change of volume against resolution, strain, twist and volume force, beside elasticity's "
          "prediction",
      .accepts = {.cells = true, .largest_cells = 30, .integrators = moving_integrators, .processes = true},
      .run = run_volume,
      .draw = draw_volume,
      .baseline = {.keys = {"study", "model", "integrator", "cells", "strain", "angle", "step"},
                   .rules = {{"k_vol", 1e-12},
                             {"k_vol_over_shear", 1e-12},
                             {"drift", 1e-6, 1e-10},
                             {"drift_thesis", 1e-6, 1e-10},
                             {"worst_cell", 1e-6, 1e-10},
                             {"predicted", 1e-12},
                             {"difference", 1e-3, 1e-9}},
                   .table = baseline_table}};
}

}  // namespace mss::studies::volume
