#pragma once

#include <filesystem>

#include "core/scene/scene.hpp"
#include "integrators/integrator.hpp"

namespace mss::view {

/// How a scene is to be shown.
struct ViewOptions {
  int width = 1280;  ///< [pixels]
  int height = 800;
  long frames = 0;               ///< with a shot: how many sixtieths of a second to simulate before it
  std::filesystem::path shot{};  ///< where to put a picture; empty: an interactive window
  bool every_frame = false;      ///< with a shot: draws all of them, as a window would, to measure times
  bool plain = false;            ///< with a shot: the body alone, without panel, graphs and colour bar
  bool log = false;              ///< a line of JSON on stdout for everything that is done in the window
};

/// Shows a scene until its window is closed, or makes a picture of it. Returns how the simulation is then;
/// the picture is written all the same. Throws InputError if the scene cannot be simulated, no window be
/// opened or the picture not be written, and if this build has no window.
Status show(const Scene& scene, const ViewOptions& options);

}  // namespace mss::view
