// What a scene file may say, by table.
#include "core/scene/scene_keys.hpp"

#include <string>

#include "core/measures/measures.hpp"
#include "core/scene/scene.hpp"

namespace mss {

namespace {

KnownKeys make_keys() {
  KnownKeys keys{
      {"",
       {"body", "material", "damping", "part", "weight", "refine", "environment", "hold", "load", "strike",
        "plane", "start", "solve", "expect"}},
      {"expect", {energy_drift, mean_displacement}},
      {"expect.energy_drift", {"value", "within"}},
      {"expect.displacement", {"box", "surface_box", "value", "within"}},
      {"body",
       {"cells", "voxels", "refine", "refinement", "refinement_levels", "refinement_goal", "cell_size",
        "origin", "topology", "sharing"}},
      {"body.mesh_rotation", mesh_rotation_keys},
      {"material",
       {"model", "density", "young", "poisson", "face_share", "springs", "volume", "volume_force",
        "fold_guard"}},
      {"material.springs", {"edge", "face", "body"}},
      {"damping", {"ratio", "viscosity", "thesis"}},
      {"part", {"name", "mesh", "density", "young", "poisson", "damping"}},
      {"part.damping", {"ratio", "viscosity", "thesis"}},
      {"weight", {"box", "mass"}},
      {"refine", {"box", "levels"}},
      {"environment", {"gravity"}},
      {"hold", {"box", "surface_box", "axes", "velocity", "displacement", "turn"}},
      {"hold.turn", {"axis", "centre", "rate", "until"}},
      {"load", {"box", "surface_box", "force"}},
      {"strike", {"box", "at", "impulse"}},
      {"plane", {"point", "normal", "contact", "restitution", "friction"}},
      {"start", {"velocity", "spin"}},
      {"solve",
       {"integrator", "dt", "duration", "threads", "precision", "linear_solver", "nonlinear_solver",
        "iterations", "tangent", "spectral_radius", "acceleration", "region_width", "alpha", "tolerance",
        "every", "local_steps", "sleep", "sleep_after"}},
  };
  keys["body"].insert(keys["body"].end(), mesh_keys.begin(), mesh_keys.end());
  for (const MeasureColumn& column : measure_columns) {
    keys["expect"].emplace_back(column.name);
    keys["expect." + std::string(column.name)] = {"value", "within"};
  }
  for (const char* force : {"hold_#_x", "hold_#_y", "hold_#_z", "plane_#_x", "plane_#_y", "plane_#_z"}) {
    keys["expect"].emplace_back(force);
    keys["expect." + std::string(force)] = {"value", "within"};
  }
  return keys;
}

}  // namespace

const KnownKeys& scene_keys() {
  static const KnownKeys keys = make_keys();
  return keys;
}

const KnownKeys& old_scene_keys() {
  static const KnownKeys keys{{"damping", {"paper"}}};
  return keys;
}

}  // namespace mss
