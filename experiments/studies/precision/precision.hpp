#pragma once

#include <string>
#include <vector>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/simulation/bench_scenes.hpp"

namespace mss::studies::precision {

/// An initial value problem: a body that starts at rest from a given deformation, or as one of the scenes
/// that studies share.
struct PrecisionScene {
  std::string name;
  std::string description;
  BodyConfig body;
  Environment environment{};
  Vec3 (*start)(const Vec3& rest) = nullptr;  ///< initial position [m]; nullptr: the rest position
  double duration = 1;                        ///< [s]
  const BenchCase* bench = nullptr;           ///< if it is one of them,
  int cells = 0;                              ///< in so many, as it counts them
};
/// A scene that studies share, in so many cells.
PrecisionScene bench_precision(const BenchCase& which, int cells);
/// The names that --scenes takes.
std::vector<std::string> precision_scene_names();

/// What `mss precision` computes.
struct PrecisionConfig {
  std::vector<PrecisionScene> scenes;
  std::vector<std::string> integrators;
  std::string model = spring_model;
  double seconds_per_run = 0.15;  ///< a method's next run is left out if it would take longer,
  double seconds_to_agree = 0.3;  ///< or, in small bodies that do not agree with the reference yet, this long
  int repetitions = 3;            ///< of every run,
  double seconds_per_row = 0.1;   ///< until it has taken that long
  double reference_tolerance = 1e-12;  ///< of both reference methods where no planes are
  int finest_halving = 22;             ///< most runs with steps of duration / 8, / 16, / 32 ...
  int threads = 1;
};
PrecisionConfig precision_config(const ExperimentOptions& options);

/// Bodies of at most so many particles are small: their linear systems are factored, and methods refined
/// until they agree with the reference.
inline constexpr std::size_t precision_small = 200;

/// The scenes with small bodies among those of a configuration.
std::vector<PrecisionScene> small_scenes(std::vector<PrecisionScene> scenes);

/// A run whose error is above this has a status of its own.
inline constexpr double precision_worst = 10;
inline constexpr const char* precision_diverged = "error above 10";

/// A method whose error is below this agrees with the reference.
inline constexpr double precision_agreed = 1e-6;

/// One row a run; the references with their uncertainties; and how close each method comes to them.
struct PrecisionTables {
  Table rows;
  Table references;
  Table agreement;
  Status status = Status::ok;
};
PrecisionTables measure_precision(const PrecisionConfig& config, Progress& progress);

/// Errors are significant down to so many uncertainties of the reference.
inline constexpr double precision_certainty = 10;

/// For each scene and several accuracies: the cheapest method, and what the next one, of another family,
/// costs beside it; a tie if their quartiles overlap or their medians differ by less than a tenth. Nothing
/// where the reference is not that certain.
Table precision_summary(const Table& rows, const Table& references);
/// The summary in lines to be read.
std::string precision_text(const Table& summary);

/// All tables under the names of their files.
std::vector<NamedTable> precision_files(PrecisionTables tables);

/// Error against wall time for one scene, of the families that come within ten times the least time at some
/// error; their failed runs on lines above, one a reason.
Chart precision_chart(const Table& rows, const Table& references, const std::string& scene);

/// For each scene: the time of the cheapest method for any step over that of the cheapest explicit one,
/// against the error asked for, as far as the reference is certain.
Chart precision_overview(const Table& rows, const Table& references);

/// The overview and a chart for each of the larger bodies, or for each body if there are only small ones.
Drawings draw_precision(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::precision
