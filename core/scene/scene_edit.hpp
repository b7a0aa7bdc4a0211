#pragma once

#include <optional>
#include <string>

#include "core/scene/scene.hpp"

namespace mss {

/// The settings of a scene that can be changed after it was read: by a window while it runs, by a search
/// among ways to compute it. Everything else of the scene stays.
struct SceneEdit {
  int level = 1;  ///< parts that an edge of the coarsest cells is split into, see level_of()
  std::string model = spring_model;           ///< what fills the cells
  std::optional<ElasticConstants> elastic{};  ///< empty: `springs` are given
  SpringConstants springs{};  ///< without `elastic`; of cells as the scene has them, like `damping`
  double face_share = 0.5;    ///< t of springs calibrated for `elastic`
  bool volume_force = true;
  Topology topology = Topology::full;
  Sharing sharing = Sharing::weighted;
  Damping damping{};
  std::string integrator{};
  std::optional<double> dt{};  ///< [s]; empty: "safe"
  Precision precision = Precision::dbl;
  std::string linear_solver{};
  double tolerance = 1e-6;
  int threads = 0;
  std::string device = "cpu";
};

/// The edit that changes nothing.
SceneEdit edit_of(const Scene& scene);

/// How many of a scene's cells lie along an edge of the coarsest cells that its body can be made of: those of
/// its voxel file, the largest cubes that fill its box, or, of a mesh, one along its longest extent.
int level_of(const Scene& scene);

/// The scene with these settings. In cells of another level the material stays the same: springs that are
/// given, and the ratio of damping to critical, change with the size of cells so that moduli and viscosity do
/// not; a viscosity that is given stays as it is. Throws InputError if a box of the scene then contains no
/// particle.
Scene edited(Scene scene, const SceneEdit& edit);

}  // namespace mss
