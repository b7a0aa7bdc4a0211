#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/limits.hpp"
#include "core/environment/environment.hpp"
#include "core/environment/sleep_tracker.hpp"
#include "core/refinement/refined_body.hpp"
#include "core/scene/scene_body.hpp"
#include "core/system/system.hpp"

namespace mss {

enum class Precision { single, dbl };

/// How a scene is to be solved.
struct SolveConfig {
  std::string integrator = "verlet";
  std::optional<double> dt;  ///< [s]; empty: "safe", 0.9 of the guaranteed limit
  double duration = 1;       ///< [s]
  int threads = 0;           ///< 0: as many as save time
  Precision precision = Precision::dbl;
  std::string device = "cpu";               ///< that takes the steps
  std::string linear_solver = "automatic";  ///< of implicit methods
  std::string nonlinear_solver = "newton";  ///< of implicit methods and `static`
  int iterations = 0;                       ///< of it, in every stage; 0: as many as its tolerance needs
  Tangent tangent = Tangent::elastic;       ///< of implicit methods; projected where that is indefinite
  double spectral_radius = 0.9;             ///< of generalized_alpha, at infinite steps
  double chebyshev_radius = 0;              ///< of vbd: spectral radius of a pass; 0: none
  int region_width = 2;                     ///< of shape_matching, in cells; 0: one region
  double alpha = 1;                         ///< of shape_matching: share of the way to the goal in a step
  double tolerance = 1e-6;                  ///< of adaptive methods: local error over a cell's size
  double every = 0.01;                      ///< seconds between rows of series.csv
  bool local_steps = false;                 ///< of refined bodies: larger cells take longer steps
  SleepRule sleep{};                        ///< of springs driven by explicit methods of fixed step
};

/// A result that a scene file states in advance; `mss check SCENE` compares it with what was simulated.
struct Expectation {
  std::string quantity;         ///< a column of series.csv, or one of those below
  std::vector<double> value{};  ///< one number; of a displacement three
  double within = 0;            ///< how far each number may be off
  Box box{};                    ///< of a displacement: the particles it is the mean of,
  bool on_surface = false;      ///< or vertices of the mesh
};
/// Total energy at the end over that at the start, minus 1.
inline constexpr const char* energy_drift = "energy_drift";
/// Mean displacement from rest of the particles, or of the mesh's vertices, in a box [m].
inline constexpr const char* mean_displacement = "displacement";

/// Cells that are chosen to be smaller, by an estimate of the error of a quantity at rest.
struct AutoRefinement {
  enum class Goal {
    energy,       ///< that is stored
    displacement  ///< of [expect]
  };
  Goal goal = Goal::energy;
  int levels = 1;  ///< how often cells are halved at most
};

/// Cells too large to resolve a body get other moduli, so that its slowest vibrations are those of the body
/// in smaller cells.
struct FrequencyMatch {
  enum class Of {
    bending,  ///< E, by the slowest vibration that bends
    torsion,  ///< E, by the slowest that twists
    both,     ///< E and nu, by these two
    modes     ///< E and nu, by the slowest few whatever they are
  };
  Of of = Of::bending;
  int parts = 0;  ///< that an edge of a cell is split into in the body to match; 0: the limit of many
};

/// As scene files spell them.
const std::string& to_string(ContactLaw law);
const std::string& to_string(Topology topology);
const std::string& to_string(Sharing sharing);
const std::string& to_string(Precision precision);
const std::string& to_string(Tangent tangent);
const std::string& to_string(AutoRefinement::Goal goal);
const std::string& to_string(FrequencyMatch::Of of);

/// A scene file, read and checked. Its first body is a base of it: most scenes have no other.
struct Scene : SceneBody {
  std::filesystem::path file;
  std::string name;                                 ///< file name without extension
  std::vector<RefinedBox> refined_boxes{};          ///< where cells of its only body are split further,
  std::optional<AutoRefinement> auto_refinement{};  ///< or what chooses where
  std::optional<FrequencyMatch> match{};            ///< what that body's moduli are to be changed for
  int modes = 0;                                    ///< of reduced models; 0: as many as the model takes
  std::vector<SceneBody> others{};                  ///< bodies after the first
  bool states_contact = false;                      ///< has a [contact], so that what it leaves out is meant
  Environment environment;
  SolveConfig solve;
  std::vector<Expectation> expectations;
  std::vector<std::string> warnings;  ///< sentences for the user
};

/// All of a scene's bodies, the first one first.
std::vector<const SceneBody*> bodies_of(const Scene& scene);

/// What a scene's bodies span at rest [m].
Box box_at_rest(const Scene& scene);

/// Whether a scene needs core/bodies: it has several bodies, or one that may touch itself.
inline bool has_bodies_system(const Scene& scene) {
  return !scene.others.empty() || scene.environment.contact.acts();
}

/// Reads a scene (TOML, SI units). `overrides` are "table.key=value" with TOML values, applied before
/// checking, as in `--set solve.dt=1e-4`; a file they name is looked for in the current folder, then in the
/// scene's. Throws InputError naming file, line and key.
Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// The same of a scene file's text, named "scene"; its relative paths begin at the working directory.
Scene parse_scene(const std::string& toml, const std::vector<std::string>& overrides = {});

/// Whether its body has cells of several sizes.
inline bool is_refined(const Scene& scene) {
  return !scene.refined_boxes.empty() || scene.auto_refinement.has_value();
}

/// The body of a scene with cells of several sizes; nullptr where it has one. Throws InputError where cells
/// are chosen, which takes a solution: choose_refinement() in integrators/analysis/chosen_refinement.hpp
/// finds them.
std::unique_ptr<const RefinedBody> refined_body(const Scene& scene);

/// Throws InputError "FILE: hold.0.box contains no particle; ..." if a hold, load, strike or weight acts on
/// none.
void check_boxes(const Scene& scene);

/// The same of [expect], whose displacement is a mean of particles. No error where the scene is only run.
void check_expected_boxes(const Scene& scene);

/// Warnings about materials, meshes and what has no effect, as sentences for the user.
std::vector<std::string> scene_warnings(const Scene& scene);

}  // namespace mss
