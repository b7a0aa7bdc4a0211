// Runs of scenes on a device: the rows of one that is lost are kept, and what cannot run there is refused.
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "core/device/device.hpp"
#include "core/scene/scene.hpp"
#include "experiments/io/process.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/simulation/simulation.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss {
namespace {

Scene falling_cube(const std::string& device, const std::string& integrator = "velocity_verlet") {
  return parse_scene(testing::cube_text("0.1") + fmt::format(R"([environment]
gravity = [0, 0, -9.81]
[[plane]]
point = [0, 0, -0.01]
normal = [0, 0, 1]
[solve]
integrator = "{}"
device = "{}"
dt = 1e-3
duration = 0.1
)",
                                                             integrator, device));
}

bool has_device() {
  try {
    Device::open("gpu");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

TEST(DeviceRun, HasTheRowsOfTheProcessor) {
  if (!has_device()) GTEST_SKIP() << "no device";
  Progress quiet;
  const SimulationResult there = simulate(falling_cube("gpu"), quiet),
                         here = simulate(falling_cube("cpu"), quiet);
  EXPECT_EQ(there.status, Status::ok);
  EXPECT_EQ(there.device.rfind(Device::open("gpu")->info().name, 0), 0U) << there.device;
  EXPECT_EQ(here.device, "");
  EXPECT_GT(there.transfer_seconds, 0);
  EXPECT_EQ(here.transfer_seconds, 0);
  ASSERT_EQ(there.series.size(), here.series.size());
  for (std::size_t row = 0; row < here.series.size(); ++row) {
    EXPECT_EQ(there.series[row].t, here.series[row].t);
    EXPECT_NEAR(there.series[row].total(), here.series[row].total(), 1e-9 * std::abs(here.series[1].total()));
    EXPECT_NEAR(there.series[row].reactions.planes[0][2], here.series[row].reactions.planes[0][2], 1e-6);
  }
}

/// The bear, spinning into a floor: the largest difference of a particle after 200 steps over the largest
/// way.
double difference_of_bears(const std::string& precision) {
  const auto bear = [&](const std::string& device) {
    const Scene scene =
        load_scene(scene_file("mesh_bear"),
                   {"body.contact_on=\"particles\"", "plane=[{point=[0,0,0.195],normal=[0,0,1]}]",
                    "start.angular_velocity=[8,5,3]", "solve.dt=1e-4", "solve.duration=0.02",
                    "solve.precision=\"" + precision + "\"", "solve.device=\"" + device + "\"",
                    "solve.integrator=\"velocity_verlet\""});
    Progress quiet;
    const SimulationResult result = simulate(scene, quiet);
    EXPECT_EQ(result.status, Status::ok);
    EXPECT_EQ(result.work.steps, 200);
    EXPECT_GT(result.series.back().reactions.planes[0][2], 1);
    return result.particles;
  };
  const std::vector<ParticleRecord> there = bear("gpu"), here = bear("cpu");
  double way = 0, difference = 0;
  for (std::size_t id = 0; id < here.size(); ++id) {
    way = std::max(way, (here[id].x - here[id].rest).norm());
    difference = std::max(difference, (here[id].x - there[id].x).norm());
  }
  return difference / way;
}

TEST(DeviceRun, MovesTheBearAsTheProcessorDoes) {
  if (!has_device()) GTEST_SKIP() << "no device";
  EXPECT_LT(difference_of_bears("double"), 1e-10);
  EXPECT_LT(difference_of_bears("single"), 1e-4);
}

int calls = 0, first_lost_call = 0;
GLenum lost_from_a_call_on() { return ++calls < first_lost_call ? GL_NO_ERROR : GL_UNKNOWN_CONTEXT_RESET; }

/// A run on a device that is lost at a question whether it is, the first of which is 1.
SimulationResult run_lost_at(int call) {
  Device::open("gpu");
  const auto honest = epoxy_glGetGraphicsResetStatus;
  calls = 0;
  first_lost_call = call;
  epoxy_glGetGraphicsResetStatus = lost_from_a_call_on;
  Progress quiet;
  SimulationResult result = simulate(falling_cube("gpu"), quiet);
  epoxy_glGetGraphicsResetStatus = honest;
  return result;
}

/// Wherever it is lost: no row is kept that a whole run has otherwise.
TEST(DeviceRun, KeepsTheRowsBeforeTheDeviceWasLost) {
  if (!has_device()) GTEST_SKIP() << "no device";
  const SimulationResult whole = run_lost_at(1000000);
  EXPECT_EQ(whole.status, Status::ok);
  const int asked = calls;
  std::size_t most_rows = 0;
  for (int call = asked; call > asked / 2; call -= 2) {
    const SimulationResult result = run_lost_at(call);
    EXPECT_EQ(to_string(result.status), "device_lost") << call;
    EXPECT_LT(result.series.size(), whole.series.size()) << call;
    for (std::size_t row = 0; row < result.series.size(); ++row) {
      EXPECT_EQ(result.series[row].t, whole.series[row].t) << call;
      EXPECT_EQ(result.series[row].total(), whole.series[row].total()) << call << " row " << row;
    }
    most_rows = std::max(most_rows, result.series.size());
  }
  EXPECT_EQ(most_rows + 1, whole.series.size());
}

void expect_refused(const std::vector<std::string>& arguments, const std::string& part) {
  const ProgramRun run = run_program(arguments);
  EXPECT_EQ(run.exit_status, 2) << run.output;
  EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  EXPECT_NE(run.output.find(part), std::string::npos) << run.output;
}

TEST(DeviceRun, IsRefusedInASentence) {
  const auto run_on_gpu = [](const std::string& variable) {
    return std::vector<std::string>{
        "/usr/bin/env",         variable, MSS_PROGRAM,      "run", "cantilever", "--set",
        "solve.device=\"gpu\"", "--out",  "/dev/null/never"};
  };
  expect_refused(run_on_gpu("__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent"), "no device with OpenGL 4.3");
  if (has_device() && Device::open("gpu")->info().is_software)
    expect_refused(run_on_gpu("MESA_GL_VERSION_OVERRIDE=4.2"), "it has no context of OpenGL 4.3");
  if (!has_device()) return;
  Progress quiet;
  EXPECT_THROW(simulate(falling_cube("gpu", "backward_euler"), quiet), InputError);
  EXPECT_THROW(simulate(falling_cube("gpu:42"), quiet), InputError);
}

}  // namespace
}  // namespace mss
