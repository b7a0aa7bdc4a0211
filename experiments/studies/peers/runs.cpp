#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/error.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/moving_body.hpp"
#include "experiments/studies/peers/peers.hpp"

namespace mss::studies::peers {

namespace {

/// A scene, exported once: its motion with the reference, and, where it rests, the same for longer.
class ExportedScene {
 public:
  ExportedScene(const PeerScene& scene, Progress& progress)
      : scene_(scene), motion_(peer::make_exchange(scene.scene)) {
    peer::add_reference(motion_, progress);
    peer::write_export(motion_, motion_folder());
    if (!scene.rests()) return;
    Scene longer = scene.scene;
    longer.solve.duration = std::ceil(scene.rest_seconds / frame) * frame;
    rest_.emplace(peer::make_exchange(longer, longer.solve.duration));
    peer::write_export(*rest_, rest_folder());
  }

  const PeerScene& scene() const { return scene_; }
  const peer::Exchange& motion() const { return motion_; }
  const peer::Exchange& rest() const { return *rest_; }
  std::filesystem::path motion_folder() const { return folder_.path() / "motion"; }
  std::filesystem::path rest_folder() const { return folder_.path() / "rest"; }

  /// Mean displacement of its end along the axis [m].
  double displacement(const State<double>& state) const {
    double sum = 0;
    const std::vector<std::ptrdiff_t> end = motion_.body->select(scene_.end.lower, scene_.end.upper);
    for (const std::ptrdiff_t site : end)
      sum += state.x.at(site)[scene_.axis] - motion_.start.x.at(site)[scene_.axis];
    return sum / double(end.size());
  }

 private:
  const PeerScene& scene_;
  TemporaryDirectory folder_;
  peer::Exchange motion_;
  std::optional<peer::Exchange> rest_;
};

/// What a family makes of a scene with a setting.
struct Measured {
  double step = no_value;  ///< [s]
  std::string engine{};
  peer::Score score{};
  double rest = no_value;          ///< displacement of the end at rest [m]
  double period = no_value;        ///< [s]
  double displacement = no_value;  ///< of the end of the motion [m]
  std::string status = "ok";
};

/// A table of the study: what it is about and its columns beside those that all have.
struct TableOf {
  std::string name;
  std::vector<Column> columns;
  std::function<std::vector<Cell>(const PeerScene&, const Measured&)> cells;
  std::vector<Question> questions;
};

double relative(double value, double truth) { return value / truth - 1; }

std::vector<TableOf> table_descriptions() {
  const std::vector<Column> volume{{"volume_low"}, {"volume_high"}, {"volume_drift"}};
  const auto with_volume = [&](std::vector<Column> columns) {
    columns.insert(columns.end(), volume.begin(), volume.end());
    return columns;
  };
  return {{"peers",
           with_volume({{"tip", "m"}, {"tip_error"}, {"period", "s"}, {"period_error"}}),
           [](const PeerScene& s, const Measured& o) {
             return std::vector<Cell>{o.rest,
                                      relative(o.rest, s.displacement),
                                      o.period,
                                      relative(o.period, s.period),
                                      o.score.volume_low,
                                      o.score.volume_high,
                                      o.score.volume_drift};
           },
           {Question::bending}},
          {"peers_bars",
           {{"sag", "m"}, {"sag_error"}},
           [](const PeerScene& s, const Measured& o) {
             return std::vector<Cell>{o.rest, relative(o.rest, s.displacement)};
           },
           {Question::hanging}},
          {"peers_flight",
           with_volume({{"spin_drift"}, {"momentum_drift"}, {"motion_error"}}),
           [](const PeerScene&, const Measured& o) {
             return std::vector<Cell>{o.score.spin_drift, o.score.momentum_drift, o.score.error,
                                      o.score.volume_low, o.score.volume_high,    o.score.volume_drift};
           },
           {Question::flight}},
          {"peers_landing",
           with_volume({{"penetration", "m"}, {"motion_error"}}),
           [](const PeerScene&, const Measured& o) {
             return std::vector<Cell>{o.score.penetration, o.score.error, o.score.volume_low,
                                      o.score.volume_high, o.score.volume_drift};
           },
           {Question::landing}},
          {"peers_slope",
           with_volume({{"slid", "m"}, {"slid_error"}, {"penetration", "m"}}),
           [](const PeerScene& s, const Measured& o) {
             return std::vector<Cell>{o.displacement,      relative(o.displacement, s.displacement),
                                      o.score.penetration, o.score.volume_low,
                                      o.score.volume_high, o.score.volume_drift};
           },
           {Question::slope}}};
}

Table empty_table(const TableOf& description) {
  std::vector<Column> columns{{"scene"},  {"particles"}, {"engine"},
                              {"family"}, {"step", "s"}, {"iterations"}};
  columns.insert(columns.end(), description.columns.begin(), description.columns.end());
  columns.insert(columns.end(),
                 {{"cpu_ms_per_frame", "ms"}, {"native_low", "ms"}, {"native_high", "ms"}, {"status"}});
  return Table(std::move(columns));
}

void add_row(Table& table, const TableOf& description, const ExportedScene& exported, const Family& family,
             const Setting& setting, const Measured& outcome) {
  const double cpu = outcome.score.cpu_ms;
  std::vector<Cell> row{exported.scene().name, std::int64_t(exported.motion().body->particle_count()),
                        outcome.engine,        family.name,
                        outcome.step,          std::int64_t(setting.iterations)};
  for (Cell& cell : description.cells(exported.scene(), outcome)) row.push_back(std::move(cell));
  row.insert(row.end(), {cpu, family.in_webassembly ? cpu / most_price_of_webassembly : cpu,
                         family.in_webassembly ? cpu / least_price_of_webassembly : cpu, outcome.status});
  table.add(std::move(row));
}

/// Computes the rows of one scene.
class SceneRuns {
 public:
  SceneRuns(const ExportedScene& exported, Adapters& adapters, Progress& progress)
      : exported_(exported), judge_(exported.motion()), adapters_(adapters), progress_(progress) {}

  Measured run(const Family& family, const Setting& setting) {
    Measured outcome;
    outcome.step = setting.steps > 0 ? frame / setting.steps : no_value;
    try {
      check_possible(family);
      const peer::Result motion =
          family.adapter == Adapter::own
              ? run_family_here(family, setting, exported_.motion(), progress_)
              : run_adapter(adapters_, family, setting, exported_.motion(), exported_.motion_folder(), 0);
      judge(family, motion, outcome);
      if (outcome.status != "ok") return outcome;
      if (exported_.scene().rests()) find_rest(family, setting, outcome);
      if (exported_.scene().question == Question::bending) find_period(motion, outcome);
    } catch (const NoResult& none) {
      outcome.status = none.why;
    } catch (const InputError& error) {  // of a method of this program that cannot serve the scene
      const std::string text = error.what(), before = "solve: ";
      const std::size_t place = text.find(before);
      outcome.status = place == std::string::npos ? text : text.substr(place + before.size());
    }
    return outcome;
  }

 private:
  void check_possible(const Family& family) const {
    const PeerScene& scene = exported_.scene();
    if (family.boxes_only && !scene.scene.voxel_file.empty()) throw NoResult{"made for boxes of cells"};
    if (!family.has_planes && scene.has_planes()) throw NoResult{"given no planes"};
    if (!family.has_modulus && scene.rests()) throw NoResult{"has no modulus"};
  }

  void judge(const Family& family, const peer::Result& motion, Measured& outcome) const {
    outcome.engine = motion.engine;
    if (family.adapter != Adapter::own) outcome.engine += " " + motion.version;
    outcome.step = motion.step;
    outcome.score = judge_.score(motion);
    outcome.status = outcome.score.status;
    if (exported_.scene().question == Question::slope && outcome.status == "ok")
      outcome.displacement = exported_.displacement(motion.samples.back());
  }

  void find_period(const peer::Result& motion, Measured& outcome) const {
    std::vector<double> times, tips;
    for (const State<double>& sample : motion.samples) {
      times.push_back(sample.t);
      tips.push_back(exported_.displacement(sample));
    }
    outcome.period = period_of(times, tips, outcome.rest);
    if (!std::isfinite(outcome.period)) outcome.status = "no whole swing in the time";
  }

  void find_rest(const Family& family, const Setting& setting, Measured& outcome) {
    const PeerScene& scene = exported_.scene();
    if (family.adapter == Adapter::own) {
      outcome.rest = exported_.displacement(rest_here(family, setting, exported_.rest(), scene.drag));
      return;
    }
    const peer::Result rest =
        run_adapter(adapters_, family, setting, exported_.rest(), exported_.rest_folder(), scene.drag);
    if (!rest.problem.empty()) throw NoResult{"on the way to rest: " + rest.problem};
    outcome.rest = exported_.displacement(rest.samples.back());
  }

  const ExportedScene& exported_;
  peer::Judge judge_;
  Adapters& adapters_;
  Progress& progress_;
};

/// Whether there is nothing to be tried with further settings.
bool is_missing(const Measured& outcome) { return outcome.engine.empty() && outcome.status != "ok"; }

/// All rows of a scene; false if stopped.
bool measure_scene(const PeerScene& scene, const PeersConfig& config, const TableOf& description,
                   Table& table, Adapters& adapters, Progress& progress, double done) {
  const ExportedScene exported(scene, progress);
  if (progress.stopped()) return false;
  SceneRuns runs(exported, adapters, progress);
  for (const Family& family : config.families)
    for (const Setting& setting : family.settings) {
      progress.report(done, scene.name + ": " + family.name);
      const Measured outcome = runs.run(family, setting);
      if (progress.stopped()) return false;
      add_row(table, description, exported, family, setting, outcome);
      if (is_missing(outcome)) break;
    }
  return true;
}

}  // namespace

double period_of(const std::vector<double>& times, const std::vector<double>& values, double level) {
  double first = no_value;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (!(values[i - 1] > level && values[i] <= level)) continue;
    const double share = (values[i - 1] - level) / (values[i - 1] - values[i]);
    const double passage = times[i - 1] + share * (times[i] - times[i - 1]);
    if (std::isfinite(first)) return passage - first;
    first = passage;
  }
  return no_value;
}

PeersTables measure_peers(const PeersConfig& config, Progress& progress) {
  const TemporaryDirectory folder;
  const std::vector<PeerScene> scenes = peer_scenes(config.quick, folder.path());
  Adapters adapters;
  PeersTables result;
  std::size_t done = 0;
  for (const TableOf& description : table_descriptions()) {
    Table table = empty_table(description);
    for (const PeerScene& scene : scenes) {
      if (std::count(description.questions.begin(), description.questions.end(), scene.question) == 0)
        continue;
      if (result.status == Status::ok && !measure_scene(scene, config, description, table, adapters, progress,
                                                        double(done) / double(scenes.size())))
        result.status = Status::interrupted;
      ++done;
    }
    if (table.size() > 0 || description.name == "peers")
      result.tables.push_back({description.name, std::move(table)});
  }
  return result;
}

}  // namespace mss::studies::peers
