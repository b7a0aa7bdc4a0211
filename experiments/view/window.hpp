#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/base/state.hpp"
#include "core/scene/scene.hpp"
#include "integrators/integrator.hpp"

namespace mss::view {

/// How a scene is to be shown.
struct ViewOptions {
  int width = 1280;  ///< [pixels]
  int height = 800;
  std::optional<long>
      frames{};  ///< before a shot: sixtieths of a second to simulate, 0 if not given; of a
                 ///< recording: how many there are, those of the scene's duration if not given
  std::filesystem::path shot{};    ///< where to put a picture; empty: an interactive window
  bool every_frame = false;        ///< with a shot: draws all of them, as a window would, to measure times
  std::filesystem::path record{};  ///< where to put a moving picture, see make_recording()
  double rate = 25;                ///< of a recording's frames [1/s of simulated time]
  bool plain = false;              ///< in pictures: the body alone, without panel, graphs and colour bar
  std::vector<State<double>> motion{};  ///< in pictures: what is shown in place of a simulation, if any
  bool log = false;  ///< a line of JSON on stdout for everything that is done in the window
};

/// How a simulation was when it had been shown.
struct Shown {
  Status status = Status::ok;
  long recorded = 0;  ///< frames
};

/// Shows a scene until its window is closed, or makes a picture of it, which may move. It is written all the
/// same if the simulation fails or, of as many frames as there are then, if it is interrupted. Throws
/// InputError if the scene cannot be simulated, no window be opened or the picture not be written, and if
/// this build has no window.
Shown show(const Scene& scene, const ViewOptions& options);

}  // namespace mss::view
