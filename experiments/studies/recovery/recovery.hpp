#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/body_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/journal.hpp"

namespace mss::studies::recovery {

/// What fills the cube that is to recover.
struct RecoveryModel {
  std::string name;
  std::string model;      ///< for make_system()
  BodyConfig body;        ///< 3 x 3 x 3 cells
  int seeds = 1;          ///< of every state
  bool lands = false;     ///< and not only recovers from the zoo
  bool guarded = false;   ///< against folding
  double face_share = 0;  ///< t of calibrated springs
  double poisson = 0;     ///< 0: not a material's
};

/// A way to trap a body, by name; `amount` [cells] where there are several.
struct TrappedState {
  std::string name;
  double amount = 0;
  /// Where a particle is put whose place in the body at rest is `rest`, in cells from its lower corner;
  /// `random` in [-1, 1]^3.
  Vec3 (*put)(const Vec3& rest, const Vec3& random, double amount);
};

/// What `mss recovery` does to cubes: every trapped state with as many seeds, and landings.
struct RecoveryConfig {
  std::vector<RecoveryModel> models;
  std::vector<TrappedState> states;
  std::uint64_t seed = 1;                ///< the first
  std::vector<double> landing_speeds{};  ///< tried in turn until a cube stays folded [m/s]
};
RecoveryConfig recovery_config(const ExperimentOptions& options);

/// The zoo: mirrored, a folded layer, corner, edge, face and patch pushed through, flat, crushed, random.
const std::vector<TrappedState>& trapped_states();
/// As charts and tables name it.
std::string to_string(const TrappedState& state);

/// Edges of the cubes in cells.
inline constexpr int recovery_cells = 3;

/// How a trial ended.
enum class Recovery { recovered, mirrored, trapped, moving, non_finite };
std::string_view to_string(Recovery outcome);

struct RecoveryTrial {
  Recovery outcome = Recovery::recovered;
  double seconds = 0;       ///< simulated, until then [s]
  double max_stretch = 0;   ///< at the end
  double min_jacobian = 1;  ///< at the end
};

/// Puts the body of a system into a state and lets go.
RecoveryTrial try_recovery(BodySystem<double>& system, const TrappedState& trap, std::uint64_t seed);

/// What a cube lands on: a corner, an edge or a face.
struct Landing {
  std::string name;
  Vec3 up;  ///< normal of the ground, of length 1
};
const std::vector<Landing>& landings();

/// Lands a cube at a speed [m/s], lets it bounce and come to rest in the air: recovered if nothing is inside
/// out then, however fast it turns.
RecoveryTrial try_landing(const RecoveryModel& model, const Landing& landing, double speed);

/// What a step costs, models taking turns, and how far the guard moves anything where nothing is near
/// folding.
Table measure_costs(const RecoveryConfig& config, const Progress& progress);

struct RecoveryTables {
  Table rows;      ///< per model and state
  Table landings;  ///< per model and landing: the first speed from which it does not recover
  Status status = Status::ok;
};
RecoveryTables measure_recovery(const RecoveryConfig& config, int processes, Journal& journal,
                                Progress& progress);

}  // namespace mss::studies::recovery
