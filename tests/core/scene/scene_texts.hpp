#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace mss::testing {

/// A folder of its own for every test: they run side by side.
class SceneFolder {
 public:
  SceneFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mss_scene_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  SceneFolder(const SceneFolder&) = delete;
  SceneFolder& operator=(const SceneFolder&) = delete;
  ~SceneFolder() { std::filesystem::remove_all(path_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::remove(path_ / name);  // file systems wait for the disk where a file is written over
    std::ofstream(path_ / name) << text;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Tables [body] and [material] of a soft cube of two cells an edge.
inline std::string cube_text(const std::string& cell_size) {
  return "[body]\ncells = [2, 2, 2]\ncell_size = " + cell_size +
         "\n[material]\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\n";
}

inline const std::string plain_scene = cube_text("0.5") + R"([solve]
dt = 1e-3
duration = 1
)";

inline const std::string full_scene = R"(# Everything a scene can say.
[body]
cells = [4, 2, 3]
cell_size = 0.25
origin = [0.5, 0, -1]
topology = "edges+body"
sharing = "uniform"
[material]
density = 900
springs = { edge = 100, face = 110.5, body = 300 }
volume = -0.1
[damping]
ratio = 0.05
[environment]
gravity = [0, 0.5, -9.81]
[[hold]]
box = [[0.5, 0, -1], [0.5, 0.5, -0.25]]
[[hold]]
box = [[1.5, 0, -1], [1.5, 0.5, -0.25]]
axes = "zx"
velocity = [0, 0, 1]
displacement = [0.1, 0.2, 0.3]
turn = { axis = [0, 0, 2], centre = [1.5, 0.25, 0], rate = -1.5, until = 0.75 }
[[load]]
box = [[1.5, 0, -1], [1.5, 0, -1]]
force = [1, 2, 3]
[[strike]]
box = [[0.5, 0, -1], [0.5, 0.5, -1]]
at = 0.5
impulse = [0, 0.25, -2]
[[weight]]
box = [[1.5, 0, -1], [1.5, 0.25, -1]]
mass = 12
[[plane]]
point = [0, 0, -2]
normal = [0, 3, 4]
contact = "penalty"
restitution = 0.25
friction = 1.5
[[plane]]
point = [1, 2, -3]
normal = [0, 0, 1]
[start]
velocity = [4, 5, 6]
angular_velocity = [7, 8, 9]
[solve]
integrator = "velocity_verlet"
dt = 2e-4
duration = 3
threads = 2
precision = "single"
linear_solver = "matrix_free"
nonlinear_solver = "lbfgs"
iterations = 5
tangent = "projected"
spectral_radius = 0.5
region_width = 3
alpha = 0.25
tolerance = 1e-5
every = 0.5
)";

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

}  // namespace mss::testing
