#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/body_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::validate {

/// A number asked of a body, and how it ended.
struct Answer {
  Status status = Status::ok;
  double value = 0;  ///< not finite: there is nothing of the kind
};

/// A body in a situation where the right answer is known.
struct ValidationCase {
  std::string name;
  std::string description;
  std::string quantity;  ///< what `answer` gives
  std::string unit;
  double poisson = 0.3;
  Eigen::Vector3i proportions{4, 1, 1};  ///< edges, in units of the width
  Environment environment{};
  std::function<Answer(BodySystem<double>&)> answer{};
  double reference = 0;  ///< in that unit
  double doubt = 0;      ///< share by which the reference was extrapolated; 0: a closed form
  std::string source;
  bool large = false;  ///< deformations are: laws of finite elements differ
  bool charted = true;
  int most_cells = 16;  ///< across the width; more would take minutes
};

/// A way to fill a body with a material: springs, or a law of finite elements.
struct ValidationModel {
  std::string name;
  std::string model;  ///< for make_system()
  bool for_large_only = false;
  std::function<SpringConstants(const ElasticConstants&, double cell_size)> springs;
};

/// What `mss validate` does.
struct ValidationConfig {
  double young = 1e5;     ///< [Pa]
  double density = 1000;  ///< [kg/m^3]
  std::vector<ValidationCase> cases;
  std::vector<ValidationModel> models;
  std::vector<int> cells;       ///< across the width
  std::vector<int> refinement;  ///< cells per edge of the thesis's cube
  int repetitions = 3;          ///< of answers that take less than two seconds
  int threads = 1;
};
ValidationConfig validation_config(const ExperimentOptions& options);
std::vector<ValidationCase> validation_cases(double young, double density);
std::vector<ValidationModel> validation_models();

struct ValidationTables {
  Table rows;
  Table refinement;
  Status status = Status::ok;
};
ValidationTables measure_validation(const ValidationConfig& config, Progress& progress);

/// For every case and model: its error at the finest resolution and its order of convergence there.
/// Where deformations are large only the reference's own law has an order.
Table validation_summary(const Table& rows, const ValidationConfig& config);

/// Errors below are rounding: no order can be read from them, and they are not drawn.
inline constexpr double validation_rounding = 1e-9;

/// Error against a column of the rows, for one case and all models.
Chart validation_chart(const Table& rows, const ValidationConfig& config, const ValidationCase& c,
                       const std::string& against);

/// What refining does to the thesis's cube: Young's modulus against cells per edge.
Chart refinement_chart(const Table& refinement);

}  // namespace mss::studies::validate
