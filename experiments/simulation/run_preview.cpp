#include "experiments/simulation/run_preview.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "core/body/body.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss {

namespace {

constexpr double patience = 0.5;  ///< [s]

std::size_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::size_t(usage.ru_maxrss) * 1024;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The first piece warms up and is not counted, unless it is all that patience lasts for.
template <class Real>
void time_steps(SceneRun<Real>& run, double piece, double duration, RunPreview& preview) {
  Work work;
  const auto begin = std::chrono::steady_clock::now();
  for (double end = piece; preview.status == Status::ok; end += piece) {
    const auto start = std::chrono::steady_clock::now();
    const double from = run.state().t;
    preview.status = run.advance(std::min(end, duration), work);
    const bool is_first = from == 0, is_last = seconds_since(begin) > patience || end >= duration;
    if (!is_first || is_last) {
      preview.wall_seconds += seconds_since(start);
      preview.simulated_seconds += run.state().t - from;
    }
    if (is_last) return;
  }
}

template <class Real>
RunPreview preview_in(const Scene& scene) {
  const Body body(scene.body);
  SceneRun<Real> run(scene, body);
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  const Box box = box_at_rest(scene);
  RunPreview preview{.extent = box.upper - box.lower,
                     .mass = run.system().total_mass(),
                     .particles = run.system().particles().size()};
  for (const Level& level : run.system().levels()) preview.cells += level.body.cell_count();
  const double duration = scene.solve.duration;
  if (method.stepping == Stepping::fixed) {
    preview.dt = run.dt();
    preview.steps = std::lround(duration / run.dt());
  }
  if (method.stepping != Stepping::equilibrium && duration > 0)
    time_steps(run, method.stepping == Stepping::fixed ? run.dt() : std::min(scene.solve.every, duration),
               duration, preview);
  preview.memory_bytes = peak_memory();
  return preview;
}

}  // namespace

RunPreview preview_run(const Scene& scene) {
  check_solve(scene);
  return scene.solve.precision == Precision::single ? preview_in<float>(scene) : preview_in<double>(scene);
}

std::string body_in_words(const Scene& scene, const Vec3& extent, double mass, std::size_t cells,
                          std::size_t particles) {
  const BodyConfig& body = scene.body;
  std::vector<std::string> edges;
  for (int axis = 0; axis < 3; ++axis)
    if (body.voxels.size()[std::size_t(axis)] > 0 || !scene.others.empty())
      edges.push_back(fmt::format("{:.4g}", extent[axis]));
  std::string size = fmt::format("{} m", fmt::join(edges, " x "));
  if (!scene.others.empty())
    size = fmt::format("{} bodies in {}", scene.others.size() + 1, size);
  else if (!body.is_solid())
    size = fmt::format("{} of {}, {:.4g} m thick", body.noun(), size, body.across());
  return fmt::format("{}, {:.4g} kg, {} cells, {} particles", size, mass, cells, particles);
}

}  // namespace mss
