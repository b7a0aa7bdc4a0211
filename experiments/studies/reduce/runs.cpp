// Measurements of `mss reduce`: per scene a reference by fine explicit steps of the body's own lattice, then
// every candidate's error, then the times of all, in turn.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/processor_time.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/studies/reduce/errors.hpp"
#include "experiments/studies/reduce/losses.hpp"
#include "experiments/studies/reduce/movers.hpp"
#include "experiments/studies/reduce/reduce.hpp"

namespace mss::studies::reduce {

namespace {

/// A model of a scene, and what was measured of it.
struct Candidate {
  std::string model{};
  std::string setting{};    ///< of the model
  LatticeChoice lattice{};  ///< that is stepped, or whose body is reduced
  int modes = 0;            ///< 0: each particle of the lattice moves by itself
  std::unique_ptr<Mover> mover{};
  double error = no_value;
  std::vector<double> step_us{}, draw_us{};  ///< a frame
  double setup_ms = 0;                       ///< of a model that reduces
  std::string status = "ok";
  std::string warned{};  ///< of what, in sentences; empty: of nothing

  bool ran() const { return status == "ok"; }
  bool is_unmatched() const { return model == spring_model; }
  bool is_explicit_lattice() const { return is_unmatched() || model.rfind("matched", 0) == 0; }
  double cost() const { return quartiles(step_us).median + quartiles(draw_us).median; }
};

/// A lattice in larger cells, and what its moduli cannot match.
struct MatchedLattice {
  LatticeChoice lattice;
  double mismatch_matched = 0, mismatch_others = 0;  ///< of frequencies
  std::string status = "ok";                         ///< or what it is warned of
};

std::string name_of(FrequencyMatch::Of of) { return "matched_" + to_string(of); }

/// Lattices that were matched to the vibrations of a subject.
class MatchedLattices {
 public:
  explicit MatchedLattices(const Subject& subject) : subject_(subject) {}

  const MatchedLattice& find(int cells, double face_share, FrequencyMatch::Of of) {
    const auto key = std::tuple{cells, face_share, of};
    if (const auto found = known_.find(key); found != known_.end()) return found->second;
    const Solid& solid = subject_.solid;
    const LatticeChoice own{cells, solid.young, 0.3, face_share};
    MatchedLattice found{own};
    try {
      const MatchedScene now =
          matched_to(scene_on({}, solid, own), of, scene_on({}, solid, {subject_.cells.back(), solid.young}));
      const MatchReport& report = *now.report;
      found.lattice = {cells, report.after.young, report.after.poisson, report.face_share};
      found.mismatch_matched = report.error_of_matched();
      found.mismatch_others = report.error_of_others();
      if (!now.scene.warnings.empty()) found.status = now.scene.warnings.front();
    } catch (const InputError& error) {
      found.lattice.young = found.lattice.poisson = no_value;
      found.mismatch_matched = found.mismatch_others = no_value;
      found.status = error.what();
    }
    return known_.emplace(key, found).first->second;
  }

  void add_rows(Table& rows) const {
    for (const auto& [key, found] : known_)
      rows.add({subject_.solid.name, name_of(std::get<2>(key)), std::int64_t(std::get<0>(key)),
                std::get<1>(key), found.lattice.young, found.lattice.poisson, found.mismatch_matched,
                found.mismatch_others, found.status});
  }

 private:
  const Subject& subject_;
  std::map<std::tuple<int, double, FrequencyMatch::Of>, MatchedLattice> known_;
};

/// A scene's body on its own lattice, its true motion, and its candidates.
class SceneRuns {
 public:
  SceneRuns(const ReduceConfig& config, const ReduceScene& scene, MatchedLattices& lattices)
      : config_(config),
        scene_(scene),
        subject_(config.subjects[scene.solid]),
        lattices_(lattices),
        own_{subject_.cells.back(), subject_.solid.young},
        on_lattice_(scene_on(scene, subject_.solid, own_)),
        body_(on_lattice_.body),
        start_(start_of(scene, subject_.solid, on_lattice_, body_)),
        errors_(subject_.solid, body_, motion(truth_share)) {
    uncertainty_ = errors_.of(motion(2 * truth_share));
    complaint_ = reduce_complaint(scene, subject_.solid, body_, start_, errors_.reference());
  }

  void measure(Progress& progress) {
    add_candidates(progress);
    for (Candidate& c : candidates_) {
      if (progress.stopped()) return;
      find_error(c);
    }
    interleave(config_.repetitions, candidates_.size(), progress,
               [&](std::size_t i) { take_times(candidates_[i]); });
  }

  void add_rows(Table& rows) const {
    for (const Candidate& c : candidates_) {
      const Quartiles step = quartiles(c.step_us), draw = quartiles(c.draw_us);
      rows.add({scene_.name,
                c.model,
                c.setting,
                std::int64_t(c.lattice.cells),
                std::int64_t(c.modes),
                c.lattice.face_share,
                c.lattice.young,
                c.lattice.poisson,
                std::int64_t(c.mover ? c.mover->steps() : 0),
                c.error,
                step.median,
                step.q1,
                step.q3,
                draw.median,
                draw.q1,
                draw.q3,
                c.setup_ms,
                gain(c, false),
                gain(c, true),
                complaint_.empty() ? c.status : complaint_,
                c.warned});
    }
  }

  void add_scene(Table& scenes) const {
    scenes.add({scene_.name, scene_.label, subject_.solid.name, scene_.description, std::int64_t(own_.cells),
                std::int64_t(body_.particle_count()), uncertainty_,
                std::string(complaint_.empty() ? "ok" : complaint_)});
  }

 private:
  static constexpr double truth_share = 0.25;

  FramePositions motion(double share) const {
    const MovingBody moving(on_lattice_.body, on_lattice_.environment, as_many_threads_as_pay);
    const IntegratorInfo& info = find_integrator("rk4");
    const ExplicitSteps steps = explicit_steps(info, moving.system.spectral_bound(), frame, share);
    const auto method = info.make<double>({.dt = steps.dt});
    State<double> state = start_;
    Work work;
    FramePositions all;
    for (int i = 1; i <= config_.frames; ++i) {
      if (method->advance(moving.system, state, i * frame, work) != Status::ok)
        throw std::runtime_error("the reference of " + scene_.name + " fails");
      all.push_back(state.x);
    }
    return all;
  }

  void add_candidates(const Progress& progress) {
    using Of = FrequencyMatch::Of;
    const Of first = scene_.happening == Happening::twist ? Of::torsion : Of::bending;
    for (const int cells : subject_.cells) {
      if (progress.stopped()) return;
      add_lattice({cells, own_.young, own_.poisson, own_.face_share}, spring_model);
      if (cells == own_.cells) break;
      add_lattice({cells, own_.young, own_.poisson, 1}, spring_model);
      if (subject_.solid.clamped)
        for (const auto& [face_share, of] : {std::pair{0.5, first}, {1.0, first}, {1.0, Of::both}})
          add_matched(cells, face_share, of);
      if (subject_.all_modes) add_matched(cells, 1, Of::modes);
    }
    for (const ReducedModel& model : subject_.models) {
      if (progress.stopped()) return;
      Candidate c{.model = model.name, .lattice = own_, .modes = model.modes};
      try {
        Scene scene = scene_on(scene_, subject_.solid, own_, model.name);
        scene.modes = model.modes;
        c.setup_ms = 1e3 * processor_seconds_of([&] { c.mover = reduced_mover(scene, body_, start_); });
        c.warned = fmt::to_string(fmt::join(reduced_warnings(scene, body_, start_, config_.frames), "; "));
      } catch (const InputError& error) {
        c.status = fmt::format("not built: {}", error.what());
      }
      candidates_.push_back(std::move(c));
    }
    if (scene_.losses) add_losses(progress);
  }

  void add_losses(const Progress& progress) {
    for (const int points : {2, 3})
      for (const bool of_own_frequency : {false, true}) {
        const char* e = of_own_frequency ? "E matched" : "E as it is";
        Candidate c{.model = "frames",
                    .setting = fmt::format("{} control points, {}", points, e),
                    .lattice = own_,
                    .modes = 12 * points};
        c.setup_ms = 1e3 * processor_seconds_of([&] {
                       c.mover = frames_mover(scene_, subject_.solid, own_, points, of_own_frequency, start_);
                     });
        candidates_.push_back(std::move(c));
      }
    for (const int steps : {1, 64}) {
      for (const int cells : subject_.cells)
        for (const int width : {1, 2, 4})
          if (!progress.stopped() && own_.cells % cells == 0 && 4 * width <= cells)
            add_best("shape_matching", cells, fmt::format("regions of {}, {} steps", 2 * width + 1, steps),
                     [&](double alpha) {
                       return shape_mover(scene_, subject_.solid,
                                          {cells, own_.young, own_.poisson, own_.face_share},
                                          {width, steps, alpha}, body_);
                     });
      if (progress.stopped()) return;
      add_best("adaptive_shape_matching", own_.cells, fmt::format("{} steps", steps), [&](double alpha) {
        return adaptive_shape_mover(scene_, subject_.solid, body_, start_, steps, alpha);
      });
    }
  }

  /// A model without a modulus, with what makes it stiff as it serves the scene best.
  template <class Make>
  void add_best(const std::string& model, int cells, const std::string& setting, Make&& make) {
    constexpr int quarterings = 5;
    std::optional<Candidate> best;
    for (int i = 0; i <= quarterings; ++i) {
      const double alpha = std::ldexp(1, -2 * i);
      Candidate c{.model = model,
                  .setting = fmt::format("{}, alpha {:g}", setting, alpha),
                  .lattice = {cells, own_.young, own_.poisson, own_.face_share},
                  .mover = make(alpha)};
      find_error(c);
      if (!best || (c.ran() && !(c.error >= best->error))) best = std::move(c);
    }
    candidates_.push_back(std::move(*best));
  }

  void add_matched(int cells, double face_share, FrequencyMatch::Of of) {
    const MatchedLattice& found = lattices_.find(cells, face_share, of);
    const bool is_there = std::isfinite(found.lattice.young);
    add_lattice(found.lattice, name_of(of), is_there ? "ok" : found.status,
                is_there && found.status != "ok" ? found.status : "");
  }

  void add_lattice(const LatticeChoice& lattice, const std::string& model, const std::string& status = "ok",
                   const std::string& warned = "") {
    Candidate c{.model = model, .lattice = lattice, .status = status, .warned = warned};
    try {
      if (c.ran()) c.mover = lattice_mover(scene_, subject_.solid, c.lattice, body_);
    } catch (const std::runtime_error& error) {
      c.status = error.what();
    }
    candidates_.push_back(std::move(c));
  }

  void find_error(Candidate& c) const {
    if (!c.ran() || std::isfinite(c.error)) return;
    c.mover->restart();
    double largest = 0;
    for (int i = 0; i < config_.frames && c.ran(); ++i) {
      const Status status = c.mover->advance();
      if (status != Status::ok)
        c.status = to_string(status);
      else
        largest = std::max(largest, errors_.at(std::size_t(i), c.mover->draw()));
    }
    if (c.ran()) c.error = largest;
  }

  /// A sample of each time: the scene from the start on and a picture of its end, as often as they need.
  void take_times(Candidate& c) const {
    if (!c.ran()) return;
    const long motions = motions_in_a_row(c);
    c.step_us.push_back(mean_us([&] { c.mover->restart(); }, [&] { go_on(c, motions); }, motions));
    c.draw_us.push_back(mean_us([] {},
                                [&] {
                                  for (int i = 0; i < config_.frames; ++i) c.mover->draw();
                                },
                                1));
  }

  void go_on(Candidate& c, long motions) const {
    for (long i = 0; i < motions * config_.frames; ++i) c.mover->advance();
  }

  /// What is so quick that asking for the time takes long beside it goes on for longer than its scene.
  long motions_in_a_row(Candidate& c) const {
    constexpr double least_seconds = 1e-4;
    c.mover->restart();
    const double once = std::max(1e-9, processor_seconds_of([&] { go_on(c, 1); }));
    return once < least_seconds ? std::lround(std::ceil(least_seconds / once)) : 1;
  }

  /// Processor time of a frame [us], of a task that computes all frames so many times.
  template <class Prepare, class Task>
  double mean_us(Prepare&& prepare, Task&& task, long motions) const {
    double seconds = 0;
    long runs = 0;
    do {
      prepare();
      seconds += processor_seconds_of(task);
      ++runs;
    } while (seconds < config_.sample_seconds && runs < most_runs);
    return 1e6 * seconds / double(runs * motions * config_.frames);
  }

  /// The cost of the cheapest lattice of no larger error, of the body's own at worst, over a candidate's.
  double gain(const Candidate& of, bool unmatched_alone) const {
    if (!of.ran()) return no_value;
    double least = std::numeric_limits<double>::infinity();
    for (const Candidate& c : candidates_)
      if (c.is_explicit_lattice() && c.ran() && (c.is_unmatched() || !unmatched_alone) &&
          (c.error <= of.error || c.lattice.cells == own_.cells))
        least = std::min(least, c.cost());
    return least / of.cost();
  }

  static constexpr long most_runs = 1000;

  const ReduceConfig& config_;
  const ReduceScene& scene_;
  const Subject& subject_;
  MatchedLattices& lattices_;
  LatticeChoice own_;  ///< the body's
  Scene on_lattice_;
  Body body_;
  State<double> start_;
  MotionErrors errors_;
  double uncertainty_ = 0;
  std::string complaint_;
  std::vector<Candidate> candidates_;
};

Table empty_rows() {
  return Table({{"scene"},          {"model"},         {"setting"},        {"cells"},
                {"modes"},          {"face_share"},    {"young", "Pa"},    {"poisson"},
                {"steps"},          {"error"},         {"step_us", "us"},  {"step_q1", "us"},
                {"step_q3", "us"},  {"draw_us", "us"}, {"draw_q1", "us"},  {"draw_q3", "us"},
                {"setup_ms", "ms"}, {"gain_matched"},  {"gain_unmatched"}, {"status"},
                {"warned"}});
}

Table empty_scenes() {
  return Table({{"scene"},
                {"label"},
                {"body"},
                {"description"},
                {"cells"},
                {"particles"},
                {"uncertainty"},
                {"status"}});
}

Table empty_matched() {
  return Table({{"body"},
                {"model"},
                {"cells"},
                {"face_share"},
                {"young", "Pa"},
                {"poisson"},
                {"mismatch_matched"},
                {"mismatch_others"},
                {"status"}});
}

}  // namespace

ReduceTables measure_reduce(const ReduceConfig& config, Progress& progress) {
  ReduceTables tables{empty_rows(), empty_scenes(), empty_matched()};
  std::vector<MatchedLattices> lattices(config.subjects.begin(), config.subjects.end());
  for (std::size_t s = 0; s < config.scenes.size() && !progress.stopped(); ++s) {
    const ReduceScene& scene = config.scenes[s];
    progress.report(double(s) / double(config.scenes.size()), scene.name);
    try {
      SceneRuns runs(config, scene, lattices[scene.solid]);
      runs.measure(progress);
      if (progress.stopped()) break;
      runs.add_rows(tables.rows);
      runs.add_scene(tables.scenes);
    } catch (const std::runtime_error& error) {  // no start, or no reference: the other scenes go on
      const Solid& solid = config.subjects[scene.solid].solid;
      tables.scenes.add({scene.name, scene.label, solid.name, scene.description,
                         std::int64_t(config.subjects[scene.solid].cells.back()), std::int64_t(0), no_value,
                         std::string(error.what())});
    }
  }
  for (const MatchedLattices& of_subject : lattices) of_subject.add_rows(tables.matched);
  if (progress.stopped()) tables.status = Status::interrupted;
  return tables;
}

}  // namespace mss::studies::reduce
