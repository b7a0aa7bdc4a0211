// The Python module mss._mss; mss/__init__.pyi says what it offers, with shapes and units.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <numbers>

#include "core/base/error.hpp"
#include "core/body/body.hpp"
#include "core/measures/measures.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/python/simulation.hpp"
#include "experiments/python/study.hpp"
#include "experiments/python/toml_text.hpp"
#include "experiments/simulation/matched_scene.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/reduced_model.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/scene_files.hpp"
#include "integrators/analysis/modes.hpp"

namespace mss::python {

namespace py = pybind11;

namespace {

Scene read_scene(const py::object& scene, const std::vector<std::string>& overrides) {
  if (py::isinstance<py::dict>(scene))
    return matched(parse_scene(toml_text(scene.cast<py::dict>()), overrides)).scene;
  return load_matched_scene(scene_file(scene.cast<std::filesystem::path>().string()), overrides).scene;
}

/// A message of the program about one of its overrides, with the key in `settings` in place of --set.
std::string naming_the_setting(const std::string& message, const std::vector<std::string>& overrides) {
  for (const std::string& setting : overrides) {
    const std::string place = "--set " + setting + ":";
    if (message.starts_with(place))
      return "settings[\"" + setting.substr(0, setting.find('=')) + "\"]:" + message.substr(place.size());
  }
  return message;
}

/// use(scene), of a scene from a file, from the name of one that comes with the program, or from a dict.
template <class Use>
auto with_scene(const py::object& scene, const py::dict& settings, Use&& use) {
  const std::vector<std::string> overrides = toml_overrides(settings);
  try {
    return use(read_scene(scene, overrides));
  } catch (const InputError& error) {
    throw InputError(naming_the_setting(error.what(), overrides));
  }
}

std::unique_ptr<Simulation> load(const py::object& scene, const py::dict& settings) {
  return with_scene(scene, settings, make_simulation);
}

py::dict run_scene_with(const py::object& scene, const py::dict& settings) {
  return with_scene(scene, settings, run_scene);
}

/// What loads a scene without the interpreter.
fit::SceneSource source_of(const py::object& scene) {
  if (!py::isinstance<py::dict>(scene))
    return fit::source_of(scene_file(scene.cast<std::filesystem::path>().string()));
  const std::string text = toml_text(scene.cast<py::dict>());
  return {"", [text](const std::vector<std::string>& settings) {
            return matched(parse_scene(text, settings)).scene;
          }};
}

/// KEY and KEY=LOW..HIGH, from such texts or from a dict of bounds, None where there are none.
std::vector<std::string> parameter_texts(const py::object& parameters) {
  if (!py::isinstance<py::dict>(parameters)) return parameters.cast<std::vector<std::string>>();
  std::vector<std::string> texts;
  for (const auto& [key, bounds] : parameters.cast<py::dict>()) {
    texts.push_back(key.cast<std::string>());
    if (bounds.is_none()) continue;
    const auto [low, high] = bounds.cast<std::pair<py::object, py::object>>();
    texts.back() += "=" + (low.is_none() ? "" : py::repr(low).cast<std::string>()) + ".." +
                    (high.is_none() ? "" : py::repr(high).cast<std::string>());
  }
  return texts;
}

fit::Observations observations_of(const py::object& data, const fit::SceneSource& source,
                                  const std::vector<std::string>& overrides) {
  if (py::isinstance<py::list>(data)) {
    py::dict tables;
    tables["observation"] = data;
    return fit::read_observations_text(toml_text(tables), source, overrides);
  }
  return fit::read_observations(data.cast<std::filesystem::path>(), source, overrides);
}

py::dict fit_with(const py::object& scene, const py::object& data, const py::object& parameters,
                  const py::dict& settings, double evaluations, const py::dict& coarse) {
  const std::vector<std::string> overrides = toml_overrides(settings);
  if (!(evaluations >= 1)) throw InputError("evaluations is too small; give a number of 1 or more");
  try {
    const fit::SceneSource source = source_of(scene);
    fit::FitProblem problem = fit::read_problem(source, overrides, parameter_texts(parameters));
    problem.data = observations_of(data, source, overrides);
    problem.most_evaluations = evaluations;
    problem.coarse = toml_overrides(coarse);
    fit::check_problem(problem);
    return fit_scene(problem);
  } catch (const InputError& error) {
    throw InputError(naming_the_setting(error.what(), overrides));
  }
}

/// A dict that has its values also by the names that columns had before.
py::dict by_old_names_too(const py::dict& columns) {
  return py::module_::import("mss").attr("_Columns")(columns);
}

py::dict measures(Simulation& simulation) { return by_old_names_too(simulation.measures()); }

py::dict energies(Simulation& simulation) {
  const py::dict all = simulation.measures();
  py::dict energies;
  for (const char* name : {"kinetic", "elastic", "volume_energy", "external_potential", "total"})
    energies[name] = all[name];
  return by_old_names_too(energies);
}

std::size_t particle_count(const Simulation& simulation) {
  std::size_t count = 0;
  for (const Level& level : simulation.levels()) count += level.body.particle_count();
  return count;
}

/// By body, in the scene's order: its name, or None, and its particles as a slice of arrays.
py::list bodies(const Simulation& simulation) {
  py::list all;
  const std::vector<const SceneBody*> said = bodies_of(simulation.scene());
  std::size_t first = 0;
  for (std::size_t b = 0; b < said.size(); ++b) {
    const std::size_t last = first + simulation.levels()[b].body.particle_count();
    const std::string& name = said[b]->body_name;
    all.append(py::make_tuple(name.empty() ? py::object(py::none()) : py::object(py::str(name)),
                              py::slice(py::ssize_t(first), py::ssize_t(last), 1)));
    first = last;
  }
  return all;
}

Doubles masses(const Simulation& simulation) {
  Doubles masses(py::ssize_t(particle_count(simulation)));
  double* out = masses.mutable_data();
  for (const auto& [body, first] : simulation.levels())
    for (const std::ptrdiff_t site : body.sites()) *out++ = body.mass(site);
  return masses;
}

Doubles rest_positions(const Simulation& simulation) {
  Doubles positions({py::ssize_t(particle_count(simulation)), py::ssize_t(3)});
  double* out = positions.mutable_data();
  for (const auto& [body, first] : simulation.levels())
    for (const std::ptrdiff_t site : body.sites())
      for (int axis = 0; axis < 3; ++axis) *out++ = body.rest_position(site)[axis];
  return positions;
}

py::array_t<int> cells(const Simulation& simulation) {
  const std::size_t corners = simulation.levels().front().body.corners().size();
  std::size_t count = 0;
  for (const auto& [body, first] : simulation.levels()) {
    count += body.cell_count();
    if (body.corners().size() != corners)
      throw InputError(simulation.scene().name + ": some bodies are of cells, others of squares or links");
  }
  py::array_t<int> cells({py::ssize_t(count), py::ssize_t(corners)});
  int* out = cells.mutable_data();
  int particles = 0;  // of the bodies before
  for (const auto& level : simulation.levels()) {
    const Body& body = level.body;
    body.for_each_piece([&](std::ptrdiff_t site) {
      for (const int c : body.corners()) *out++ = particles + body.particle(site + body.lattice().corner(c));
    });
    particles += int(body.particle_count());
  }
  return cells;
}

Modes rest_modes(const Simulation& simulation, int count) {
  const py::gil_scoped_release free;
  const Scene scene = unreduced(simulation.scene());
  check_one_body(scene, "modes()");
  const auto system = make_system<double>(scene.model, simulation.levels().front().body, scene.environment,
                                          scene.solve.threads);
  if (unknowns_of(*system).empty())
    throw InputError(scene.name + ": everything is held, so nothing can vibrate");
  Work work;
  Modes found = slowest_modes(*system, system->undeformed_state(), count, work);
  if (found.status != Status::ok)
    throw SimulationFailed(scene.name + ": modes ended with " + std::string(to_string(found.status)));
  return found;
}

py::dict modes(const Simulation& simulation, int count) {
  if (count < 1)
    throw InputError("count is " + std::to_string(count) + "; give a number of modes, 1 or more");
  const std::vector<Mode> found = rest_modes(simulation, count).modes;
  const auto n = py::ssize_t(particle_count(simulation));
  Doubles omega(py::ssize_t(found.size())), shapes({py::ssize_t(found.size()), n, py::ssize_t(3)});
  for (std::size_t m = 0; m < found.size(); ++m) {
    omega.mutable_data()[m] = found[m].omega;
    const Doubles shape = vectors_of(found[m].shape, simulation.levels().front().body.sites());
    std::copy_n(shape.data(), 3 * n, shapes.mutable_data() + 3 * n * py::ssize_t(m));
  }
  py::dict result;
  result["omega"] = omega;
  result["shapes"] = shapes;
  return result;
}

py::dict work(const Simulation& simulation) {
  const Work work = simulation.work();
  py::dict counts;
  counts["steps"] = work.steps;
  counts["force_evaluations"] = work.force_evaluations;
  counts["jacobians"] = work.jacobians;
  counts["factorisations"] = work.factorisations;
  counts["linear_solves"] = work.linear_solves;
  counts["products"] = work.products;
  return counts;
}

/// Name and summary of the members of a registry.
template <class Info>
py::dict summaries(const std::vector<Info>& all) {
  py::dict named;
  for (const Info& info : all) named[py::str(info.name)] = info.summary;
  return named;
}

void define_simulation(py::module_& module) {
  py::class_<Simulation>(module, "Simulation")
      .def(
          "advance", &Simulation::advance, py::arg("until"),
          R"(Takes the state to the time `until` [s]. Methods of fixed step take whole steps and stop at the one nearest to it.
Raises SimulationFailed; the state is then the last one computed. Other threads run meanwhile.)")
      .def("set_state", &Simulation::set_state, py::arg("t"), py::arg("x"), py::arg("v"),
           R"(Goes on from the time t [s], positions x (N, 3) [m] and velocities v (N, 3) [m/s].)")
      .def(
          "add_force", &Simulation::add_force, py::arg("force"),
          R"(Adds the forces (N, 3) [N] that force(t, x, v) returns for a time [s], positions [m] and velocities [m/s], both
(N, 3). It is called at every evaluation of forces: slow, for experiments. Implicit methods do not know its derivative.
If it raises, advance() does, and the state is the one before.)")
      .def(
          "set_integrator", &Simulation::set_integrator, py::arg("step"),
          R"(Replaces the scene's method by step(acceleration, t, x, v, dt), which returns positions (N, 3) [m] and velocities
(N, 3) [m/s] at t + dt; acceleration(t, x, v) returns (N, 3) [m/s^2]. Holds, contact and strikes act as they do for other
methods. Slow, for experiments.)")
      .def(
          "forces", &Simulation::forces,
          R"(Forces on the particles (N, 3) [N] of springs or elements, gravity, loads, penalties and functions; not those that
hold or stop particles.)")
      .def(
          "cell_stress", &Simulation::cell_stress, py::arg("damping") = true,
          R"(Cauchy stress of the cells (M, 3, 3) [Pa], in the order of `cells`, symmetric, positive in tension: the mean over each
cell of the stress of its material, by the virial of the forces in it (springs and dampers, volume force, guard against
folding; or finite elements) over its volume now, as far as it is filled. With damping=False of velocities zero: without
dampers. von Mises' stress is sqrt(3/2) of the norm of the deviator. Raises InputError for models that do not know it.)")
      .def(
          "measures", &measures,
          R"(The columns of series.csv at the present state: energies [J], volume ratios, momentum_x, y, z [kg m/s],
angular_momentum_x, y, z [kg m^2/s], max_speed [m/s], max_stretch, min_jacobian, t [s], and the forces [N] that holds and planes exert: hold_0_x, y, z,
..., plane_0_x, y, z, ..., and of several bodies body_0_x, ..., contact_depth, ... Those of planes that act by impulses are means over the last advance().)")
      .def(
          "energies", &energies,
          R"(Those of the measures that are energies [J]: kinetic, elastic, volume_energy, external_potential and their total.)")
      .def(
          "modes", &modes, py::arg("count") = 10,
          R"(The slowest free vibrations about rest: {"omega": (count,) [rad/s], ascending, "shapes": (count, N, 3) [kg^-1/2],
of which each has q.M q = 1}.)")
      .def_property_readonly(
          "name", [](const Simulation& s) { return s.scene().name; }, "Name of the scene.")
      .def_property_readonly(
          "warnings", [](const Simulation& s) { return s.scene().warnings; },
          "What to know of the scene before trusting its result.")
      .def_property_readonly(
          "duration", [](const Simulation& s) { return s.scene().solve.duration; },
          "How long the scene is to be simulated [s].")
      .def_property_readonly("time", &Simulation::time, "Time of the present state [s].")
      .def_property_readonly(
          "dt", &Simulation::dt,
          "Step [s], \"safe\" resolved; of methods that choose their steps the first, or 0.")
      .def_property_readonly("work", &work, "Counts of steps, force evaluations, solves and so on so far.")
      .def_property_readonly(
          "bodies", &bodies,
          "A list of (name or None, slice): which rows of arrays (N, 3) are the particles of each body.")
      .def_property_readonly("positions", &Simulation::positions, "Positions (N, 3) [m], a copy.")
      .def_property_readonly("velocities", &Simulation::velocities, "Velocities (N, 3) [m/s], a copy.")
      .def_property_readonly("rest_positions", &rest_positions, "Positions at rest (N, 3) [m].")
      .def_property_readonly("masses", &masses, "Masses (N,) [kg].")
      .def_property_readonly("cells", &cells,
                             "Particles at the corners of cells (M, 8), of a sheet's squares (M, 4) or of a "
                             "rope's links (M, 2); corner bx + 2 by + 4 bz is at the "
                             "upper end of axis x, y, z where bx, by, bz is 1.");
}

void define_functions(py::module_& module) {
  module.def(
      "load", &load, py::arg("scene"), py::arg("settings") = py::dict(),
      R"(A Simulation of a scene: a file (TOML), the name of one of scenes(), or a dict of the tables that such a file has, whose
relative paths begin at the working directory. `settings` change values, as in {"solve.dt": 1e-4, "hold.0.axes": "xy"}.)");
  module.def(
      "run_scene", &run_scene_with, py::arg("scene"), py::arg("settings") = py::dict(),
      R"(Simulates a scene to its end, as `mss run` does, and returns what that writes: {"series": {column: array}, "particles":
{column: array}, "warnings": sentences}. Scene and settings are those of load(). Raises SimulationFailed.)");
  module.def(
      "fit", &fit_with, py::arg("scene"), py::arg("data"), py::arg("parameters"),
      py::arg("settings") = py::dict(), py::arg("evaluations") = 30, py::arg("coarse") = py::dict(),
      R"(Finds the numbers of a scene that make its runs fit what was measured, as `mss fit` does. `data`: a file (TOML or CSV), or
a list of dicts with the keys of [[observation]] (experiments/fit/README.md). `parameters`: texts "KEY" or "KEY=LOW..HIGH",
or a dict {key: (low, high) or None}. `coarse`: settings that make a cheap twin of every run, as `--coarse` takes them. Returns
{"status": "converged" or why not, "values": {key: number}, "fit", "fit_data", "fit_correlation", "fit_steps": {column: array},
"chi2", "degrees_of_freedom", "evaluations", "scene": the scene with the values as a TOML text, "warnings": sentences}.)");
  constexpr const char* of_a_study =
      R"(Runs a study, as `mss STUDY` does, and returns its tables: {table: {column: array}}; numbers that do not exist are NaN,
and the column "status" says why. Options are those of the command: quick, cells, integrators, scenes, threads, model,
seed, processes, peers; each study takes some of them. Units are those of its CSV files (results/README.md).)";
  module.def("run_study", &run_study, py::arg("study"), py::arg("options") = py::dict(), of_a_study);
  module.def("run", &run_study, py::arg("study"), py::arg("options") = py::dict(),
             "What run_study() was called before; new scripts call that.");
  module.def(
      "scenes",
      [] {
        py::dict named;
        for (const auto& [name, description] : listed_scenes()) named[py::str(name)] = description;
        return named;
      },
      "The scenes that come with mss: {name: description}.");
  module.def(
      "integrators", [] { return summaries(integrators()); },
      "Methods for solve.integrator: {name: summary}.");
  module.def(
      "studies", [] { return summaries(experiments()); }, "What run_study() runs: {name: summary}.");
}

}  // namespace

}  // namespace mss::python

PYBIND11_MODULE(_mss, module) {
  using namespace mss::python;  // NOLINT(google-build-using-namespace)
  module.attr("__version__") = MSS_VERSION;
  pybind11::register_exception<mss::InputError>(module, "InputError", PyExc_ValueError);
  pybind11::register_exception<SimulationFailed>(module, "SimulationFailed", PyExc_RuntimeError);
  pybind11::dict renamed;
  for (const auto& [before, now] : mss::renamed_columns) renamed[pybind11::str(before)] = now;
  module.attr("_renamed_columns") = renamed;
  define_simulation(module);
  define_functions(module);
}
