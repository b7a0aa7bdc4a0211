// `mss view`: shows a scene live in a window, or makes a picture of it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "core/base/error.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/view/window.hpp"

namespace mss::cli {

namespace {

struct ViewChoice {
  std::string scene;
  std::vector<std::string> overrides;
  std::string size = "1280x800";
  std::string shot;
  view::ViewOptions options;
};

/// Numbers of pixels on both sides of an x.
void read_size(const std::string& size, view::ViewOptions& options) {
  constexpr int least_width = 640, least_height = 400, most = 8192;
  int read = 0;
  const int found = std::sscanf(size.c_str(), "%5dx%5d%n", &options.width, &options.height, &read);
  if (found != 2 || std::size_t(read) != size.size() || options.width < least_width ||
      options.height < least_height || std::max(options.width, options.height) > most)
    throw InputError(
        fmt::format("--size is {}; give it as 1280x800, at least {}x{} and at most {} pixels long", size,
                    least_width, least_height, most));
}

void view_scene(ViewChoice& choice, int& exit_status) {
  read_size(choice.size, choice.options);
  if (choice.options.frames < 0)
    throw InputError(
        fmt::format("--frames is {}; give a number that is not negative", choice.options.frames));
  choice.options.shot = choice.shot;
  const MatchedScene ready = load_matched_scene(scene_file(choice.scene), choice.overrides);
  const Scene& scene = ready.scene;
  Scene on_processor = scene;  // what draws the window takes the steps, if it can
  on_processor.solve.device = SolveConfig{}.device;
  check_solve(on_processor);
  if (ready.report) {
    for (const std::string& line : description(*ready.report)) fmt::print("{}: {}\n", scene.name, line);
    fmt::print("{}: in cells of another size the window keeps these moduli, which are not matched there\n",
               scene.name);
  }
  for (const std::string& warning : scene.warnings) fmt::print(stderr, "mss: warning: {}\n", warning);
  const Status status = view::show(scene, choice.options);
  if (status == Status::interrupted) exit_status = exit_interrupted;
  const bool failed = status != Status::ok && status != Status::interrupted;
  if (choice.shot.empty()) return;  // the window has shown it
  if (status != Status::interrupted) fmt::print("wrote {}\n", choice.shot);
  if (!failed) return;
  fmt::print(stderr, "mss: the simulation failed: {}; {} shows the body as it last was\n", to_string(status),
             choice.shot);
  exit_status = exit_simulation_failed;
}

void add_view(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand("view", "show a scene live in a window, or make a picture of it");
  const auto choice = std::make_shared<ViewChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  add_settings(*command, choice->overrides);
  command->add_option("--size", choice->size, "Width and height of the window [pixels] (default 1280x800)");
  CLI::Option* shot =
      command->add_option("--shot", choice->shot, "Open no window; write a picture to this PNG file");
  command
      ->add_option("--frames", choice->options.frames,
                   "Number of frames of 1/60 s to simulate before the picture (default 0: the start)")
      ->needs(shot);
  command
      ->add_flag("--every-frame", choice->options.every_frame,
                 "Draw all of these frames, as a window would; --log has the time that takes")
      ->needs(shot);
  command
      ->add_flag("--plain", choice->options.plain,
                 "Picture of the body alone, without panel, graphs and colour bar")
      ->needs(shot);
  command->add_flag("--log", choice->options.log, "Print a line of JSON for every action in the window");
  command->callback([choice, &exit_status] { view_scene(*choice, exit_status); });
}

}  // namespace

Command view_command() { return add_view; }

}  // namespace mss::cli
