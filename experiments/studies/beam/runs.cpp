// The runs of `mss validate beam`: equilibria and ring-downs of the scenes of each load.
#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "experiments/harness/case_rows.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "experiments/studies/beam/beam.hpp"
#include "reference/beam/beam.hpp"

namespace mss::studies::beam {

namespace {

constexpr double beam_width = 0.03;   // [m]
constexpr double beam_sample = 2e-3;  // [s] between samples of a motion
constexpr double millimetre = 1e-3;
const std::string turns_less_often = "it turns less often than was measured";

/// Points of the beam that its cells carry: the nearest ones to the markers.
EmbeddedSurface beam_points(const BodyConfig& body) {
  TriangleMesh points;
  for (const reference::BeamMarker& marker : reference::beam_markers())
    points.vertices.push_back(marker.point);
  return {points, body.voxels, body.cell_size, body.origin};
}

/// The rotation that takes the free end from rest to where it is, by least squares over its particles: what
/// stands on it turns so, whatever its cells do next to the weight.
Eigen::Matrix3d rotation_of_end(const Body& body, const Field<double>& x) {
  double end = 0;
  for (const std::ptrdiff_t site : body.sites()) end = std::max(end, body.rest_position(site)[0]);
  Vec3 rest_mean = Vec3::Zero(), mean = Vec3::Zero();
  std::vector<std::ptrdiff_t> face;
  for (const std::ptrdiff_t site : body.sites())
    if (body.rest_position(site)[0] == end) face.push_back(site);
  for (const std::ptrdiff_t site : face) {
    rest_mean += body.rest_position(site) / double(face.size());
    mean += x.at(site) / double(face.size());
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const std::ptrdiff_t site : face)
    sum += (x.at(site) - mean) * (body.rest_position(site) - rest_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * Vec3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

/// Where it moves through beam_start [s], straight between samples; NaN if it does not.
double beam_departure(const std::vector<double>& times, const std::vector<double>& drops) {
  for (std::size_t i = 1; i < drops.size(); ++i)
    if (drops[i] >= reference::beam_start) {
      const double share = (reference::beam_start - drops[i - 1]) / (drops[i] - drops[i - 1]);
      return times[i - 1] + share * (times[i] - times[i - 1]);
    }
  return no_value;
}

}  // namespace

const std::vector<BeamLoad>& beam_loads() {
  static const std::vector<BeamLoad> loads{
      {"none", "silicone_beam"}, {"52 g", "silicone_beam_52g"}, {"102 g", "silicone_beam_102g"}};
  return loads;
}

std::vector<std::string> beam_cells(int across) {
  return {fmt::format("body.cells=[{}, {}, {}]", across / 3 * 10, across, across),
          fmt::format("body.cell_size={}", beam_width / across)};
}

Scene beam_scene(const BeamConfig& config, const BeamMaterial& material, const BeamLoad& load, int cells) {
  std::vector<std::string> settings = beam_cells(cells);
  settings.insert(settings.end(), material.settings.begin(), material.settings.end());
  settings.insert(settings.end(), config.settings.begin(), config.settings.end());
  return load_scene(scene_file(load.scene), settings);
}

BeamRest beam_at_rest(const Scene& scene) {
  Scene at_rest = scene;
  at_rest.solve.integrator = "static";
  at_rest.solve.duration = 1;  // a static method is there at once
  const Body body(at_rest.body);
  SceneRun<double> run(at_rest, body);
  Work work;
  BeamRest rest{.status = run.advance(at_rest.solve.duration, work)};
  if (rest.status != Status::ok) return rest;
  const EmbeddedSurface points = beam_points(at_rest.body);
  const Eigen::Matrix3d rotation = rotation_of_end(body, run.state().x);
  for (std::size_t m = 0; m < points.size(); ++m) {
    const reference::BeamMarker& marker = reference::beam_markers()[m];
    rest.drops.push_back((marker.point - points.at(m, run.state().x))[2]);
    rest.centre_drops.push_back(rest.drops.back() + (marker.offset - rotation * marker.offset)[2]);
  }
  return rest;
}

BeamMotion beam_motion(const Scene& scene, double rest_drop) {
  const Body body(scene.body);
  SceneRun<double> run(scene, body);
  const EmbeddedSurface points = beam_points(scene.body);
  const double level = points.at(ringing_marker, run.state().x)[2];
  BeamMotion motion{.times = {0}, .heights = {rest_drop}};
  std::vector<double> drops{0};
  Work work;
  for (int n = 1; n * beam_sample <= scene.solve.duration * (1 + 1e-9); ++n) {
    const Status status = run.advance(n * beam_sample, work);
    motion.status = to_string(status);
    if (status != Status::ok) return motion;
    if (run.state().t <= motion.times.back()) continue;  // steps longer than that
    motion.times.push_back(run.state().t);
    drops.push_back(level - points.at(ringing_marker, run.state().x)[2]);
    motion.heights.push_back(rest_drop - drops.back());
  }
  const double departure = beam_departure(motion.times, drops);
  if (std::isnan(departure)) motion.status = "it does not move";
  for (double& time : motion.times) time -= departure;
  return motion;
}

RingDown measured_ring_down(const std::string& run) {
  std::vector<Extremum> turns;
  for (const reference::BeamTurn& turn : reference::beam_turns(run))
    turns.push_back({turn.time, turn.height});
  return ring_down(turns, 0, ringing_turns);
}

namespace {

double beam_measured(const std::string& load, const char* run, const std::string& quantity) {
  return reference::beam_value(reference::measured_beam(), load + " " + run, quantity);
}

std::string drop_of(int marker) { return fmt::format("drop_{}_mm", marker); }

Table empty_drops() {
  return Table({{"material"},
                {"load"},
                {"marker"},
                {"cells"},
                {"drop", "mm"},
                {"drop_of_centre", "mm"},
                {"measured_a", "mm"},
                {"measured_b", "mm"},
                {"error_a"},
                {"error_b"},
                {"spread"},
                {"seconds", "s"},
                {"status"}});
}

void add_drops(const BeamMaterial& material, const BeamLoad& load, int cells, const BeamRest& rest,
               double seconds, Table& drops) {
  const bool ok = rest.status == Status::ok;
  for (std::size_t m = 0; m < reference::beam_markers().size(); ++m) {
    const int marker = reference::beam_markers()[m].number;
    const double a = beam_measured(load.name, "a", drop_of(marker)),
                 b = beam_measured(load.name, "b", drop_of(marker));
    const double drop = ok ? rest.drops[m] / millimetre : no_value;
    drops.add({material.name, load.name, marker, cells, drop,
               ok ? rest.centre_drops[m] / millimetre : no_value, a, b, drop / a - 1, drop / b - 1, b / a - 1,
               seconds, std::string(to_string(rest.status))});
  }
}

Table empty_comsol() {
  return Table({{"material"},
                {"load"},
                {"marker"},
                {"cells"},
                {"drop", "mm"},
                {"comsol", "mm"},
                {"drop_over_comsol"},
                {"comsol_error_a"},
                {"comsol_error_b"},
                {"error_a"},
                {"error_b"},
                {"spread"},
                {"status"}});
}

/// Rows of a material in the finest cells, where COMSOL's values are known.
Table beside_comsol(const Table& drops, const std::string& material, int cells) {
  Table comsol = empty_comsol();
  const Table finest = drops.where("material", material).where("cells", cells);
  for (std::size_t r = 0; r < finest.size(); ++r) {
    const auto number = [&](const char* column) { return finest.number(r, column); };
    const int marker = int(number("marker"));
    const double value =
        reference::beam_value(reference::comsol_beam(), finest.text(r, "load"), drop_of(marker));
    if (std::isnan(value)) continue;
    comsol.add({finest.text(r, "material"), finest.text(r, "load"), marker, cells, number("drop"), value,
                number("drop") / value, value / number("measured_a") - 1, value / number("measured_b") - 1,
                number("error_a"), number("error_b"), number("spread"), finest.text(r, "status")});
  }
  return comsol;
}

Table empty_ring_down() {
  return Table({{"material"},
                {"load"},
                {"cells"},
                {"frequency", "Hz"},
                {"frequency_a", "Hz"},
                {"frequency_b", "Hz"},
                {"frequency_error_a"},
                {"frequency_error_b"},
                {"frequency_spread"},
                {"damping_ratio"},
                {"damping_ratio_a"},
                {"damping_ratio_b"},
                {"damping_off_a"},
                {"damping_off_b"},
                {"damping_spread"},
                {"swing_damping_ratio"},
                {"swing_damping_ratio_a"},
                {"swing_damping_ratio_b"},
                {"seconds", "s"},
                {"status"}});
}

/// Turning points of a motion, from the first lower one on.
std::vector<Extremum> turns_of(const BeamMotion& motion) {
  return turning_points(motion.times, motion.heights, 0.02 * std::abs(motion.heights.front()));
}

/// What a motion says of frequency and damping, or why it says nothing.
RingDown ring_down_of(const BeamMotion& motion) {
  if (motion.status != "ok") return {.status = motion.status};
  const std::vector<Extremum> turns = turns_of(motion);
  if (int(turns.size()) < ringing_turns) return {.status = turns_less_often};
  return ring_down(turns, 0, ringing_turns);
}

void add_ring_down(const BeamMaterial& material, const BeamLoad& load, int cells, const BeamMotion& motion,
                   double seconds, Table& rows) {
  const RingDown computed = ring_down_of(motion), a = measured_ring_down(load.name + " a"),
                 b = measured_ring_down(load.name + " b");
  rows.add({material.name,
            load.name,
            cells,
            computed.frequency,
            a.frequency,
            b.frequency,
            computed.frequency / a.frequency - 1,
            computed.frequency / b.frequency - 1,
            b.frequency / a.frequency - 1,
            computed.peak_damping_ratio,
            a.peak_damping_ratio,
            b.peak_damping_ratio,
            computed.peak_damping_ratio - a.peak_damping_ratio,
            computed.peak_damping_ratio - b.peak_damping_ratio,
            b.peak_damping_ratio - a.peak_damping_ratio,
            computed.swing_damping_ratio,
            a.swing_damping_ratio,
            b.swing_damping_ratio,
            seconds,
            computed.status});
}

Table empty_turns() {
  return Table({{"material"},
                {"load"},
                {"cells"},
                {"number"},
                {"time", "s"},
                {"time_a", "s"},
                {"time_b", "s"},
                {"height", "mm"},
                {"height_a", "mm"},
                {"height_b", "mm"},
                {"status"}});
}

void add_turns(const BeamMaterial& material, const BeamLoad& load, int cells, const BeamMotion& motion,
               Table& rows) {
  const std::vector<reference::BeamTurn> a = reference::beam_turns(load.name + " a"),
                                         b = reference::beam_turns(load.name + " b");
  const bool ok = motion.status == "ok";
  const std::vector<Extremum> turns = ok ? turns_of(motion) : std::vector<Extremum>{};
  for (std::size_t n = 0; n < a.size(); ++n) {
    const bool has = n < turns.size();
    rows.add({material.name, load.name, cells, std::int64_t(n + 1), has ? turns[n].time : no_value, a[n].time,
              b.at(n).time, has ? turns[n].value / millimetre : no_value, a[n].height / millimetre,
              b.at(n).height / millimetre, has || !ok ? motion.status : turns_less_often});
  }
}

Table empty_motion() {
  return Table({{"material"}, {"load"}, {"cells"}, {"time", "s"}, {"height", "mm"}, {"status"}});
}

void add_motion(const BeamMaterial& material, const BeamLoad& load, int cells, const BeamMotion& motion,
                Table& rows) {
  for (std::size_t i = 0; motion.status == "ok" && i < motion.times.size(); ++i)
    rows.add({material.name, load.name, cells, motion.times[i], motion.heights[i] / millimetre,
              std::string("ok")});
}

/// One computation, and what it takes beside others.
struct BeamPart {
  double cost;
  Case run;
};

/// On one thread: runs share the cores.
Scene scene_of_run(const BeamConfig& config, const BeamMaterial& material, const BeamLoad& load, int cells) {
  Scene scene = beam_scene(config, material, load, cells);
  scene.solve.threads = 1;
  return scene;
}

/// Rows of drops.
Json measure_rest(const Scene& scene, const BeamMaterial& material, const BeamLoad& load, int cells) {
  const Stopwatch watch;
  const BeamRest rest = beam_at_rest(scene);
  Table drops = empty_drops();
  add_drops(material, load, cells, rest, watch.seconds(), drops);
  return {{"drops", rows_of(drops)}};
}

/// Rows of frequency and damping, of turning points and of the motion.
Json measure_ringing(const Scene& scene, const BeamMaterial& material, const BeamLoad& load, int cells) {
  const BeamRest rest = beam_at_rest(scene);
  const Stopwatch watch;
  const BeamMotion motion = rest.status == Status::ok
                                ? beam_motion(scene, rest.drops[ringing_marker])
                                : BeamMotion{.status = std::string(to_string(rest.status))};
  Table ring_down = empty_ring_down(), turns = empty_turns(), heights = empty_motion();
  add_ring_down(material, load, cells, motion, watch.seconds(), ring_down);
  add_turns(material, load, cells, motion, turns);
  add_motion(material, load, cells, motion, heights);
  return {{"ring_down", rows_of(ring_down)}, {"turns", rows_of(turns)}, {"motion", rows_of(heights)}};
}

std::vector<int> of_material(const BeamMaterial& material, const std::vector<int>& cells) {
  return material.cells == 0 ? cells : std::vector<int>{material.cells};
}

/// Equilibria, whose cost grows as that of factorising, n^6, and ring-downs as cells and steps, n^5: steps of
/// viscous bodies shorten with the square of the cells.
std::vector<BeamPart> beam_parts(const BeamConfig& config) {
  std::vector<BeamPart> parts;
  for (const BeamMaterial& material : config.materials) {
    const auto name = [&](const BeamLoad& load, const char* what, int n) {
      return fmt::format("{}, {}, {}, {} cells across", material.name, load.name, what, n);
    };
    for (const BeamLoad& load : beam_loads())
      for (const int n : of_material(material, config.cells))
        parts.push_back({1e-6 * std::pow(n, 6),
                         {name(load, "at rest", n), [=, scene = scene_of_run(config, material, load, n)] {
                            return measure_rest(scene, material, load, n);
                          }}});
    for (const BeamLoad& load : config.ringing)
      for (const int n : of_material(material, config.ringing_cells))
        parts.push_back({6e-4 * std::pow(n, 5),
                         {name(load, "ringing", n), [=, scene = scene_of_run(config, material, load, n)] {
                            return measure_ringing(scene, material, load, n);
                          }}});
  }
  return parts;
}

/// Counts parts by their cost; they finish about in their order.
class CostProgress final : public Progress {
 public:
  CostProgress(Progress& whole, const std::vector<BeamPart>& parts) : whole_(whole), done_(parts.size() + 1) {
    for (std::size_t i = 0; i < parts.size(); ++i) done_[i + 1] = done_[i] + parts[i].cost;
    whole_.report(0, "rest and ring-downs");
  }
  void report(double done, std::string_view what) override {
    const auto finished = std::size_t(std::lround(done * double(done_.size() - 1)));
    whole_.report(done_[finished] / done_.back(), what);
  }
  bool stopped() const override { return whole_.stopped(); }

 private:
  Progress& whole_;
  std::vector<double> done_;  ///< cost of so many parts
};

/// The longest first, so that cores are busy to the end.
void sort_by_cost(std::vector<BeamPart>& parts) {
  std::stable_sort(parts.begin(), parts.end(),
                   [](const BeamPart& a, const BeamPart& b) { return a.cost > b.cost; });
}

std::vector<Case> cases_of(const std::vector<BeamPart>& parts) {
  std::vector<Case> cases;
  cases.reserve(parts.size());
  for (const BeamPart& part : parts) cases.push_back(part.run);
  return cases;
}

void add_result(const Json& result, BeamTables& tables) {
  for (const auto& [name, table] : {std::pair{"drops", &tables.drops},
                                    {"ring_down", &tables.ring_down},
                                    {"turns", &tables.turns},
                                    {"motion", &tables.motion}})
    if (result.contains(name)) add_rows(result[name], *table);
}

}  // namespace

BeamTables measure_beam(BeamConfig config, Progress& progress) {
  BeamTables tables{empty_drops(), empty_comsol(), empty_ring_down(),
                    empty_turns(), empty_motion(), empty_beam_fits()};
  const double fitted = config.fit_cells > 0 ? 0.6 : 0;  // share of the time
  PartProgress of_fits(progress, 0, fitted), of_runs(progress, fitted, 1);
  if (config.fit_cells > 0)
    for (BeamMaterial& material : fit_beam(config.fit_cells, of_fits, tables.fits))
      config.materials.push_back(std::move(material));
  const std::vector<BeamPart> parts = beam_parts(config);
  std::vector<BeamPart> sorted = parts;
  sort_by_cost(sorted);
  CostProgress by_cost(of_runs, sorted);
  Journal journal;
  compute_cases(cases_of(sorted), 0, journal, by_cost);
  for (const BeamPart& part : parts)
    if (const Json* result = journal.find(part.run.name)) add_result(*result, tables);
  if (progress.stopped()) tables.status = Status::interrupted;
  if (!config.cells.empty())
    tables.comsol = beside_comsol(tables.drops, config.materials.front().name, config.cells.back());
  return tables;
}

}  // namespace mss::studies::beam
