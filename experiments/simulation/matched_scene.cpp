#include "experiments/simulation/matched_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "core/base/error.hpp"
#include "core/scene/scene_edit.hpp"

namespace mss {

namespace {

using Of = FrequencyMatch::Of;

constexpr int searched = 8;         ///< vibrations of the body to match
constexpr int searched_among = 12;  ///< of larger cells, whose order differs
constexpr std::size_t reported = 6;
/// Of a frequency. What a load that excites this vibration alone moves at rest is off by twice as much.
constexpr double much_off = 0.05;

/// Vibrations to have.
struct Targets {
  Vibrations vibrations;        ///< in the smallest cells computed
  std::vector<double> omega;    ///< of each [rad/s]; of the limit if that is to be matched
  std::vector<bool> has_limit;  ///< false: to be matched, and not found, so that omega is that of these cells
  std::string of;               ///< in words
};

/// Factors of a material's moduli; of all parts alike.
struct ModuliFactors {
  double young = 1;
  double over_shear = 1;  ///< of E over the shear modulus, so of 1 + nu
};

bool changes_poisson(Of of) { return of == Of::both || of == Of::modes; }

double poisson_with(const ElasticConstants& elastic, double over_shear) {
  return (1 + elastic.poisson) * over_shear - 1;
}

/// Of E over the shear modulus: what leaves nu of all parts where springs are well behaved.
std::pair<double, double> allowed_over_shear(const Scene& scene) {
  constexpr double least = -0.5, most = 0.49;
  double low = 0, high = std::numeric_limits<double>::infinity();
  for (const Part& part : scene.body.all_parts()) {
    low = std::max(low, (1 + std::min(least, part.elastic->poisson)) / (1 + part.elastic->poisson));
    high = std::min(high, (1 + std::max(most, part.elastic->poisson)) / (1 + part.elastic->poisson));
  }
  return {low, high};
}

void change(ElasticConstants& elastic, Damping& damping, const ModuliFactors& factors) {
  elastic.young *= factors.young;
  elastic.poisson = poisson_with(elastic, factors.over_shear);
  damping.viscosity *= factors.young / factors.over_shear;
  damping.zeta *= std::sqrt(factors.young);
}

/// A scene with other moduli, and nothing left to match.
Scene with_moduli(Scene scene, Of of, const ModuliFactors& factors) {
  scene.match.reset();
  for (Part& part : scene.body.parts) change(*part.elastic, part.damping, factors);
  SceneEdit edit = edit_of(scene);
  change(*edit.elastic, edit.damping, factors);
  if (changes_poisson(of)) edit.face_share = 1;
  return edited(std::move(scene), edit);
}

/// A scene in cells whose edges are so many times shorter.
Scene in_parts(Scene scene, int parts) {
  scene.match.reset();
  SceneEdit edit = edit_of(scene);
  edit.level *= parts;
  edit.sharing = Sharing::weighted;
  return edited(std::move(scene), edit);
}

std::string in_words(const Scene& fine) { return fmt::format("cells of {:.4g} m", fine.body.cell_size); }

Targets targets_of(const Scene& fine) {
  Targets targets{
      .vibrations = slowest_vibrations(fine, searched), .omega = {}, .has_limit = {}, .of = in_words(fine)};
  for (const Mode& mode : targets.vibrations.modes) targets.omega.push_back(mode.omega);
  targets.has_limit.assign(targets.omega.size(), true);
  return targets;
}

/// Parts of an edge of a cell from which the limit is found: as many as take a moment to compute.
std::pair<int, int> parts_for_limit(const Scene& scene) {
  constexpr double most_cells = 4000;
  for (const int parts : {8, 6, 4, 2})
    if (double(scene.body.voxels.count()) * std::pow(parts, 3) <= most_cells) return {parts / 2, parts};
  return {1, 2};
}

Targets targets_of_limit(const Scene& scene) {
  const auto [few, many] = parts_for_limit(scene);
  const Scene fine = in_parts(scene, many);
  Targets targets = targets_of(fine);
  const Vibrations coarse = slowest_vibrations(in_parts(scene, few), searched_among);
  const std::vector<Partner> pairs = partners(targets.vibrations, coarse);
  const double beyond = std::pow(double(many) / few, 2) - 1;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    targets.has_limit[i] = pairs[i].found();
    if (pairs[i].found()) targets.omega[i] += (targets.omega[i] - coarse.modes[pairs[i].mode].omega) / beyond;
  }
  targets.of = fmt::format("the limit of small cells, from cells of {:.4g} and {:.4g} m",
                           scene.body.cell_size / few, fine.body.cell_size);
  return targets;
}

/// Logarithms of the frequencies to have over those of cells; NaN where no vibration of these is alike.
Eigen::ArrayXd lacks(const Targets& targets, const Scene& scene) {
  const Vibrations own = slowest_vibrations(scene, searched_among);
  const std::vector<Partner> pairs = partners(targets.vibrations, own);
  Eigen::ArrayXd lack(Eigen::Index(pairs.size()));
  for (std::size_t i = 0; i < pairs.size(); ++i)
    lack[Eigen::Index(i)] = pairs[i].found() ? std::log(targets.omega[i] / own.modes[pairs[i].mode].omega)
                                             : std::numeric_limits<double>::quiet_NaN();
  return lack;
}

/// Whether a vibration may set moduli: larger cells have it too, and its frequency is the one to have.
bool can_be_chosen(std::size_t i, const Targets& targets, const Eigen::ArrayXd& lack) {
  return targets.has_limit[i] && std::isfinite(lack[Eigen::Index(i)]);
}

/// The slowest vibration of a kind. Throws InputError where there is none that can be chosen.
std::size_t slowest_of(SectionMotion motion, const Targets& targets, const Eigen::ArrayXd& lack,
                       const Scene& scene) {
  const std::vector<SectionMotion>& motions = targets.vibrations.motions;
  for (std::size_t i = 0; i < motions.size(); ++i)
    if (motions[i] == motion && can_be_chosen(i, targets, lack)) return i;
  std::vector<const char*> names;
  for (const SectionMotion& other : motions) names.push_back(to_string(other));
  throw InputError(fmt::format(
      "{}: body.match = \"{}\" needs a vibration of {} that larger cells have too, and the body's slowest "
      "are {}; give \"modes\", or smaller cells",
      scene.file.string(), to_string(scene.match->of), to_string(motion), fmt::join(names, ", ")));
}

/// Which vibrations set the moduli.
std::vector<Eigen::Index> chosen(const Targets& targets, const Eigen::ArrayXd& lack, const Scene& scene) {
  const Of of = scene.match->of;
  if (targets.omega.empty())
    throw InputError(
        fmt::format("{}: body.match = \"{}\" is of vibrations, and the body has none; leave it out",
                    scene.file.string(), to_string(scene.match->of)));
  std::vector<Eigen::Index> all;
  if (of == Of::bending || of == Of::both)
    all.push_back(Eigen::Index(slowest_of(SectionMotion::bending, targets, lack, scene)));
  if (of == Of::torsion || of == Of::both)
    all.push_back(Eigen::Index(slowest_of(SectionMotion::torsion, targets, lack, scene)));
  if (of == Of::modes)
    for (Eigen::Index i = 0; i < std::min<Eigen::Index>(lack.size(), reported); ++i)
      if (can_be_chosen(std::size_t(i), targets, lack)) all.push_back(i);
  if (all.empty())
    throw InputError(fmt::format(
        "{}: body.match = \"modes\": none of the body's slowest vibrations is like one of its cells of "
        "{:.4g} m; give smaller cells",
        scene.file.string(), scene.body.cell_size));
  return all;
}

/// What the search for moduli ends with.
struct FoundModuli {
  ModuliFactors factors;
  std::vector<Eigen::Index> chosen;  ///< vibrations that set them
  Eigen::ArrayXd lack;               ///< with them
};

/// Finds the factor of 1 + nu with which the lacks of the chosen vibrations are most alike, by steps of Gauss
/// and Newton with slopes between the best point and the last; a factor of E then takes away their mean. Each
/// counts as much as an equal load moves it, by one over its frequency squared.
class ModuliSearch {
 public:
  ModuliSearch(const Scene& scene, const Targets& targets) : scene_(scene), targets_(targets) {}

  FoundModuli run() {
    Point best = evaluate(0);
    if (changes_poisson(scene_.match->of) && chosen_.size() > 1) improve(best);
    return {{.young = std::exp(2 * best.mean), .over_shear = std::exp(best.log_over_shear)},
            chosen_,
            best.lack - best.mean};
  }

 private:
  struct Point {
    double log_over_shear = 0;
    Eigen::ArrayXd lack{};
    double mean = 0;          ///< of those of the chosen, weighted
    Eigen::ArrayXd spread{};  ///< their differences from it, weighted; NaN where one has no partner any more
    double error() const { return spread.square().sum(); }
  };

  /// Steps that lead to larger errors, or to where a chosen vibration is lost, are at least halved.
  void improve(Point& best) {
    constexpr int most_steps = 16;
    constexpr double enough = 1e-5, near_enough = 1e-3, first_step = 0.05;
    const auto [low, high] = allowed_over_shear(scene_);
    double step = std::log(high) < first_step ? -first_step : first_step;
    for (int i = 0; i < most_steps; ++i) {
      const double next = std::clamp(best.log_over_shear + step, std::log(low), std::log(high));
      const double moved = next - best.log_over_shear;
      if (!(std::abs(moved) > enough)) return;
      Point point = evaluate(next);
      step = moved / 2;
      if (!std::isfinite(point.error())) continue;
      const Eigen::ArrayXd slope = (point.spread - best.spread) / moved;
      const bool is_better = point.error() < best.error();
      if (is_better) best = std::move(point);
      const double most = is_better ? std::numeric_limits<double>::infinity() : std::abs(moved) / 2;
      step = std::clamp(-(best.spread * slope).sum() / slope.square().sum(), -most, most);
    }
    if (std::abs(step) > near_enough)
      throw InputError(fmt::format(
          "{}: body.match = \"{}\": no E and nu were found in {} tries that serve these vibrations alike; "
          "give \"bending\" or \"torsion\", or smaller cells",
          scene_.file.string(), to_string(scene_.match->of), most_steps));
  }

  Point evaluate(double log_over_shear) {
    Point point{.log_over_shear = log_over_shear,
                .lack = lacks(targets_, with_moduli(scene_, scene_.match->of,
                                                    {.over_shear = std::exp(log_over_shear)}))};
    if (chosen_.empty()) chosen_ = chosen(targets_, point.lack, scene_);
    Eigen::ArrayXd weight(Eigen::Index(chosen_.size()));
    for (std::size_t i = 0; i < chosen_.size(); ++i)
      weight[Eigen::Index(i)] = 1 / std::pow(targets_.omega[std::size_t(chosen_[i])], 2);
    const Eigen::ArrayXd lack = point.lack(chosen_);
    point.mean = (weight.square() * lack).sum() / weight.square().sum();
    point.spread = weight * (lack - point.mean);
    return point;
  }

  const Scene& scene_;
  const Targets& targets_;
  std::vector<Eigen::Index> chosen_;
};

/// What an equal load would move the vibration too far, or too little where negative, over its frequency
/// squared; 0 where it is matched well enough.
double excess(const MatchedVibration& v) {
  if (!(std::abs(v.mismatch) > much_off)) return 0;
  return (1 / std::pow(1 + v.mismatch, 2) - 1) / (v.frequency * v.frequency);
}

/// About the vibration that makes the largest error under an equal load, and the slowest without counterpart.
std::vector<std::string> warnings_of(const MatchReport& report) {
  std::vector<std::string> warnings;
  const std::vector<MatchedVibration>& all = report.vibrations;
  const MatchedVibration& worst = *std::max_element(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::abs(excess(a)) < std::abs(excess(b));
  });
  if (const double too_far = excess(worst) * worst.frequency * worst.frequency; too_far != 0)
    warnings.push_back(fmt::format(
        "matched cells do not serve all motions: a vibration ({}, {:.4g} Hz) is {:.2g} % too {}, so loads "
        "that "
        "excite it move the body {:.2g} % too {}; give smaller cells where that matters",
        to_string(worst.motion), worst.frequency, 100 * std::abs(worst.mismatch),
        worst.mismatch < 0 ? "slow" : "fast", 100 * std::abs(too_far), too_far > 0 ? "far" : "little"));
  const auto missing =
      std::find_if(all.begin(), all.end(), [](const auto& v) { return std::isnan(v.mismatch); });
  if (missing != all.end())
    warnings.push_back(fmt::format(
        "matched cells have none of the body's vibrations at {:.4g} Hz ({}); give smaller cells where that "
        "matters",
        missing->frequency, to_string(missing->motion)));
  return warnings;
}

MatchReport report_of(const Scene& scene, const Scene& now, const Targets& targets,
                      const FoundModuli& found) {
  MatchReport report{.of = scene.match->of,
                     .to = targets.of,
                     .before = *scene.body.elastic,
                     .after = *now.body.elastic,
                     .face_share = now.face_share};
  for (std::size_t i = 0; i < targets.omega.size(); ++i) {
    const bool is_chosen =
        std::find(found.chosen.begin(), found.chosen.end(), Eigen::Index(i)) != found.chosen.end();
    if (i >= reported && !is_chosen) continue;
    report.vibrations.push_back({.motion = targets.vibrations.motions[i],
                                 .frequency = targets.omega[i] / (2 * std::numbers::pi),
                                 .mismatch = std::expm1(-found.lack[Eigen::Index(i)]),
                                 .is_matched = is_chosen,
                                 .has_limit = targets.has_limit[i]});
  }
  return report;
}

MatchedScene matched_with(const Scene& scene, const std::function<Targets()>& find_targets) {
  const auto start = std::chrono::steady_clock::now();
  const Targets targets = find_targets();
  const FoundModuli found = ModuliSearch(scene, targets).run();
  MatchedScene result{with_moduli(scene, scene.match->of, found.factors)};
  if (scene.body.any_part([](const Part& part) { return part.damping.law == Damping::Law::thesis; }))
    result.scene.warnings.emplace_back(
        "damping.thesis is left as it is where body.match changes moduli: vibrations decay otherwise than in "
        "smaller cells; give damping.viscosity where that matters");
  result.report = report_of(scene, result.scene, targets, found);
  for (std::string& warning : warnings_of(*result.report))
    result.scene.warnings.push_back(std::move(warning));
  result.report->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

std::string mismatch_in_words(double share) {
  return std::isnan(share) ? "has no counterpart" : fmt::format("{:+.1f} %", 100 * share + 0.0);
}

}  // namespace

double MatchReport::largest(bool matched) const {
  double most = 0;
  for (const MatchedVibration& v : vibrations)
    if (v.is_matched == matched && std::isfinite(v.mismatch)) most = std::max(most, std::abs(v.mismatch));
  return most;
}

MatchedScene matched(const Scene& scene) {
  if (!scene.match) return {scene};
  return matched_with(scene, [&] {
    return scene.match->parts > 0 ? targets_of(in_parts(scene, scene.match->parts)) : targets_of_limit(scene);
  });
}

MatchedScene matched_to(Scene scene, FrequencyMatch::Of of, const Scene& fine) {
  scene.match = FrequencyMatch{.of = of};
  return matched_with(scene, [&] { return targets_of(fine); });
}

MatchedScene load_matched_scene(const std::filesystem::path& file,
                                const std::vector<std::string>& overrides) {
  return matched(load_scene(file, overrides));
}

std::vector<std::string> description(const MatchReport& report) {
  std::vector<std::string> lines{
      fmt::format("match = \"{}\": E {:.4g} -> {:.4g} Pa, nu {:.4g} -> {:.4g}, face_share {:.3g}, for {}",
                  to_string(report.of), report.before.young, report.after.young, report.before.poisson,
                  report.after.poisson, report.face_share, report.to)};
  for (const MatchedVibration& v : report.vibrations)
    lines.push_back(fmt::format("  {:<12} {:>10.4g} Hz  {}{}", to_string(v.motion), v.frequency,
                                mismatch_in_words(v.mismatch),
                                v.is_matched   ? "  (matched)"
                                : !v.has_limit ? "  (beside the smallest cells: its limit was not found)"
                                               : ""));
  return lines;
}

Json to_json(const std::optional<MatchReport>& report) {
  if (!report) return {};
  Json vibrations = Json::array();
  for (const MatchedVibration& v : report->vibrations)
    vibrations.push_back({{"motion", to_string(v.motion)},
                          {"frequency", v.frequency},
                          {"mismatch", v.mismatch},  // null where it has no counterpart
                          {"matched", v.is_matched},
                          {"has_limit", v.has_limit}});
  return {{"of", to_string(report->of)},
          {"to", report->to},
          {"young_before", report->before.young},
          {"poisson_before", report->before.poisson},
          {"young", report->after.young},
          {"poisson", report->after.poisson},
          {"face_share", report->face_share},
          {"vibrations", vibrations},
          {"seconds", report->seconds}};
}

}  // namespace mss
