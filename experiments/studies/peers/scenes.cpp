// The scenes of `mss peers`, and what is right of them.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "experiments/io/output.hpp"
#include "experiments/simulation/moving_body.hpp"
#include "experiments/studies/peers/peers.hpp"
#include "reference/closed_forms.hpp"

namespace mss::studies::peers {

namespace {

constexpr double gravity = 9.81;  ///< [m/s^2]
constexpr double length = 4;      ///< of beams and bars, 1 m wide and high [m]

/// What CalculiX 2.20's quadratic elements (C3D20, 16x4x4) say of a cantilever of 10 kg/m^3, 1 MPa, nu = 0.3:
/// the rest and the first period of its tip. reference/peers/README.md has the commands.
constexpr double bent_tip = -0.039095, bent_period = 0.32402;  // [m], [s]

/// The same of a bar that hangs from a face that it cannot narrow at, E = 1 MPa, nu = 0.3 [m] (its command is
/// there too); with nu = 0 it is rho g L^2 / (2 E).
constexpr double hanging_by_a_clamp = 7.7056e-4;

std::string bar_text(int across, double poisson, const std::string& pull, double duration) {
  return fmt::format(R"([body]
cells = [{0}, {1}, {1}]
cell_size = {2}
[material]
density = 10
young = 1e6
poisson = {3}
[environment]
gravity = {4}
[[hold]]
box = [[0, 0, 0], [0, 1, 1]]
[solve]
integrator = "verlet"
dt = "safe"
duration = {5}
)",
                     4 * across, across, 1.0 / across, poisson, pull, duration);
}

/// A cantilever that is let go; damped almost critically it rests after four periods.
PeerScene cantilever(int across) {
  PeerScene scene{.name = fmt::format("cantilever_{}", across),
                  .question = Question::bending,
                  .end = {{length, 0, 0}, {length, 1, 1}},
                  .displacement = bent_tip,
                  .period = bent_period,
                  .drag = 1.4 * 2 * std::numbers::pi / bent_period,
                  .rest_seconds = 4 * bent_period};
  scene.scene = parse_scene(bar_text(across, 0.3, fmt::format("[0, 0, {}]", -gravity),
                                     std::ceil(2.3 * bent_period / frame) * frame));
  return scene;
}

PeerScene hanging_bar(const std::string& name, int across, double poisson, double sag) {
  PeerScene scene{.name = name,
                  .question = Question::hanging,
                  .end = {{length, 0, 0}, {length, 1, 1}},
                  .axis = 0,
                  .displacement = sag,
                  .drag = 60,
                  .rest_seconds = 0.4};
  scene.scene = parse_scene(bar_text(across, poisson, fmt::format("[{}, 0, 0]", gravity), 0.1));
  return scene;
}

constexpr const char* rubber = R"([material]
density = 1000
young = {}
poisson = 0.3
[solve]
integrator = "verlet"
dt = "safe"
duration = 1.0
)";

/// Spinning so fast that it bulges by some percent.
PeerScene spinning_cube(int cells) {
  PeerScene scene{.name = fmt::format("flight_{}", cells), .question = Question::flight};
  scene.scene =
      parse_scene(fmt::format("[body]\ncells = [{0}, {0}, {0}]\ncell_size = {1}\n", cells, 1.0 / cells) +
                  "[start]\nvelocity = [1, 0.5, 0]\nangular_velocity = [0, 0, 6]\n" +
                  fmt::format(fmt::runtime(rubber), 1e5));
  return scene;
}

std::string ground(double x, double z, double friction) {
  return fmt::format(
      "[environment]\ngravity = [{}, 0, {}]\n[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nrestitution = "
      "0\n"
      "friction = {}\n",
      x, z, friction);
}

/// Dropped from half a metre.
PeerScene dropped_cube(int cells) {
  PeerScene scene{.name = fmt::format("dropped_cube_{}", cells), .question = Question::landing};
  scene.scene =
      parse_scene(fmt::format("[body]\ncells = [{0}, {0}, {0}]\ncell_size = {1}\norigin = [0, 0, 0.5]\n",
                              cells, 1.0 / cells) +
                  ground(0, -gravity, 0.4) + fmt::format(fmt::runtime(rubber), 1e5));
  return scene;
}

/// Cells whose centres are in a ball of that diameter.
std::string ball_of_voxels(int cells) {
  std::string text;
  const auto distance = [&](int i) { return double(2 * i + 1 - cells) / cells; };
  for (int k = 0; k < cells; ++k) {
    for (int j = 0; j < cells; ++j) {
      for (int i = 0; i < cells; ++i)
        text += std::hypot(distance(i), distance(j), distance(k)) <= 1 ? '#' : '.';
      text += '\n';
    }
    text += '\n';
  }
  return text;
}

PeerScene dropped_ball(int cells, const std::filesystem::path& folder) {
  const std::string name = fmt::format("dropped_ball_{}", cells);
  write_atomically(folder / (name + ".txt"), ball_of_voxels(cells));
  const std::filesystem::path file = folder / (name + ".toml");
  write_atomically(file, fmt::format("[body]\nvoxels = \"{}.txt\"\ncell_size = {}\norigin = [0, 0, 0.5]\n",
                                     name, 1.0 / cells) +
                             ground(0, -gravity, 0.4) + fmt::format(fmt::runtime(rubber), 1e5));
  PeerScene scene{.name = name, .question = Question::landing};
  scene.scene = load_scene(file);
  return scene;
}

/// A block on a slope of 20 degrees, told as one on level ground under a gravity that leans.
PeerScene block_on_slope(int cells) {
  const double angle = 20 * std::numbers::pi / 180, friction = 0.2;
  PeerScene scene{.name = fmt::format("slope_{}", cells),
                  .question = Question::slope,
                  .end = {{0, 0, 0}, {1, 0.5, 0.5}},
                  .axis = 0,
                  .displacement = reference::slope_distance(gravity, angle, friction, 1)};
  scene.scene = parse_scene(
      fmt::format("[body]\ncells = [{0}, {1}, {1}]\ncell_size = {2}\n", 2 * cells, cells, 0.5 / cells) +
      ground(gravity * std::sin(angle), -gravity * std::cos(angle), friction) +
      fmt::format(fmt::runtime(rubber), 1e6));
  return scene;
}

}  // namespace

std::vector<PeerScene> peer_scenes(bool quick, const std::filesystem::path& folder) {
  const double sag = reference::hanging_sag({1e6, 0, 1, length}, 10, gravity);
  std::vector<PeerScene> scenes;
  scenes.push_back(cantilever(2));
  if (quick) {
    scenes.push_back(hanging_bar("bar_2_nu_0", 2, 0, sag));
    scenes.push_back(spinning_cube(3));
    scenes.push_back(dropped_cube(3));
    return scenes;
  }
  scenes.push_back(cantilever(4));
  scenes.push_back(hanging_bar("bar_2_nu_0", 2, 0, sag));
  scenes.push_back(hanging_bar("bar_2_nu_0.3", 2, 0.3, hanging_by_a_clamp));
  scenes.push_back(spinning_cube(7));
  scenes.push_back(dropped_cube(7));
  scenes.push_back(dropped_ball(8, folder));
  scenes.push_back(block_on_slope(3));
  return scenes;
}

}  // namespace mss::studies::peers
