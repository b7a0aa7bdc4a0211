// `mss view`: shows a scene live in a window, or makes a picture of it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <utility>

#include "core/base/error.hpp"
#include "experiments/cli/commands.hpp"
#include "experiments/cli/settings.hpp"
#include "experiments/peer/exchange.hpp"
#include "experiments/peer/result.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/view/window.hpp"

namespace mss::cli {

namespace {

struct ViewChoice {
  std::string scene;
  std::vector<std::string> overrides;
  std::string size;
  std::string shot;
  std::string record;
  std::string result;
  view::ViewOptions options;
};

/// Numbers of pixels on both sides of an x. What is smaller than the window can be shows the body alone.
void read_size(const std::string& size, view::ViewOptions& options) {
  constexpr int window_width = 640, window_height = 400, least = 16, most = 8192;
  const bool may_be_small = options.plain || !options.record.empty();
  const int least_width = may_be_small ? least : window_width,
            least_height = may_be_small ? least : window_height;
  int read = 0;
  const int found = std::sscanf(size.c_str(), "%5dx%5d%n", &options.width, &options.height, &read);
  if (found != 2 || std::size_t(read) != size.size() || options.width < least_width ||
      options.height < least_height || std::max(options.width, options.height) > most)
    throw InputError(
        fmt::format("--size is {}; give it as 1280x800, at least {}x{} and at most {} pixels long", size,
                    least_width, least_height, most));
  if (options.width < window_width || options.height < window_height) options.plain = true;
}

/// What goes with pictures only, and numbers. Throws InputError.
void check_pictures(const ViewChoice& choice) {
  constexpr double most_frames = 100000, highest_rate = 1000;
  const view::ViewOptions& options = choice.options;
  const bool is_recorded = !choice.record.empty();
  if (choice.shot.empty() && !is_recorded)
    for (const auto& [name, given] : {std::pair("--frames", options.frames.has_value()),
                                      {"--plain", options.plain},
                                      {"--result", !choice.result.empty()}})
      if (given) throw InputError(fmt::format("{} requires --shot or --record", name));
  if (options.frames && (*options.frames < (is_recorded ? 1 : 0) || double(*options.frames) > most_frames))
    throw InputError(fmt::format("--frames is {}; give a number from {} to {}", *options.frames,
                                 is_recorded ? 1 : 0, most_frames));
  if (!(options.rate > 0 && options.rate <= highest_rate))
    throw InputError(
        fmt::format("--rate is {}; give a number above 0 and at most {}", options.rate, highest_rate));
}

/// The exit status of what ended so; says what there is to look at.
int tell(const ViewChoice& choice, const view::Shown& shown) {
  const bool is_recorded = !choice.record.empty();
  const std::string picture = is_recorded ? choice.record : choice.shot;
  const std::string frames =
      is_recorded ? fmt::format(", {} frame{}", shown.recorded, shown.recorded == 1 ? "" : "s") : "";
  if (shown.status == Status::interrupted) {
    if (shown.recorded > 0) fmt::print("wrote {}{}\n", picture, frames);
    return exit_interrupted;
  }
  if (picture.empty()) return 0;  // the window has shown it
  fmt::print("wrote {}{}\n", picture, frames);
  if (shown.status == Status::ok) return 0;
  fmt::print(stderr, "mss: the simulation failed: {}; {} shows the body {}\n", to_string(shown.status),
             picture, is_recorded ? "until then" : "as it last was");
  return exit_simulation_failed;
}

/// Velocities from the positions before and after, for a program that gave none.
void add_velocities(std::vector<State<double>>& samples) {
  for (std::size_t k = 0; k < samples.size() && samples.size() > 1; ++k) {
    const State<double>&a = samples[k == 0 ? 0 : k - 1], &b = samples[std::min(k + 1, samples.size() - 1)];
    samples[k].v.array() = (b.x.array() - a.x.array()) / (b.t - a.t);
  }
}

/// What another program made of an exported scene.
void view_result(ViewChoice& choice, int& exit_status) {
  if (!choice.overrides.empty())
    throw InputError("--result shows a scene as it was exported, without --set; export it with the setting");
  const peer::Exchange exchange = peer::read_export(choice.scene);
  peer::Result result = peer::read_result(choice.result, exchange);
  if (result.samples.empty())
    throw InputError(fmt::format("{} has nothing to show: {}", choice.result, result.problem));
  Scene scene = exchange.scene;
  scene.name += ", " + result.engine;
  scene.solve.device = SolveConfig{}.device;  // nothing is computed
  if (!result.problem.empty())
    fmt::print(stderr, "mss: warning: {} is shown until t = {:.6g} s: {}\n", choice.result,
               result.samples.back().t, result.problem);
  if (!result.has_velocities) add_velocities(result.samples);
  choice.options.motion = std::move(result.samples);
  exit_status = tell(choice, view::show(scene, choice.options));
}

void view_scene(ViewChoice& choice, int& exit_status) {
  check_pictures(choice);
  choice.options.shot = choice.shot;
  choice.options.record = choice.record;
  const char* usual = choice.record.empty() ? "1280x800" : "480x360";
  read_size(choice.size.empty() ? usual : choice.size, choice.options);
  if (!choice.result.empty()) return view_result(choice, exit_status);
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
  exit_status = tell(choice, view::show(scene, choice.options));
}

/// What makes pictures instead of a window.
void add_picture_options(CLI::App& command, ViewChoice& choice) {
  CLI::Option* shot =
      command.add_option("--shot", choice.shot, "Open no window; write a picture to this PNG file");
  CLI::Option* record =
      command
          .add_option(
              "--record", choice.record,
              "Open no window; write a moving picture to this WebP file, or, if its name ends in .png or is "
              "a directory, a PNG file a frame; it may say by %04d where the number goes")
          ->excludes(shot);
  command.add_option(
      "--frames", choice.options.frames,
      "With --shot: number of frames of 1/60 s to simulate before the picture (default 0: the start). "
      "With --record: number of frames (default: those of the scene's duration)");
  command
      .add_option("--rate", choice.options.rate,
                  "Frames that are recorded of a simulated second, which is played in a second (default 25)")
      ->needs(record);
  command
      .add_flag("--every-frame", choice.options.every_frame,
                "Draw all of these frames, as a window would; --log has the time that takes")
      ->needs(shot);
  command.add_option("--result", choice.result,
                     "In a picture: what another program made of the scene, a folder with samples.csv and "
                     "cost.json; the scene is then the folder of `mss peer export`");
  command.add_flag("--plain", choice.options.plain,
                   "Picture of the body alone, without panel, graphs and colour bar");
}

void add_view(CLI::App& app, int& exit_status) {
  CLI::App* command =
      app.add_subcommand("view", "show a scene live in a window, or make a picture of it, which may move");
  const auto choice = std::make_shared<ViewChoice>();
  command->add_option("scene", choice->scene, "Scene file (TOML), or a name from `mss list scenes`")
      ->required();
  add_settings(*command, choice->overrides);
  command->add_option("--size", choice->size,
                      "Width and height of the window or picture [pixels] (default 1280x800; recorded "
                      "480x360, the body alone)");
  add_picture_options(*command, *choice);
  command->add_flag("--log", choice->options.log, "Print a line of JSON for every action in the window");
  command->callback([choice, &exit_status] { view_scene(*choice, exit_status); });
}

}  // namespace

Command view_command() { return add_view; }

}  // namespace mss::cli
