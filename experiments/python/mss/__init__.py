"""Solids of masses and springs in real time: scenes as NumPy arrays, and every study as a dict of arrays.

    import mss
    cube = mss.load("cantilever", {"solve.dt": 1e-4})
    cube.advance(0.5)
    print(cube.positions[:, 2].min(), cube.energies()["total"])

Units are SI. Arrays of vectors are (N, 3), float64, a row for each of N particles in the order of particles.csv, and always
copies: changing one changes nothing else. Bad input raises InputError, a ValueError, with the sentence that the program
prints; a simulation that fails raises SimulationFailed, a RuntimeError.
"""

from ._mss import (
    InputError,
    Simulation,
    SimulationFailed,
    __version__,
    _renamed_columns,
    fit,
    integrators,
    load,
    run,
    run_scene,
    run_study,
    scenes,
    studies,
)


class _Columns(dict):
    """Numbers by column; a name that a column had before leads to it too."""

    def __missing__(self, name):
        return self[_renamed_columns[name]]

    def __contains__(self, name):
        return super().__contains__(_renamed_columns.get(name, name))

    def get(self, name, default=None):
        return super().get(_renamed_columns.get(name, name), default)


for _public in (InputError, Simulation, SimulationFailed):
    _public.__module__ = __name__

__all__ = [
    "InputError",
    "Simulation",
    "SimulationFailed",
    "fit",
    "integrators",
    "load",
    "run",
    "run_scene",
    "run_study",
    "scenes",
    "studies",
]
