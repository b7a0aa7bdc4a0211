#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/springs/body_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/journal.hpp"
#include "experiments/simulation/landing.hpp"

namespace mss::studies::recovery {

/// Where the stiffness of a cube comes from.
enum class Stiffness { thesis_springs, calibrated_springs, corotational_elements };
std::string_view to_string(Stiffness stiffness);

/// A cube as it is modelled, with or without the fold guard.
struct RecoveryModel {
  std::string name;
  std::string unguarded;  ///< name of the same model without the fold guard; its own if it has none
  Stiffness stiffness = Stiffness::thesis_springs;
  BodyConfig body;        ///< 3 x 3 x 3 cells
  int seeds = 1;          ///< of every trapped state
  bool lands = false;     ///< landings are tried too
  double face_share = 0;  ///< t of calibrated springs
  double poisson = 0;     ///< not of the thesis's springs, which have no material

  bool guarded() const { return body.fold_guard > 0; }
  /// Name of the model for make_system().
  std::string law() const {
    return stiffness == Stiffness::corotational_elements ? "corotational" : spring_model;
  }
  std::unique_ptr<BodySystem<double>> system(const Body& of, const Environment& environment) const;
};

/// A state that may trap a body, by name; `amount` [cells] where there are several of that name.
struct TrappedState {
  std::string name;
  double amount = 0;
  /// Place of a particle whose rest position is `rest`, both in cells from the body's lower corner; `random`
  /// in [-1, 1]^3.
  Vec3 (*put)(const Vec3& rest, const Vec3& random, double amount);
};

/// The trials of `mss recovery`: every trapped state with so many seeds, and landings.
struct RecoveryConfig {
  std::vector<RecoveryModel> models;
  std::vector<TrappedState> states;
  std::uint64_t seed = 1;                ///< the first
  std::vector<double> landing_speeds{};  ///< ascending; tried until a cube does not recover [m/s]
};
RecoveryConfig recovery_config(const ExperimentOptions& options);

/// Mirrored, a folded layer, a corner, edge, face and patch pushed in, flat, shrunk, random.
const std::vector<TrappedState>& trapped_states();
/// Rotated by two radians as a whole, which stores no energy: no trap, every model must recover from it.
const TrappedState& turned_state();
/// As charts and tables name it.
std::string to_string(const TrappedState& state);

/// Edges of the cubes in cells.
inline constexpr int recovery_cells = 3;

/// Puts the body of a system into a state and releases it.
RecoveryTrial try_recovery(BodySystem<double>& system, const TrappedState& trap, std::uint64_t seed);

/// Lands a cube at a speed [m/s] on a plane of the law `impulse`, restitution 0.5.
RecoveryTrial try_landing(const RecoveryModel& model, const Landing& landing, double speed);

/// Wall time of a step, models interleaved, and the largest displacement that the fold guard causes where no
/// cell is near folding.
Table measure_costs(const RecoveryConfig& config, const Progress& progress);

struct RecoveryTables {
  Table rows;      ///< per model and state
  Table landings;  ///< per model and landing: the first speed from which it does not recover
  Table models;    ///< what charts name the models by, and which differ by the fold guard alone
  Table speeds;    ///< landing speeds, in the order tried
  Status status = Status::ok;
};
RecoveryTables measure_recovery(const RecoveryConfig& config, int processes, Journal& journal,
                                Progress& progress);
/// The tables as they are written, by the names of their files; `costs` from measure_costs().
std::vector<NamedTable> recovery_files(RecoveryTables tables, Table costs);

/// Recovery per model, landing speeds, and a map of recovery per state and model.
Drawings draw_recovery(const std::vector<NamedTable>& tables);

/// Share of the trials in these rows that recovered; NaN if there are none.
double recovered_share(const Table& rows);

}  // namespace mss::studies::recovery
