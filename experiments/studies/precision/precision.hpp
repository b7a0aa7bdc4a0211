#pragma once

#include <string>
#include <vector>

#include "core/spring_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::precision {

/// A body set moving from a known state, whose later states are compared.
struct PrecisionScene {
  std::string name;
  std::string description;
  BodyConfig body;
  Environment environment{};
  Vec3 (*start)(const Vec3& rest) =
      nullptr;          ///< where a particle starts, at rest; nullptr: at its rest place
  double duration = 1;  ///< [s]
};

/// What `mss precision` does.
struct PrecisionConfig {
  std::vector<PrecisionScene> scenes;
  std::vector<std::string> integrators;
  std::string model = spring_model;
  double seconds_per_run = 1;          ///< a method's next run is left out if it would take longer,
  double seconds_to_agree = 60;        ///< or longer than this while it does not agree with the reference
  double reference_tolerance = 1e-12;  ///< of both reference methods
  int finest_halving = 22;             ///< steps go from duration / 8 down by halves
  int threads = 1;
};
PrecisionConfig precision_config(const ExperimentOptions& options);

/// Errors above say no more, and are a status of their own.
inline constexpr double precision_worst = 10;
inline constexpr const char* precision_diverged = "error above 10";

/// Errors below mean that a method agrees with the reference.
inline constexpr double precision_agreed = 1e-6;

/// Rows of all runs, the references' uncertainties, and how close every method comes to them.
struct PrecisionTables {
  Table rows;
  Table references;
  Table agreement;
  Status status = Status::ok;
};
PrecisionTables measure_precision(const PrecisionConfig& config, Progress& progress);

/// For every scene and accuracy asked: the cheapest method, and by how much.
Table precision_summary(const Table& rows);

/// Error against cost for one scene; cost is a column of the rows.
Chart precision_chart(const Table& rows, const Table& references, const PrecisionScene& scene,
                      const std::string& cost);

/// Over all scenes: how many times dearer than the cheapest each method is, against the accuracy asked.
Chart precision_overview(const Table& rows);

}  // namespace mss::studies::precision
