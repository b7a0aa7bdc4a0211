#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/springs/body_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "integrators/analysis/error_estimate.hpp"

namespace mss::studies::validate {

/// The computed quantity of a case.
struct Solution {
  Status status = Status::ok;
  double value = 0;  ///< in the case's unit; not finite: the body has no such quantity
};

/// Where deformations are large, laws of elasticity differ, and only one is that of the reference.
enum class Deformations { small, large };

/// A static or modal problem whose solution is known.
struct ValidationCase {
  std::string name;
  std::string description;
  std::string quantity;  ///< what `solve` computes
  std::string unit;
  double poisson = 0.3;
  double viscosity = 0;                  ///< [Pa s]
  Eigen::Vector3i proportions{4, 1, 1};  ///< edge lengths over the width, which is 1 m
  Environment environment{};
  std::function<Solution(BodySystem<double>&)> solve{};
  /// The same quantity with the estimate of its error; for calibrated springs, of small deformations at rest.
  std::function<GoalEstimate(BodySystem<double>&)> estimate{};
  double reference = 0;    ///< in that unit
  double uncertainty = 0;  ///< of the reference, relative: the effect of its extrapolation; 0: a closed form
  std::string source;
  Deformations deformations = Deformations::small;
  bool charted = true;
  int most_cells = 16;  ///< across the width; more would take minutes
};

/// A way to fill a body with a material: springs, or finite elements.
struct ValidationModel {
  std::string name;
  std::string model;  ///< for make_system()
  std::function<SpringConstants(const ElasticConstants&, double cell_size)> springs;
  bool calibrated = false;              ///< springs of the material's E and nu in every direction
  bool for_large_only = false;          ///< to first order it equals another model
  bool linear_in_green_strain = false;  ///< the law of the references of large deformations
};

/// What `mss validate` computes.
struct ValidationConfig {
  double young = 1e5;     ///< [Pa]
  double density = 1000;  ///< [kg/m^3]
  std::vector<ValidationCase> cases;
  std::vector<ValidationModel> models;
  std::vector<int> cells;       ///< across the width
  std::vector<int> refinement;  ///< cells per edge of the thesis's cube
  std::vector<double> strains;  ///< of a bar of springs, beside laws of large strain
  int repetitions = 3;          ///< of solutions that take less than two seconds
  int threads = 1;
};
ValidationConfig validation_config(const ExperimentOptions& options);
std::vector<ValidationCase> validation_cases(double young, double density);
std::vector<ValidationModel> validation_models();

/// The body of a case, filled by a model, in m cells across the width.
BodyConfig case_body(const ValidationConfig& config, const ValidationCase& c, const ValidationModel& model,
                     int m);

/// A cube of 1 m in uniaxial tension along a direction: its compliance is 1 / (E x 1 m).
ValidationCase tension_case(double young, const std::string& name, const Vec3& direction);

struct ValidationTables {
  Table rows;
  Table refinement;  ///< Young's modulus of the thesis's cube at several resolutions
  Table strains;     ///< stress of bars of springs, stretched and compressed far
  Table estimates;   ///< of errors, where the case has one
  Status status = Status::ok;
};
ValidationTables measure_validation(const ValidationConfig& config, Progress& progress);

/// Adds, for each model of springs, a bar at each strain along it, its sides free: stress and lateral stretch
/// of the lattice and of its Cauchy-Born limit, and the stress of two laws with the same E and nu. False if
/// stopped.
bool measure_large_strain(const ValidationConfig& config, const Progress& progress, Table& strains);
Table empty_strains();
std::string large_strain_text(const Table& strains);

/// Adds, for each case with an estimate, calibrated springs and size, value and corrected value against the
/// reference. False if stopped.
bool measure_estimates(const ValidationConfig& config, const Progress& progress, Table& estimates);
Table empty_estimates();
/// Errors as computed and corrected of every case at one resolution that all have.
Chart estimates_chart(const Table& estimates, const Table& cases);

/// For each case and model: the error at the finest resolution and the order of convergence there. Where
/// deformations are large only models with the reference's law have an order.
Table validation_summary(const Table& rows, const ValidationConfig& config);

/// All tables under the names of their files; `validate_cases` describes the cases to readers and charts.
std::vector<NamedTable> validation_files(const ValidationConfig& config, ValidationTables tables);

/// Errors below are rounding: they are not drawn, and no order is computed from them.
inline constexpr double validation_rounding = 1e-9;

/// What the error is drawn against.
enum class Abscissa { seconds, cells };

/// Error of all models of one case; `description` is the case's row of `validate_cases`.
Chart validation_chart(const Table& rows, const Table& description, Abscissa abscissa);

/// Error of every charted case by every model at one resolution that all have.
Chart cases_chart(const Table& rows, const Table& cases);

/// Stress over that of a neo-Hookean solid against strain.
Chart large_strain_chart(const Table& strains);

/// Young's modulus of the thesis's cube against cells per edge.
Chart refinement_chart(const Table& refinement);

/// All cases at one resolution, the first case against resolution and time, large strains, the refinement.
Drawings draw_validation(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::validate
