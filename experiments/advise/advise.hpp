#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/body/spectral_bound.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/scene_edit.hpp"
#include "experiments/advise/trajectory.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/harness/table.hpp"
#include "integrators/integrator.hpp"

namespace mss::advise {

/// What the user of `mss advise` requests.
struct AdviseRequest {
  double error = 0.01;  ///< largest that is allowed, relative to the scale of what it is of
  ErrorOf of = ErrorOf::displacement;
  std::optional<double> budget{};  ///< most seconds that a simulated second may take
  bool of_stability = false;       ///< the budget is required, and no error
  double patience = 60;            ///< most work that a reference may take, by_work() [s]
  Charge charge = by_the_clock;    ///< that costs are in
};

/// Displacement, unless nothing holds the body: where it flies, its path says nothing about its deformation.
ErrorOf default_error_of(const Scene& scene);

/// How planes touch a body, as the scene has it or in a way that lets steps be longer.
struct ContactChoice {
  std::string name;                   ///< "as given", "impulse", "impulse on particles"
  std::vector<std::string> settings;  ///< that make the scene's so, as `--set` takes them
  Scene scene;
};

/// A way to compute a scene.
struct Candidate : SceneEdit {
  std::size_t contact = 0;                       ///< of SceneFamily::contacts()
  std::optional<FrequencyMatch::Of> match = {};  ///< its moduli are matched to the limit of small cells
};

/// What of a candidate is not its method: model, level, face share, volume force, contact, match.
using Lattice = std::tuple<std::string, int, double, bool, std::size_t, std::optional<FrequencyMatch::Of>>;
inline Lattice lattice_of(const Candidate& c) {
  return {c.model, c.level, c.face_share, c.volume_force, c.contact, c.match};
}

/// A scene's body in other cells, of springs that stand for the same material: moduli, and the viscosity that
/// its springs' damping amounts to, stay as they are. A candidate is an edit of the scene.
class SceneFamily {
 public:
  /// Throws InputError for a scene that cannot be computed in another way, with the reason.
  SceneFamily(const std::filesystem::path& file, const std::vector<std::string>& overrides);

  /// The scene of the file.
  const Scene& given() const { return contacts_.front().scene; }
  /// As the scene has it, and where that shortens or slows steps, laws that do not.
  const std::vector<ContactChoice>& contacts() const { return contacts_; }
  /// Whether t is a choice.
  bool is_calibrated() const;
  /// Whether finite elements could stand for its springs.
  bool takes_elements() const;
  /// Whether there is a volume force that could be left out.
  bool has_volume_force() const;

  double cell_size(int level) const { return coarsest_ / level; }

  /// The scene in cells of a level, its springs shared as "weighted" and calibrated with t = 0.5, on one
  /// thread unless the scene gives a number.
  Candidate candidate(int level) const;
  /// The settings that make the file the candidate, as `--set` takes them.
  std::vector<std::string> settings(const Candidate& candidate) const;
  /// Throws InputError if the scene cannot be computed like that.
  Scene scene(const Candidate& candidate) const;
  /// Of the lattice alone; computed once.
  SpectralBound bound(const Candidate& candidate);

 private:
  void add_contacts(const std::filesystem::path& file, const std::vector<std::string>& overrides);

  std::vector<ContactChoice> contacts_;
  std::array<int, 3> base_{};  ///< coarsest cells along each axis
  double coarsest_ = 1;        ///< [m]
  int given_level_ = 1;
  std::map<Lattice, SpectralBound> bounds_;
  mutable std::map<Lattice, Scene> matched_;  ///< that were matched so far
};

/// What is concluded about a trial.
enum class Verdict {
  reference,           ///< computed to compare with
  finest_reference,    ///< the reference that errors are measured against
  checking_reference,  ///< computed to check the advice with
  meets,               ///< meets the error
  meets_but_costlier,  ///< meets it, and something cheaper does too
  ties,                ///< meets it at the cost of what is advised, within the noise
  advised,
  cheapest,           ///< of those that meet the error, but over budget
  inaccurate,         ///< its error is larger than requested
  folds,              ///< a cell is inverted, and in the reference none is
  undecided,          ///< its error is too close to the requested one for the uncertainty of the reference
  fluke,              ///< at half its step the error is larger than requested
  fails_check,        ///< its error against the checking reference is larger than requested
  refuted,            ///< was judged by references that a finer one refuted
  costly,             ///< it would take too much longer than the best so far
  too_costly_to_run,  ///< the same, from an estimate
  failed,             ///< see its status
  interrupted,
  fits,         ///< the budget, stable and unfolded
  over_budget,  ///< it does not fit
  unclean,      ///< run for long, something is wrong, see its problem
  impossible,   ///< the scene cannot be computed like that
  out_of_memory
};

/// A candidate and its result.
struct Trial {
  Candidate candidate;
  double error = no_value;               ///< largest until it ended
  double error_at_half_step = no_value;  ///< the same, or at a quarter of the tolerance
  bool ran_at_half_step = false;         ///< whether that was tried: without a reference it has no error
  double busiest = no_value;             ///< cost of the busiest frames of a long run: nine of ten take less
  double cost = no_value;       ///< seconds charged for stepping per simulated second: the median of `costs`
  std::vector<double> costs{};  ///< of runs in turn with those of rivals; empty: it was run once
  double share = 0;             ///< of the duration that was simulated
  double min_jacobian = no_value, max_stretch = no_value;  ///< extremes until it ended
  bool meets = false;                                      ///< the error
  Verdict verdict = Verdict::reference;
  Status status = Status::ok;                                    ///< of a failed run
  std::string problem{};                                         ///< where it is impossible, or unclean
  double estimated_cost = no_value;                              ///< where it was costly: at least
  double best_before = std::numeric_limits<double>::infinity();  ///< cost of the best then
  double checked_error = no_value;                               ///< against the checking reference
};

/// The error that a candidate is judged by: that at half its step where that is larger. What errs less by a
/// longer step does so by luck.
double judged_error(const Trial& trial);

/// Costs that differ by less are as good as equal: by what they differ from run to run of the program, of
/// work that is the same.
inline constexpr double cost_noise = 0.1;

/// Matched cells and reduced bodies serve some motions and not others.
bool serves_some_motions(const Candidate& candidate);
/// So they are advised where they are so many times cheaper than the cheapest of all others.
inline constexpr double worth_restricting = 2;

/// The verdict in words, as tables have it.
std::string to_string(const Trial& trial);

/// An advised candidate beside finite elements (corotational, whose law is that of the springs to first order
/// in strains) in cells half as large, and these beside elements in cells as large: the references of the
/// search are springs, and might share an error.
struct ElementCheck {
  int level = 0;                  ///< of the finer elements; 0: there are none
  std::string problem{};          ///< why not; empty where the scene is not of calibrated springs
  double error = no_value;        ///< of the candidate against the finer
  double uncertainty = no_value;  ///< a third of what halving the cells changes
  double cost = no_value;         ///< of elements in the candidate's cells, in seconds as Trial::cost
  double cost_of_finer = no_value;
};

/// What is advised, or why nothing is.
struct Advice {
  std::vector<Trial> trials;  ///< in the order they were run
  std::optional<std::size_t>
      best;  ///< of the cheapest that meet the error the most accurate, whatever the budget
  std::vector<std::size_t> ties;  ///< that cost as much, within the noise
  bool within_budget = false;
  double uncertainty = 0;           ///< of the reference, as errors are measured
  bool errors_rank = true;          ///< false: the reference is too uncertain, and the size of cells ranks
  bool reference_folds = false;     ///< then candidates may
  int finest_level = 0;             ///< of the references
  double checked_error = no_value;  ///< of the best against a finer one
  ElementCheck elements{};          ///< of the best
  double seconds = 0;               ///< that all of it took by the clock
  std::string explanation;          ///< a sentence where nothing is advised; empty otherwise
  std::string about_matched;        ///< why matched cells were taken or left
  std::string about_reduced;        ///< the same of reduced bodies
  bool stopped = false;             ///< by the user
};

/// Finds the cheapest candidate that meets an error. Throws InputError for requests that make no sense.
Advice advise(SceneFamily& family, const AdviseRequest& request, Progress& progress);

/// How long what is advised for a budget was run without anything to warn of, at least [s].
inline constexpr double clean_seconds = 10;

/// Finds the most accurate candidate of fixed steps that fits a budget, unfolded and without a warning in
/// `clean_seconds`: methods in the smallest cells that fit, with springs and laws of contact that do.
Advice advise_for_frames(SceneFamily& family, const AdviseRequest& request, Progress& progress);

/// Every candidate that advise() chooses among, up to a level: what advice is compared with. The reference is
/// of another level than the advisor's. Each is run to its end, unless, `pruned`, it errs by the whole scale
/// or takes ten times as long as the best so far or forty times as long as the reference's method.
Advice try_all(SceneFamily& family, const AdviseRequest& request, int finest_level, int reference_level,
               bool pruned, Progress& progress);

}  // namespace mss::advise
