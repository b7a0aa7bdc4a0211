#include "experiments/peer/exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/reduced_model.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_run.hpp"

namespace mss::peer {

namespace {

/// What the tables of an export cannot say.
void check_exchangeable(const Scene& scene) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(
        fmt::format("{}: {}, which the tables of an export do not have; leave it out for other programs",
                    scene.file.string(), what));
  };
  if (is_static(scene))
    throw InputError(
        fmt::format("{}: integrator = \"{}\" finds where a body rests, and an export is of a motion; give "
                    "another solve.integrator",
                    scene.file.string(), scene.solve.integrator));
  if (is_refined(scene)) refuse("its body has cells of several sizes");
  if (!scene.body.is_solid()) refuse(fmt::format("its body is {}, without cells", scene.body.noun()));
  if (scene.body.relaxation.acts()) refuse("material.relaxation is given");
  if (scene.environment.contact_surface) refuse("planes touch the vertices of its mesh (contact_on)");
  if (!scene.environment.obstacles.empty()) refuse("it has an [[obstacle]]");
  if (!scene.environment.strikes.empty()) refuse("it has a [[strike]]");
  for (std::size_t h = 0; h < scene.environment.holds.size(); ++h) {
    const Hold& hold = scene.environment.holds[h];
    if (hold.moves()) refuse(fmt::format("hold.{} moves", h));
    if (hold.axes != Hold{}.axes) refuse(fmt::format("hold.{} leaves an axis free", h));
  }
  for (std::size_t l = 0; l < scene.environment.loads.size(); ++l)
    if (!scene.environment.loads[l].history.empty()) refuse(fmt::format("load.{} changes in time", l));
}

bool acts_by_impulses(const Plane& plane) { return plane.contact != ContactLaw::penalty; }

/// The scene driven for its reference.
Scene for_reference(const Exchange& exchange) {
  Scene scene = exchange.scene;
  const std::vector<Plane>& planes = scene.environment.planes;
  scene.solve = {
      .integrator = std::any_of(planes.begin(), planes.end(), acts_by_impulses) ? "velocity_verlet" : "rk4",
      .dt = {},
      .duration = exchange.scene.solve.duration,
      .threads = 1};
  return scene;
}

/// Empty if stopped. Throws InputError where a number is not finite.
std::vector<State<double>> motion(const Exchange& exchange, const Scene& scene, Progress& progress) {
  SceneRun<double> run(scene, *exchange.body);
  std::vector<State<double>> samples;
  Work work;
  for (const double t : exchange.times) {
    progress.report(t / exchange.times.back(), "reference");
    if (progress.stopped()) return {};
    const Status status = t > 0 ? run.advance(t, work) : Status::ok;
    if (status != Status::ok || !is_finite(run.state()))
      throw InputError(fmt::format("{}: its reference, by {} in steps of {:.3g} s, fails at t = {:.4g} s: {}",
                                   scene.file.string(), scene.solve.integrator, *scene.solve.dt, t,
                                   to_string(status == Status::ok ? Status::non_finite : status)));
    samples.push_back(run.state());
    samples.back().t = t;
  }
  return samples;
}

double largest_displacement(const Exchange& exchange, const std::vector<State<double>>& samples) {
  double largest = 0;
  for (const State<double>& sample : samples)
    for (const std::ptrdiff_t site : exchange.body->sites())
      largest = std::max(largest, (sample.x.at(site) - exchange.start.x.at(site)).squaredNorm());
  return std::sqrt(largest);
}

double root_mean_square_distance(const Exchange& exchange, const std::vector<State<double>>& a,
                                 const std::vector<State<double>>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    for (const std::ptrdiff_t site : exchange.body->sites())
      sum += (a[k].x.at(site) - b[k].x.at(site)).squaredNorm();
  return std::sqrt(sum / double(a.size() * exchange.body->particle_count()));
}

}  // namespace

Exchange make_exchange(const Scene& scene, double spacing) {
  check_exchangeable(scene);
  check_model(scene);
  check_boxes(scene);
  if (!(spacing > 0 && spacing <= scene.solve.duration))
    throw InputError(
        fmt::format("samples are {:g} s apart, and {} lasts {:g} s; give a positive time up to that", spacing,
                    scene.name, scene.solve.duration));
  constexpr double most_samples = 1e6;
  if (scene.solve.duration / spacing > most_samples)
    throw InputError(
        fmt::format("samples {:g} s apart are more than {:g}; give a longer time", spacing, most_samples));
  Exchange exchange{.scene = scene, .body = std::make_unique<const Body>(scene.body)};
  if (reduction_named(scene.model))
    throw InputError(fmt::format(
        "{}: material.model = \"{}\" moves few coordinates, which no other program has; give \"springs\"",
        scene.file.string(), scene.model));
  exchange.system = make_system<double>(scene.model, *exchange.body, scene.environment, 1);
  exchange.start = start_state(*exchange.system, scene);
  exchange.spacing = spacing;
  constexpr double rounding = 1e-6;
  const auto last = long(std::floor(scene.solve.duration / spacing + rounding));
  for (long k = 0; k <= last; ++k) exchange.times.push_back(double(k) * spacing);
  return exchange;
}

void add_reference(Exchange& exchange, Progress& progress) {
  constexpr double most_seconds = 20;  // of a motion that is to be computed again in steps half as long
  constexpr int most_halvings = 6;
  Scene scene = for_reference(exchange);
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  const double enough = method.order_undamped > 2 ? 1e-5 : 1e-4;  // a high order is soon exact
  long steps = explicit_steps(method, exchange.system->spectral_bound(), exchange.spacing).steps;
  const auto motion_in = [&](long per_sample) {
    scene.solve.dt = exchange.spacing / double(per_sample);
    return motion(exchange, scene, progress);
  };
  std::vector<State<double>> coarse = motion_in(steps);
  for (int halving = 0; halving < most_halvings && !coarse.empty(); ++halving) {
    steps *= 2;
    std::vector<State<double>> fine;
    const double seconds = seconds_of([&] { fine = motion_in(steps); });
    if (fine.empty()) return exchange.reference.clear();
    const double distance = root_mean_square_distance(exchange, coarse, fine),
                 scale = largest_displacement(exchange, fine);
    exchange.facts = {method.name, *scene.solve.dt, distance > 0 ? distance / scale : 0};
    exchange.reference = coarse = std::move(fine);
    if (exchange.facts.uncertainty < enough || seconds > most_seconds) break;
  }
  exchange.provenance = provenance();
}

}  // namespace mss::peer
