// Bodies that lie on themselves: whether they go through.
#include "experiments/studies/contact/self_contact.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/bodies/bodies_measures.hpp"
#include "core/bodies/contact_surface.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "experiments/simulation/scene_run.hpp"
#include "experiments/studies/contact/crossings.hpp"

namespace mss::studies::contact {

namespace {

constexpr double crossing_depth = 0.1;  ///< cells; less is what touches
constexpr double near_at_rest = 2.01;   ///< cells
constexpr int moments = 20;
constexpr const char* arch_name = "arch";

constexpr const char* arch_text = R"(
[body]
cells = [9, 2, 9]
cell_size = 0.03

[material]
density = 1000
young = 2e5
poisson = 0.3

[damping]
ratio = 0.2

[contact]
self = true
friction = 0.3
stiffness = 10

[[hold]]
box = [[0, 0, 0], [0.03, 0.06, 0.03]]
path = [[0, 0, 0, 0], [0.4, 0.082, 0, 0]]

[[hold]]
box = [[0.24, 0, 0], [0.27, 0.06, 0.03]]
path = [[0, 0, 0, 0], [0.4, -0.082, 0, 0]]

[solve]
integrator = "verlet"
dt = "safe"
duration = 0.5
)";

/// Two legs of two cells, and as much across them.
Scene arch(const std::vector<std::string>& overrides) {
  Scene scene = parse_scene(arch_text, overrides);
  VoxelGrid& voxels = scene.body.voxels;
  for (int k = 0; k < voxels.nz() - 2; ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 2; i < voxels.nx() - 2; ++i) voxels.set(i, j, k, false);
  return scene;
}

Scene scene_of(const SelfContactRun& run) {
  constexpr double implicit_step = 1.0 / 240;
  std::vector<std::string> overrides{fmt::format("contact.self={}", run.touches),
                                     fmt::format("solve.integrator=\"{}\"", run.integrator),
                                     "solve.threads=1"};
  if (!find_integrator(run.integrator).limit)
    overrides.push_back(fmt::format("solve.dt={:.17g}", implicit_step));
  if (run.scene == arch_name) return arch(overrides);
  return load_scene(scene_file(run.scene), overrides);
}

/// Where a body's surface is.
std::vector<Vec3> vertices_at(const ContactSurface& surface, const Field<double>& x) {
  std::vector<Vec3> vertices;
  for (std::size_t v = 0; v < surface.size(); ++v) vertices.push_back(surface.at(v, x));
  return vertices;
}

struct SelfContactNumbers {
  double dt = no_value, deepest = no_value, jacobian = no_value;
  std::int64_t triangles = 0, touches = 0, crossed = 0;
  Status status = Status::ok;
};

SelfContactNumbers follow_self_contact(const Scene& scene) {
  const Body body(scene.body);
  const ContactSurface surface(body, nullptr);
  const double cell = scene.body.cell_size;
  SceneRun<double> run(scene, body);
  SelfContactNumbers n{.dt = run.dt(), .deepest = 0, .jacobian = 1};
  n.triangles = std::int64_t(surface.mesh().triangles.size());
  Work work;
  for (int i = 1; i <= moments; ++i) {
    n.status = run.advance(scene.solve.duration * i / moments, work);
    const std::optional<Measures> measures = run.measure();
    if (!measures) n.status = Status::non_finite;
    if (n.status != Status::ok) return n;
    n.jacobian = std::min(n.jacobian, measures->min_jacobian);
    n.crossed =
        std::max(n.crossed, std::int64_t(crossings(surface.mesh(), vertices_at(surface, run.state().x),
                                                   near_at_rest * cell, crossing_depth / 2 * cell)));
    const auto contact = measure_bodies(run.system(), run.state()).contact;
    if (!contact) continue;
    n.touches = std::max(n.touches, std::int64_t(contact->touches));
    n.deepest = contact->depth_so_far;
  }
  return n;
}

}  // namespace

const std::vector<std::string>& self_contact_scenes() {
  static const std::vector<std::string> all{"pressed_ring", "folded_beam", arch_name};
  return all;
}

std::string SelfContactRun::name() const {
  return fmt::format("self contact, {}, {}{}", scene, integrator, touches ? "" : ", none");
}

SelfContactConfig self_contact_config(const ExperimentOptions& options) {
  SelfContactConfig config;
  const std::vector<std::string> scenes =
      options.quick ? std::vector<std::string>{arch_name} : self_contact_scenes();
  for (const std::string& scene : scenes)
    for (const char* method : {"verlet", "backward_euler"})
      for (const bool touches : {true, false}) config.runs.push_back({scene, method, touches});
  return config;
}

Table empty_self_contact() {
  return Table({{"scene"},
                {"integrator"},
                {"contact"},
                {"dt", "s"},
                {"triangles"},
                {"touches"},
                {"deepest"},
                {"min_jacobian"},
                {"crossings"},
                {"status"},
                {"reason"}});
}

void add_self_contact_run(const SelfContactRun& run, Table& rows) {
  SelfContactNumbers n;
  const auto add = [&](const std::string& status, const std::string& reason) {
    rows.add({run.scene, run.integrator, std::string(run.touches ? "self" : "none"), n.dt, n.triangles,
              n.touches, n.deepest, n.jacobian, n.crossed, status, reason});
  };
  try {
    const Scene scene = scene_of(run);
    check_solve(scene);
    n = follow_self_contact(scene);
    if (n.status != Status::ok) return add(std::string(to_string(n.status)), "");
    add(n.crossed > 0 ? "crosses" : "ok", "");
  } catch (const InputError& error) {
    add("refused", error.what());
  }
}

}  // namespace mss::studies::contact
