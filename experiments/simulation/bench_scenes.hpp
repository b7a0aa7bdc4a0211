#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "experiments/simulation/motion_bounds.hpp"

// Scenes that people have: what a ranking of methods is claimed for. Studies share them.

namespace mss {

/// What is about a scene but its material: cells without springs, surroundings, and how it begins.
struct BenchSetup {
  BodyConfig body{};
  Environment environment{};
  Vec3 velocity = Vec3::Zero();          ///< at the start [m/s]
  Vec3 angular_velocity = Vec3::Zero();  ///< about the centre of mass [rad/s]
};

/// What the body of a scene is meant to do.
enum class BenchTask {
  sag,   ///< held and under gravity, it bends
  land,  ///< it falls on the ground
  spin,  ///< it turns freely
  rest,  ///< it stays on the ground under a burden
  stick  ///< the same on a slope below the angle of friction
};

struct BenchScene {
  std::string name;         ///< in tables
  std::string label;        ///< on charts
  std::string description;  ///< sizes in m; what the cells are counted across
  BenchTask task{};
  int cells = 0, quick_cells = 0;  ///< across, of studies and of their quick runs
  int frames = 0;                  ///< of 1/60 s
  const char* truth = "rk4";       ///< explicit method that finds its true motion,
  double truth_share = 0.25;       ///< at this share of the safe step: on planes all are of first order
  BenchSetup (*set_up)(int cells) = nullptr;

  /// Whether it has an equilibrium that holds alone decide.
  bool is_held() const { return task == BenchTask::sag; }
};
const std::vector<BenchScene>& bench_scenes();
/// Throws std::logic_error for another name.
const BenchScene& find_bench_scene(const std::string& name);

/// Soft, medium and stiff [Pa], and the ratios of damping to critical, of every spring.
inline constexpr std::array<double, 3> bench_moduli{1e5, 1e6, 1e7};
inline constexpr std::array<double, 2> bench_ratios{0.01, 0.5};

/// 1000 kg/m^3, nu = 0.3, t = 0.5.
struct BenchMaterial {
  double young = 1e6;  ///< [Pa]
  Damping damping{};
};
Damping damping_of_ratio(double ratio);
/// The viscosity that damps edge springs of cells of that size [m] as the ratio does: the same material in
/// cells of any size.
Damping viscosity_like_ratio(double ratio, double young, double cell_size);

/// A scene in a material, under the name that options have for it.
struct BenchCase {
  std::string scene;
  double young = 1e6;   ///< [Pa]
  double ratio = 0.01;  ///< of damping to critical, of every spring

  /// As in "ball_medium", "ball_stiff_damped".
  std::string name() const;
  /// The scene in so many cells, and the material.
  std::string description(int cells) const;
};
/// Every scene, soft, medium and stiff, hardly and strongly damped.
const std::vector<BenchCase>& bench_cases();
std::vector<std::string> bench_case_names();
/// Throws std::logic_error for another name.
const BenchCase& find_bench_case(const std::string& name);

/// A scene's body with its material, in cells.
BenchSetup bench_setup(const BenchScene& scene, int cells, const BenchMaterial& material);

/// The same as a system at its start.
struct BenchBody : MovingBody {
  BenchBody(const BenchScene& of, int cells, const BenchMaterial& material, int threads = 1);
  /// The same at its start, for another number of threads (0: as many as pay).
  BenchBody with_threads(int threads) const { return {scene, setup, threads}; }
  BenchScene scene;
  BenchSetup setup;

 private:
  BenchBody(const BenchScene& of, BenchSetup with, int threads);
};

/// The true motion of a scene, and how well it is known.
struct TrueMotion {
  FramePositions positions{};
  MotionExtremes extremes{};
  /// Its distance from the motion with steps twice as long, over the displacement: root mean squares over
  /// frames and particles.
  double uncertainty = 0;
  double scale = 0;       ///< sum over frames and particles of squared displacements [m^2]
  std::string complaint;  ///< empty: it is there, and did what its scene is meant to do

  /// Root mean square distance of a motion over the displacement.
  double error_of(const MovingBody& body, const FramePositions& motion) const {
    return std::sqrt(squared_distance(body, motion, positions) / scale);
  }
};
/// Not sought where it would take longer than `most_seconds` with one thread. The same for any number of
/// threads (0: as many as pay).
TrueMotion find_true_motion(const BenchBody& body,
                            double most_seconds = std::numeric_limits<double>::infinity(), int threads = 1);

/// Empty if a motion did what its scene is meant to do, or in words what it did instead: a body that fell
/// beside the ground, slid from a slope or did not turn shows nothing about methods.
std::string bench_complaint(const BenchBody& body, const FramePositions& motion);

}  // namespace mss
