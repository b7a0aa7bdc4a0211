#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/spring_system.hpp"
#include "experiments/experiment.hpp"

namespace mss {

/// A loaded body whose deflection under a unit load is known.
struct ValidationCase {
  std::string name;
  std::string description;
  Eigen::Vector3i proportions;  ///< edges, in units of the width
  double density;               ///< [kg/m^3]
  Environment environment;
  Box measured;      ///< particles whose mean displacement is the deflection
  int axis;          ///< along which
  double reference;  ///< [m/N]
  std::string source;
};

/// A way to make springs of a material.
struct LatticeModel {
  std::string name;
  std::function<SpringConstants(const ElasticConstants&, double cell_size)> springs;
};

/// What `mss validate` does.
struct ValidationConfig {
  ElasticConstants material{.young = 1e5, .poisson = 0.3};
  std::vector<ValidationCase> cases;
  std::vector<LatticeModel> models;
  std::vector<int> cells;  ///< across the width
  int repetitions = 3;
};
ValidationConfig validation_config(const ExperimentOptions& options);

struct ValidationTables {
  Table rows;
  Status status = Status::ok;
};
ValidationTables measure_validation(const ValidationConfig& config, Progress& progress);

/// For every case and model: its error at the finest resolution and its order of convergence there.
Table validation_summary(const Table& rows);

/// Error against a column of the rows, for one case and all models.
Chart validation_chart(const Table& rows, const ValidationCase& c, const std::string& against);

}  // namespace mss
