#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/scene/scene.hpp"
#include "integrators/reduction/reduced_system.hpp"

namespace mss {

/// Names of `material.model` by how they reduce a body.
std::optional<Reduction> reduction_named(const std::string& model);
/// The scene itself, or of a body that is reduced its lattice's: what vibrations are asked of.
Scene unreduced(Scene scene);

/// The body of a scene whose model reduces it. Its shapes come from the file beside the scene that an earlier
/// call has left, where that is of the same body; otherwise they are computed and left there, if the folder
/// can be written to. Throws InputError as ReducedSystem does.
std::unique_ptr<ReducedSystem> make_reduced(const Scene& scene, const Body& body);

/// That file: SCENE.shapes; empty for a scene that is none of a file.
std::filesystem::path shapes_file(const Scene& scene);

}  // namespace mss
