#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/scene.hpp"
#include "core/spectral_bound.hpp"
#include "experiments/advise/trajectory.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/harness/table.hpp"
#include "integrators/integrator.hpp"

namespace mss::advise {

/// Budgets and costs are told by the frame.
inline constexpr double frames_per_second = 60;

/// What `mss advise` is asked.
struct Ask {
  double error = 0.01;  ///< largest there may be, over the scale of what it is of
  ErrorOf of = ErrorOf::displacement;
  std::optional<double> budget{};  ///< most seconds a simulated second may take
  double patience = 60;            ///< seconds that a reference may take
};

/// One way to compute a scene. What is not here stays as the scene has it.
struct Candidate {
  int level = 1;            ///< parts that an edge of the coarsest cells is split into
  double face_share = 0.5;  ///< t of calibrated springs
  bool volume_force = true;
  Precision precision = Precision::dbl;
  std::string integrator{};
  double dt = 0;                ///< [s]; of adaptive methods 0
  std::string linear_solver{};  ///< of implicit methods
  double tolerance = 0;         ///< of adaptive methods
  int threads = 1;              ///< 0: as many as pay
};

/// A scene's body in other cells, of springs that stand for the same material: moduli, and the viscosity that
/// its springs' damping amounts to, stay as they are.
class SceneFamily {
 public:
  /// Throws InputError for a scene that cannot be computed otherwise, naming what stands in the way.
  SceneFamily(std::filesystem::path file, std::vector<std::string> overrides);

  /// The scene as its file has it.
  const Scene& asked() const { return asked_; }
  /// Whether t is a choice.
  bool is_calibrated() const;
  /// Whether there is a volume force that could be left out.
  bool has_volume_force() const;

  double cell_size(int level) const { return coarsest_ / level; }
  /// The level that the file has.
  int asked_level() const { return asked_level_; }

  /// What makes of the file what the candidate says, as `--set` takes it.
  std::vector<std::string> settings(const Candidate& candidate) const;
  /// Throws InputError if the scene cannot be computed like that.
  Scene scene(const Candidate& candidate) const;
  /// Of the lattice alone, remembered.
  SpectralBound bound(const Candidate& candidate);

 private:
  std::filesystem::path file_;
  std::vector<std::string> overrides_;
  Scene asked_;
  bool from_voxels_ = false;
  bool refined_ = false;       ///< the file splits its cells
  std::array<int, 3> base_{};  ///< cells of the coarsest box
  double coarsest_ = 1;        ///< [m]
  int asked_level_ = 1;
  std::map<std::tuple<int, double, bool>, SpectralBound> bounds_;
};

/// What came of a candidate.
struct Trial {
  Candidate candidate;
  double error = std::numeric_limits<double>::quiet_NaN();  ///< largest until it ended
  double cost = std::numeric_limits<double>::quiet_NaN();   ///< seconds of stepping per simulated second
  double share = 0;                                         ///< of the duration that was run
  bool meets = false;
  std::string verdict{};
};

/// What is advised, or why nothing is.
struct Advice {
  std::vector<Trial> trials;        ///< in the order they were run
  std::optional<std::size_t> best;  ///< the cheapest that meets the error, whatever the budget
  bool within_budget = false;
  double uncertainty = 0;  ///< of the reference, as errors are measured
  int finest_level = 0;    ///< that the reference was made of
  double checked_error = std::numeric_limits<double>::quiet_NaN();  ///< of the best against a finer one
  double seconds = 0;                                               ///< that all of it took
  std::string explanation;  ///< a sentence where nothing is advised; empty otherwise
  bool stopped = false;     ///< by the user
};

/// Finds the cheapest candidate that meets an error. Throws InputError for asks that make no sense.
Advice advise(SceneFamily& family, const Ask& ask, Progress& progress);

/// Every candidate that advise() chooses among, up to a level, each run to its end: what the advice should
/// hold its own against. The reference is of another level than the advisor's.
Advice try_all(SceneFamily& family, const Ask& ask, int finest_level, int reference_level,
               Progress& progress);

/// A row per trial.
Table advice_table(const SceneFamily& family, const Advice& advice);

}  // namespace mss::advise
