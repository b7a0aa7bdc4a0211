#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/view/camera.hpp"
#include "experiments/view/picture.hpp"
#include "experiments/view/session.hpp"

namespace mss::view {

/// What buttons and keys request.
enum class PanelCommand { play_or_pause, step, restart, see_all, fit_colours, close };

/// What a window shows in addition to its session.
struct Display {
  bool playing = false;
  DisplayedQuantity quantity = DisplayedQuantity::stretch;
  ValueRange range{};  ///< of the colour bar
  bool surface = true, edges = true, springs = false, particles = false, ground = true;
  bool has_mesh = false;       ///< the body was given as one,
  bool shows_mesh = false;     ///< and that is drawn, not the faces of cells
  double ground_spacing = 1;   ///< [m]
  std::string device;          ///< that draws, and can take steps; empty: it cannot
  std::string message;         ///< why the last request was refused; empty if it was not
  double frame_seconds = 0;    ///< from one frame to the next
  double step_seconds = 0;     ///< of that, simulating
  double steps_per_frame = 0;  ///< how many steps that were
  double slower = 1;           ///< wall seconds per simulated second
};

/// Where things are on the screen: a column on the left, two graphs below, a colour bar on the right, and the
/// body in what is left.
struct Layout {
  Viewport column, graphs, bar, body;
};
Layout layout(double width, double height);

/// Everything that Dear ImGui draws; needs its context and an open frame.
class Panel {
 public:
  struct Requests {
    std::vector<PanelCommand> commands{};
    std::optional<SceneEdit> settings{};
  };

  explicit Panel(const Scene& scene) : original_(edit_of(scene)) {}

  /// Draws the panel and returns what was clicked; switches of `display` that need nothing else are set at
  /// once.
  Requests draw(const Session& session, Display& display, const Layout& places);

  /// Places of the buttons and sliders by name, for tests that press them.
  const std::map<std::string, Viewport>& widgets() const { return widgets_; }

 private:
  void draw_buttons(const Session& session, const Display& display, Requests& requests);
  bool draw_material(const Session& session, SceneEdit& settings);  ///< true if something was changed
  bool draw_damping(Damping& damping);
  bool draw_springs(const Session& session, SceneEdit& settings);
  bool draw_method(const Session& session, const Display& display, SceneEdit& settings);
  bool draw_device(const Display& display, SceneEdit& settings);
  void draw_display(Display& display, Requests& requests);

  bool slider(const char* name, double& value, double least, double most, bool by_powers);
  bool button(const char* name, float width);
  bool choice(const char* name, const std::vector<std::string>& names, std::size_t& chosen);
  bool toggle(const char* name, bool& value);
  bool remember(const char* name, bool used);  ///< where the last widget is

  SceneEdit original_;
  std::map<std::string, Viewport> widgets_;
};

}  // namespace mss::view
