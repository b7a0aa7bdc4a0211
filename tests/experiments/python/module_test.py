"""The Python module. Needs it on PYTHONPATH; the program mss is the first argument."""

import ast
import csv
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import numpy as np

import mss

PROGRAM = sys.argv.pop(1)

BLOCK = {
    "body": {"cells": [3, 2, 2], "cell_size": 0.1},
    "material": {"young": 1e5, "poisson": 0.3, "density": 1000},
    "environment": {"gravity": [0, 0, 0]},
    "solve": {"integrator": "verlet", "dt": 1e-4, "duration": 0.1},
}


def with_settings(**settings):
    """The block with other values: solve_dt=1 is solve.dt."""
    return mss.load(BLOCK, {key.replace("_", ".", 1): value for key, value in settings.items()})


def pushed(simulation):
    """The simulation with velocities that deform it."""
    x = simulation.positions
    simulation.set_state(0, x, 0.1 * x[:, [1, 2, 0]])
    return simulation


class Loading(unittest.TestCase):
    def test_a_dict_a_file_and_a_name_are_scenes(self):
        self.assertEqual(mss.load(BLOCK).positions.shape, (4 * 3 * 3, 3))
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "block.toml"
            file.write_text('[body]\ncells = [3, 2, 2]\ncell_size = 0.1\n[material]\nyoung = 1e5\npoisson = 0.3\ndensity = 1000\n')
            self.assertTrue(np.array_equal(mss.load(file).positions, mss.load(BLOCK).positions))
            self.assertEqual(mss.load(file).name, "block")
        self.assertIn("cantilever", mss.scenes())
        self.assertEqual(mss.load("cantilever", {"solve.dt": 1e-5}).dt, 1e-5)

    def test_tables_in_arrays_and_numpy_values(self):
        held = dict(BLOCK, hold=[{"box": [np.zeros(3), (0, 0.2, 0.2)]}], environment={"gravity": np.array([0, 0, -9.81])})
        simulation = mss.load(held, {"hold.0.axes": "xyz", "solve.dt": np.float64(5e-5)})
        simulation.advance(0.01)
        fixed = simulation.rest_positions[:, 0] == 0
        self.assertEqual(fixed.sum(), 9)
        self.assertTrue(np.array_equal(simulation.positions[fixed], simulation.rest_positions[fixed]))
        self.assertTrue((simulation.velocities[~fixed, 2] < 0).all())

    def test_bad_input_is_a_value_error_with_the_programs_sentence(self):
        with self.assertRaises(ValueError) as error:
            mss.load("cantilever", {"material.density": -5})
        run = subprocess.run([PROGRAM, "run", "cantilever", "--set", "material.density=-5"], capture_output=True, text=True)
        self.assertEqual(run.returncode, 2)
        sentence = run.stderr.strip().replace("mss: --set material.density=-5:", 'settings["material.density"]:')
        self.assertEqual(str(error.exception), sentence)
        self.assertIn("is not a density; give a positive number", str(error.exception))
        for scene, sentence in [
            ("cantilver", "did you mean 'cantilever'"),
            (dict(BLOCK, solve={"integrator": "verlett"}), "verlet"),
            (dict(BLOCK, material={"young": object()}), "material.young"),
            (dict(BLOCK, body={"cells": [3, 2, 2], "cell_sizes": 1}), "body.cell_size"),
        ]:
            with self.assertRaisesRegex(mss.InputError, sentence):
                mss.load(scene)


class States(unittest.TestCase):
    def test_set_and_read_back_is_equal_bit_for_bit(self):
        random = np.random.default_rng(1)
        simulation = mss.load(dict(BLOCK, hold=[{"box": [[0, 0, 0], [0, 0.2, 0.2]]}]))
        x, v = random.normal(size=(2, 36, 3)) * 10.0 ** random.integers(-30, 30, size=(2, 36, 3))
        simulation.set_state(0.125, x, v)
        self.assertEqual(simulation.time, 0.125)
        self.assertEqual(simulation.positions.tobytes(), x.tobytes())
        self.assertEqual(simulation.velocities.tobytes(), v.tobytes())

    def test_arrays_are_copies(self):
        simulation = mss.load(BLOCK)
        simulation.positions[:] = 0
        x = simulation.positions
        x += 1
        self.assertTrue(np.array_equal(simulation.positions, simulation.rest_positions))

    def test_single_precision_is_read_as_doubles(self):
        simulation = pushed(with_settings(solve_precision="single"))
        simulation.advance(0.01)
        self.assertEqual(simulation.positions.dtype, np.float64)
        self.assertTrue(np.array_equal(simulation.positions, simulation.positions.astype(np.float32)))

    def test_states_of_another_shape_or_without_values_are_refused(self):
        simulation = mss.load(BLOCK)
        x = simulation.positions
        with self.assertRaisesRegex(ValueError, r"positions have the shape \(35, 3\); give \(36, 3\)"):
            simulation.set_state(0, x[1:], x)
        with self.assertRaisesRegex(ValueError, r"velocities have the shape \(108\); give \(36, 3\)"):
            simulation.set_state(0, x, x.ravel())
        with self.assertRaisesRegex(ValueError, "not finite"):
            simulation.set_state(0, x * np.nan, x)
        with self.assertRaises(TypeError):
            simulation.set_state(0, x, "fast")
        self.assertTrue(np.array_equal(simulation.positions, x))

    def test_continuing_from_a_state_gives_the_same_bits(self):
        straight, resumed = pushed(mss.load(BLOCK)), pushed(mss.load(BLOCK))
        straight.advance(0.02)
        resumed.advance(0.01)
        other = mss.load(BLOCK)
        other.set_state(resumed.time, resumed.positions, resumed.velocities)
        other.advance(0.02)
        self.assertTrue(np.array_equal(other.positions, straight.positions))


class Motion(unittest.TestCase):
    def test_the_same_bits_as_the_program(self):
        settings = {"solve.duration": 0.05, "solve.every": 0.01}
        simulation = mss.load("cantilever", settings)
        rows = []
        for row in range(1, 6):
            simulation.advance(row * 0.01)
            rows.append(simulation.measures())
        with tempfile.TemporaryDirectory() as out:
            options = [f"--set={key}={value}" for key, value in settings.items()]
            subprocess.run([PROGRAM, "run", "cantilever", *options, "--out", out], check=True, capture_output=True)
            particles = np.genfromtxt(Path(out) / "particles.csv", delimiter=",", names=True)
            series = list(csv.DictReader((Path(out) / "series.csv").read_text().splitlines()))
        x = np.stack([particles[name] for name in "xyz"], axis=1)
        v = np.stack([particles["v" + name] for name in "xyz"], axis=1)
        self.assertTrue(np.array_equal(simulation.positions, x))
        self.assertTrue(np.array_equal(simulation.velocities, v))
        self.assertTrue(np.array_equal(simulation.masses, particles["mass"]))
        self.assertEqual(len(series), 6)
        for row, expected in zip(rows, series[1:]):
            self.assertEqual(row, {name: float(value) for name, value in expected.items()})

    def test_holds_and_planes_carry_the_weight(self):
        held = {"box": [[0, 0, 0], [0, 0.2, 0.2]]}
        floor = {"point": [0, 0, 0], "normal": [0, 0, 1]}
        for action in ({"hold": [held]}, {"plane": [floor]}):
            simulation = mss.load(dict(BLOCK, **action), {
                "environment.gravity": [0, 0, -9.81], "solve.integrator": "backward_euler", "solve.dt": 0.02})
            simulation.advance(2)
            simulation.advance(3)
            force = simulation.measures()["hold_0_z" if "hold" in action else "plane_0_z"]
            self.assertAlmostEqual(force, 9.81 * simulation.masses.sum(), delta=1e-4 * force)

    def test_forces_are_masses_times_accelerations(self):
        simulation = with_settings(environment_gravity=[0, 0, -9.81])
        weight = simulation.masses[:, None] * [0, 0, -9.81]
        np.testing.assert_allclose(simulation.forces(), weight, rtol=1e-12, atol=1e-12)
        self.assertAlmostEqual(simulation.masses.sum(), 1000 * 0.3 * 0.2 * 0.2, delta=1e-12)

    def test_energies_are_those_of_the_state(self):
        simulation = pushed(mss.load(BLOCK))
        energies = simulation.energies()
        kinetic = 0.5 * (simulation.masses[:, None] * simulation.velocities**2).sum()
        self.assertAlmostEqual(energies["kinetic"], kinetic, delta=1e-12 * kinetic)
        simulation.advance(0.05)
        self.assertAlmostEqual(simulation.energies()["total"], energies["total"], delta=1e-3 * energies["total"])
        self.assertEqual(simulation.energies()["total"], simulation.measures()["total"])

    def test_columns_have_the_names_they_had_before_too(self):
        simulation = pushed(mss.load(BLOCK, {"environment.gravity": [0, 0, -9.81]}))
        measures, energies = simulation.measures(), simulation.energies()
        for axis in "xyz":
            self.assertEqual(measures["spin_" + axis], measures["angular_momentum_" + axis])
        self.assertNotEqual(measures["spin_x"], 0)
        self.assertIn("spin_x", measures)
        self.assertEqual(measures.get("spin_x", 0), measures["angular_momentum_x"])
        self.assertIsNone(measures.get("no_column"))
        self.assertEqual(energies["gravitational"], energies["external_potential"])
        self.assertNotIn("gravitational", list(energies))
        with self.assertRaises(KeyError):
            measures["spin"]

    def test_modes_oscillate_at_their_frequencies(self):
        simulation = mss.load(BLOCK)
        modes = simulation.modes(8)
        omega, shapes = modes["omega"], modes["shapes"]
        self.assertEqual(shapes.shape, (8, 36, 3))
        self.assertTrue((omega[:6] < 1e-3 * omega[6]).all())  # rigid
        products = np.einsum("ank,n,bnk->ab", shapes, simulation.masses, shapes)
        np.testing.assert_allclose(products, np.eye(8), atol=1e-8)
        # x = small q cos(omega t): a quarter of a period later there is velocity only.
        size = 1e-6
        simulation = with_settings(solve_dt=np.pi / 2 / omega[6] / 1000)
        simulation.set_state(0, simulation.positions + size * shapes[6], np.zeros((36, 3)))
        simulation.advance(np.pi / 2 / omega[6])
        np.testing.assert_allclose(simulation.velocities, -size * omega[6] * shapes[6], atol=1e-4 * size * omega[6])

    def test_cells_have_the_volume_of_cubes(self):
        simulation = mss.load(BLOCK)
        corners = simulation.positions[simulation.cells]
        self.assertEqual(corners.shape, (12, 8, 3))
        for axis in range(3):
            np.testing.assert_allclose(corners[:, 1 << axis] - corners[:, 0], np.tile(0.1 * np.eye(3)[axis], (12, 1)), atol=1e-15)

    def test_sheets_and_ropes_have_squares_and_links(self):
        for cells, count, corners in (([3, 2, 0], 6, 4), ([0, 5, 0], 5, 2)):
            flat = mss.load(dict(BLOCK, body={"cells": cells, "cell_size": 0.1, "thickness": 0.01}))
            self.assertEqual(flat.cells.shape, (count, corners))
            lengths = np.linalg.norm(flat.positions[flat.cells[:, 1]] - flat.positions[flat.cells[:, 0]], axis=1)
            np.testing.assert_allclose(lengths, 0.1, rtol=1e-12)
            self.assertEqual(flat.energies()["volume_energy"], 0)

    def test_several_bodies_are_parts_of_arrays(self):
        scene = dict(
            BLOCK,
            body=[dict(BLOCK["body"], name="lower"), {"cells": [2, 2, 2], "cell_size": 0.1, "origin": [0, 0, 0.2]}],
            contact={"bodies": True},
        )
        simulation = mss.load(scene)
        self.assertEqual(simulation.bodies, [("lower", slice(0, 36, 1)), (None, slice(36, 63, 1))])
        upper = simulation.bodies[1][1]
        self.assertEqual(simulation.rest_positions[upper, 2].min(), 0.2)
        self.assertEqual(simulation.cells.shape, (12 + 8, 8))
        self.assertGreaterEqual(simulation.cells[12:].min(), 36)
        v = np.zeros((63, 3))
        v[upper, 2] = -0.5
        simulation.set_state(0, simulation.positions, v)
        simulation.advance(0.01)
        self.assertGreater(simulation.measures()["contact_force"], 0)
        momentum = simulation.masses @ simulation.velocities
        self.assertTrue(np.allclose(momentum, [0, 0, -0.5 * simulation.masses[upper].sum()], atol=1e-12))
        with self.assertRaisesRegex(ValueError, "is for one body"):
            simulation.modes()

    def test_stress_of_cells_is_hookes_and_kelvin_and_voigts(self):
        lame = 1e5 * 0.3 / (1.3 * 0.4), 1e5 / 2.6
        strain = 1e-6 * np.array([[1, 0.5, -0.2], [0.5, -0.7, 0.4], [-0.2, 0.4, 0.9]])
        rate = np.array([[0.3, 0.4, 0], [0.4, -0.5, 0.5], [0, 0.5, 0.9]])
        viscous = 2 * 40 * rate + 40 * np.trace(rate) * np.eye(3)
        elastic = 2 * lame[1] * strain + lame[0] * np.trace(strain) * np.eye(3)
        for model in ("springs", "corotational"):
            simulation = mss.load(dict(BLOCK, damping={"viscosity": 40}), {"material.model": model})
            np.testing.assert_allclose(simulation.cell_stress(), np.zeros((12, 3, 3)), atol=1e-9)
            x = simulation.rest_positions
            simulation.set_state(0, x + x @ strain, x @ rate)
            for damping, expected in ((False, elastic), (True, elastic + viscous)):
                stress = simulation.cell_stress(damping=damping)
                np.testing.assert_allclose(stress, np.tile(expected, (12, 1, 1)), atol=1e-4 * np.linalg.norm(expected))
                self.assertTrue(np.array_equal(stress, stress.transpose(0, 2, 1)))

    def test_a_failed_simulation_is_a_runtime_error_that_says_how(self):
        simulation = pushed(with_settings(solve_integrator="explicit_euler", solve_dt=0.1, solve_duration=1000))
        with self.assertRaisesRegex(RuntimeError, "scene: non_finite after [0-9]+ steps.*; no step of explicit_euler is sure"):
            simulation.advance(1000)
        with self.assertRaisesRegex(ValueError, "not ahead"):
            pushed(mss.load(BLOCK)).advance(-1)

    def test_other_threads_run_while_it_steps(self):
        def times_refused(steps):
            simulation = mss.load(BLOCK, {"body.cells": [20, 20, 20], "solve.threads": 1})
            done = threading.Event()
            stepping = threading.Thread(target=lambda: (simulation.advance(steps * simulation.dt), done.set()))
            stepping.start()
            refused = 0
            while not done.is_set():
                try:
                    simulation.positions
                except RuntimeError:
                    refused += 1
                time.sleep(1e-3)
            stepping.join()
            return refused

        # Of a few steps a busy machine might give this thread no moment.
        self.assertTrue(any(times_refused(steps) > 5 for steps in (200, 2000, 20000)))


class Functions(unittest.TestCase):
    def test_a_force_accelerates_the_centre_of_mass(self):
        for method in ["verlet", "rk4", "backward_euler", "cvode_bdf"]:
            simulation = with_settings(solve_integrator=method)
            masses = simulation.masses
            simulation.add_force(lambda t, x, v: masses[:, None] * [3.0, 0, 0])
            simulation.advance(0.02)
            self.assertAlmostEqual(simulation.measures()["momentum_x"], 0.06 * masses.sum(), delta=1e-9)
            np.testing.assert_allclose(simulation.forces().sum(axis=0), [3 * masses.sum(), 0, 0], atol=1e-6)

    def test_a_force_sees_the_state(self):
        simulation = pushed(mss.load(BLOCK))
        seen = []
        simulation.add_force(lambda t, x, v: seen.append((t, x, v)) or np.zeros_like(x))
        simulation.advance(3e-4)
        self.assertEqual(len(seen), simulation.work["force_evaluations"])
        self.assertTrue(np.array_equal(seen[0][1], simulation.rest_positions))
        plain = pushed(mss.load(BLOCK))
        plain.advance(3e-4)
        np.testing.assert_allclose(simulation.positions, plain.positions, atol=1e-15)

    def test_an_error_in_a_force_passes_through_and_leaves_the_state(self):
        for method in ["verlet", "backward_euler", "cvode_bdf"]:
            simulation = pushed(with_settings(solve_integrator=method))
            simulation.advance(0.005)
            time_before, before = simulation.time, simulation.positions

            def failing(t, x, v):
                raise ZeroDivisionError("mine")

            simulation.add_force(failing)
            with self.assertRaisesRegex(ZeroDivisionError, "mine"):
                simulation.advance(0.01)
            self.assertEqual(simulation.time, time_before)
            self.assertTrue(np.array_equal(simulation.positions, before))
        simulation = mss.load(BLOCK)
        simulation.add_force(lambda t, x, v: np.zeros(3))
        with self.assertRaisesRegex(ValueError, r"forces of a Python function have the shape \(3\)"):
            simulation.advance(0.01)

    def test_an_integrator_in_python_moves_as_the_same_one_in_the_core(self):
        def semi_implicit_euler(acceleration, t, x, v, dt):
            v = v + dt * acceleration(t, x, v)
            return x + dt * v, v

        held = dict(BLOCK, hold=[{"box": [[0, 0, 0], [0, 0.2, 0.2]]}], environment={"gravity": [0, 0, -9.81]})
        core = mss.load(held, {"solve.integrator": "semi_implicit_euler"})
        python = mss.load(held)
        python.set_integrator(semi_implicit_euler)
        core.advance(0.02)
        python.advance(0.02)
        self.assertEqual(python.work["steps"], 200)
        self.assertEqual(python.work["force_evaluations"], 200)
        np.testing.assert_allclose(python.positions, core.positions, atol=1e-13)

    def test_an_integrator_that_raises_or_returns_nonsense(self):
        simulation = mss.load(BLOCK)
        simulation.set_integrator(lambda acceleration, t, x, v, dt: (x, v[1:]))
        with self.assertRaisesRegex(ValueError, r"velocities that a Python method returns have the shape \(35, 3\)"):
            simulation.advance(0.01)
        self.assertEqual(simulation.time, 0)
        simulation.set_integrator(lambda acceleration, t, x, v, dt: (x * np.nan, v))
        with self.assertRaisesRegex(mss.SimulationFailed, "non_finite"):
            simulation.advance(0.01)
        kept = []
        simulation = mss.load(BLOCK)
        simulation.set_integrator(lambda acceleration, t, x, v, dt: (kept.append(acceleration) or x, v))
        simulation.advance(1e-4)
        with self.assertRaisesRegex(ValueError, "during the step"):
            kept[0](0, simulation.positions, simulation.velocities)

    def test_functions_are_refused_where_they_would_do_nothing(self):
        with self.assertRaisesRegex(ValueError, "single precision"):
            with_settings(solve_precision="single").add_force(lambda t, x, v: x)
        with self.assertRaisesRegex(ValueError, "sleep"):
            with_settings(solve_sleep=1e-3).add_force(lambda t, x, v: x)
        with self.assertRaisesRegex(ValueError, "its own steps"):
            mss.load(dict(BLOCK, solve={"integrator": "cvode_bdf"})).set_integrator(lambda a, t, x, v, dt: (x, v))


class Studies(unittest.TestCase):
    def test_a_study_gives_the_table_that_the_program_writes(self):
        tables = mss.run_study("volume", {"quick": True, "cells": [2], "integrators": ["rk4"]})
        with tempfile.TemporaryDirectory() as out:
            run = [PROGRAM, "volume", "--quick", "--cells", "2", "--integrators", "rk4", "--out", out]
            subprocess.run(run, check=True, capture_output=True)
            rows = list(csv.DictReader((Path(out) / "volume.csv").read_text().splitlines()))
        volume = tables["volume"]
        self.assertEqual(list(volume), list(rows[0]))
        self.assertEqual(volume["cells"].dtype, np.int64)
        self.assertEqual(volume["model"].tolist(), [row["model"] for row in rows])
        for name in ["drift", "predicted"]:
            expected = [float(row[name] or "nan") for row in rows]
            np.testing.assert_array_equal(volume[name], expected)

    def test_unknown_studies_and_options_are_refused(self):
        with self.assertRaisesRegex(ValueError, "volume"):
            mss.run_study("volumes")
        with self.assertRaisesRegex(ValueError, "volume has no option 'seed'; it takes cells, integrators, processes, quick"):
            mss.run_study("volume", {"seed": 1})
        with self.assertRaisesRegex(ValueError, "cells"):
            mss.run_study("volume", {"cells": [0]})
        self.assertIn("atlas", mss.studies())
        self.assertIn("verlet", mss.integrators())


    def test_run_is_what_run_study_was_called_before(self):
        tables, before = (run("relaxation", {"quick": True}) for run in (mss.run_study, mss.run))
        self.assertEqual(list(tables), list(before))
        for name, table in tables.items():
            for column in table:
                np.testing.assert_array_equal(table[column], before[name][column])


class Scenes(unittest.TestCase):
    def test_a_scene_gives_the_tables_that_the_program_writes(self):
        settings = {"solve.duration": 0.05, "solve.every": 0.01}
        found = mss.run_scene("cantilever", settings)
        with tempfile.TemporaryDirectory() as out:
            options = [f"--set={key}={value}" for key, value in settings.items()]
            subprocess.run([PROGRAM, "run", "cantilever", *options, "--out", out], check=True, capture_output=True)
            for table in ("series", "particles"):
                rows = list(csv.DictReader((Path(out) / f"{table}.csv").read_text().splitlines()))
                self.assertEqual(list(found[table]), list(rows[0]))
                for name, column in found[table].items():
                    np.testing.assert_array_equal(column, [float(row[name]) for row in rows])
        self.assertIsInstance(found["warnings"], list)

    def test_scenes_that_fail_or_cannot_be_run(self):
        failing = {"solve.integrator": "explicit_euler", "solve.dt": 0.1, "solve.duration": 1000, "start.spin": [0, 0, 9]}
        with self.assertRaisesRegex(mss.SimulationFailed, "scene: non_finite after [0-9]+ steps; .*explicit_euler"):
            mss.run_scene(BLOCK, failing)
        with self.assertRaisesRegex(ValueError, r'settings\["material.density"\]: material.density = -5'):
            mss.run_scene("cantilever", {"material.density": -5})


class Surface(unittest.TestCase):
    def test_a_fit_finds_the_modulus_of_a_frequency(self):
        omega = mss.load(BLOCK, {"material.young": 2e5}).modes(7)["omega"][6]
        data = [{"kind": "frequency", "mode": 7, "value": omega / (2 * np.pi), "uncertainty": 0.01}]
        found = mss.fit(BLOCK, data, {"material.young": (1e4, 1e6)})
        self.assertEqual(found["status"], "converged")
        self.assertAlmostEqual(found["values"]["material.young"] / 2e5, 1, places=5)
        self.assertEqual(list(found["fit"]["parameter"]), ["material.young"])
        self.assertAlmostEqual(found["fit_data"]["fitted"][0], omega / (2 * np.pi), places=3)
        self.assertIn("[material]", found["scene"])
        self.assertEqual(found["degrees_of_freedom"], 0)

    def test_data_and_parameters_of_a_fit_that_cannot_be_are_refused(self):
        frequency = {"kind": "frequency", "mode": 7, "value": 10.0}
        with self.assertRaisesRegex(mss.InputError, "cannot determine 2 parameters"):
            mss.fit(BLOCK, [frequency], ["material.young", "material.density"])
        with self.assertRaisesRegex(mss.InputError, "did you mean 'material.young'"):
            mss.fit(BLOCK, [frequency], ["material.yung"])
        with self.assertRaisesRegex(mss.InputError, "is not a known key"):
            mss.fit(BLOCK, [dict(frequency, valu=1)], ["material.young"])
        with self.assertRaisesRegex(mss.InputError, r'settings\["material.density"\]'):
            mss.fit(BLOCK, [frequency], ["material.young"], {"material.density": -5})

    def test_stubs_and_docstrings_are_of_what_there_is(self):
        stubs = ast.parse((Path(mss.__file__).parent / "__init__.pyi").read_text())
        functions = {node.name for node in stubs.body if isinstance(node, ast.FunctionDef)}
        self.assertEqual(functions, {name for name in mss.__all__ if not isinstance(getattr(mss, name), type)})
        simulation = next(node for node in stubs.body if isinstance(node, ast.ClassDef) and node.name == "Simulation")
        members = {node.name for node in simulation.body if isinstance(node, ast.FunctionDef)}
        self.assertEqual(members, {name for name in vars(mss.Simulation) if not name.startswith("_")})
        for name in members:
            self.assertTrue(getattr(mss.Simulation, name).__doc__.strip(), name)
        for name in functions:
            self.assertIn("\n\n", getattr(mss, name).__doc__, name)  # beneath the signature


if __name__ == "__main__":
    unittest.main()
