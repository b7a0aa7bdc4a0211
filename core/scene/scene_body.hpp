#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/body/body.hpp"
#include "core/scene/scene_mesh.hpp"

namespace mss {

/// Name of the model whose cells are springs with the volume force of eq. 3-7, and of the one with
/// Mollemans's (reference/mollemans.hpp); the others are laws of finite elements (reference/fem).
inline constexpr const char* spring_model = "springs";
inline constexpr const char* mollemans_model = "mollemans";
inline bool has_springs(const std::string& model) {
  return model == spring_model || model == mollemans_model;
}

/// What a scene says of one of its bodies.
struct SceneBody {
  std::string body_name{};   ///< empty: it has none
  BodyConfig body{};         ///< its cells as they are after `refine`, its springs as calibrated
  std::string voxel_file{};  ///< where its cells come from, relative to the scene's folder; empty: a box,
  std::optional<SceneMesh> mesh{};   ///< or a mesh's
  int refine = 1;                    ///< parts that an edge of a cell of the file is split into
  double face_share = 0.5;           ///< t of calibrated springs
  bool volume_force = true;          ///< false: left out of calibrated springs
  std::string model = spring_model;  ///< what fills the cells, by name
  /// The mesh by which it touches planes and other bodies; none: its particles, and the faces of its cells.
  std::shared_ptr<const TriangleMesh> contact_surface{};
  Vec3 start_velocity = Vec3::Zero();          ///< [m/s]
  Vec3 start_angular_velocity = Vec3::Zero();  ///< [rad/s] about its centre of mass
};

}  // namespace mss
