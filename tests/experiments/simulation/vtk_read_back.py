#!/usr/bin/python3
"""Reads with VTK's own reader what `mss run --vtk` wrote, and compares it with particles.csv, series.csv and itself.

usage: vtk_read_back.py MSS EMPTY_DIRECTORY
"""

import csv
import json
import math
import subprocess
import sys
from pathlib import Path

try:
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOHDF import vtkHDFReader
except ImportError:
    print("skipped: python3-vtk9 is not installed")
    sys.exit(77)

CELL_SIZE = 0.25
REST_LENGTH = [CELL_SIZE * factor**0.5 for factor in (1, 2, 3)]  # of edges, face and body diagonals


def read(file):
    reader = vtkHDFReader()
    assert reader.CanReadFile(str(file)), f"{file} is not VTK's"
    reader.SetFileName(str(file))
    reader.Update()
    return reader.GetOutput()


def frames(directory, kind):
    listed = json.loads((directory / f"{kind}.vtkhdf.series").read_text())
    return [(entry["time"], read(directory / entry["name"])) for entry in listed["files"]]


def rows(file):
    with open(file, newline="", encoding="utf-8") as stream:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)]


def near(found, expected, what, within=1e-12):
    assert abs(found - expected) <= within * max(1, abs(expected)), f"{what}: {found}, not {expected}"


def measured(grid):
    """The grid with the length and volume of its cells as VTK has them."""
    sizes = vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    return sizes.GetOutput().GetCellData()


def check_cells(grid, particles, row):
    assert grid.GetNumberOfPoints() == len(particles)
    assert grid.GetNumberOfCells() == 8 * 2 * 2
    ratio = grid.GetCellData().GetArray("volume_ratio")
    volume = measured(grid).GetArray("Volume")
    jacobian = grid.GetCellData().GetArray("jacobian")
    total = 0
    for cell in range(grid.GetNumberOfCells()):
        assert grid.GetCellType(cell) == 12
        # VTK takes a cell with warped faces for five tetrahedra.
        near(ratio.GetValue(cell), volume.GetValue(cell) / CELL_SIZE**3, "volume of a cell", 2e-3)
        total += ratio.GetValue(cell)
    near(total / grid.GetNumberOfCells(), row["volume_ratio"], "volume")
    near(jacobian.GetRange()[0], row["min_jacobian"], "smallest Jacobian")


def stresses(grid):
    """Of each cell, by component as ParaView names them."""
    data = grid.GetCellData()
    stress, equivalent = data.GetArray("stress"), data.GetArray("von_mises")
    assert stress.GetNumberOfComponents() == 6 and equivalent.GetNumberOfComponents() == 1
    assert stress.GetNumberOfTuples() == equivalent.GetNumberOfTuples() == grid.GetNumberOfCells()
    cells = []
    for cell in range(grid.GetNumberOfCells()):
        s = dict(zip(("XX", "YY", "ZZ", "XY", "YZ", "XZ"), stress.GetTuple(cell)))
        squared = ((s["XX"] - s["YY"]) ** 2 + (s["YY"] - s["ZZ"]) ** 2 + (s["ZZ"] - s["XX"]) ** 2) / 2
        squared += 3 * (s["XY"] ** 2 + s["YZ"] ** 2 + s["XZ"] ** 2)
        near(equivalent.GetValue(cell), math.sqrt(squared), "stress of von Mises", 1e-9)
        cells.append(s)
    return cells


def check_forces(grid, row):
    data = grid.GetFieldData()
    names = {data.GetArrayName(i) for i in range(data.GetNumberOfArrays())}
    assert names == {"hold_0", "plane_0", "plane_1"}, names
    for name in names:
        assert data.GetArray(name).GetNumberOfTuples() == 1 and data.GetArray(name).GetNumberOfComponents() == 3
        for axis, force in zip("xyz", data.GetArray(name).GetTuple(0)):
            near(force, row[f"{name}_{axis}"], f"{name}_{axis}", 1e-9)


def check_springs(grid, row):
    stretch = grid.GetCellData().GetArray("stretch")
    kind = grid.GetCellData().GetArray("class")
    length = measured(grid).GetArray("Length")
    largest = 0
    for spring in range(grid.GetNumberOfCells()):
        assert grid.GetCellType(spring) == 3
        rest = REST_LENGTH[int(kind.GetValue(spring))]
        near(stretch.GetValue(spring), length.GetValue(spring) / rest - 1, "stretch")
        largest = max(largest, abs(stretch.GetValue(spring)))
    near(largest, row["max_stretch"], "largest stretch")


def check_points(cells, springs, particles):
    velocity = cells.GetPointData().GetArray("velocity")
    for i, particle in enumerate(particles):
        for axis, name in enumerate("xyz"):
            near(cells.GetPoint(i)[axis], particle[name], "position", 0)
            near(springs.GetPoint(i)[axis], particle[name], "position", 0)
            near(velocity.GetTuple(i)[axis], particle["v" + name], "velocity", 0)


def volume_inside(grid):
    """By the divergence theorem over triangles that face outward."""
    total = 0
    for cell in range(grid.GetNumberOfCells()):
        assert grid.GetCellType(cell) == 5
        a, b, c = (grid.GetPoint(grid.GetCell(cell).GetPointId(i)) for i in range(3))
        total += sum(a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3)) / 6
    return total


def check_surface(mss, directory):
    """A tetrahedron whose cells fly away."""
    directory.mkdir(exist_ok=True)
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    lines = ["v {} {} {}".format(*corner) for corner in corners]
    lines += ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    (directory / "corner.obj").write_text("\n".join(lines) + "\n")
    (directory / "corner.toml").write_text("""
[body]
mesh = "corner.obj"
cells_across = 6
[material]
density = 1000
young = 1e6
poisson = 0.3
[start]
velocity = [1, 2, 3]
[solve]
integrator = "verlet"
dt = 5e-4
duration = 0.1
every = 0.05
""")
    subprocess.run([mss, "run", str(directory / "corner.toml"), "--out", str(directory / "out"), "--vtk", "50"],
                   check=True)
    series = frames(directory / "out", "surface")
    assert len(series) == len(frames(directory / "out", "cells")) == 5
    for time, grid in series:
        assert grid.GetNumberOfPoints() == grid.GetNumberOfCells() == 4
        near(volume_inside(grid), 1 / 6, "volume inside the surface", 1e-9)
        velocity = grid.GetPointData().GetArray("velocity")
        for i in range(4):
            for axis in range(3):
                near(velocity.GetTuple(i)[axis], axis + 1, "velocity of a vertex", 1e-9)
        expected = [tuple(corner[axis] + (axis + 1) * time for axis in range(3)) for corner in corners]
        found = [grid.GetPoint(i) for i in range(4)]  # in the order of the reader
        for corner in expected:
            near(min(math.dist(corner, point) for point in found), 0, "distance of a vertex from its place", 1e-9)


FORCED = """
[body]
cells = [3, 2, 2]
cell_size = 0.1
[material]
density = 1000
young = 1e6
poisson = 0.3
[environment]
gravity = [0, 0, -9.81]
[[hold]]
box = [[0, 0, 0], [0, 1, 1]]
[[plane]]
point = [0, 0, 0]
normal = [0, 0, 1]
[[plane]]
point = [0.299, 0, 0]
normal = [-1, 0, 0]
contact = "penalty"
[solve]
integrator = "verlet"
dt = 1e-4
duration = 0.1
every = 0.01
"""


def check_forced(mss, directory):
    """Frames have the forces of rows, if they have their times: also means since the frame before."""
    directory.mkdir(exist_ok=True)
    (directory / "forced.toml").write_text(FORCED)
    subprocess.run([mss, "run", str(directory / "forced.toml"), "--out", str(directory / "out"), "--vtk", "100"],
                   check=True)
    series = rows(directory / "out" / "series.csv")
    cells = frames(directory / "out", "cells")
    assert len(cells) == len(series) == 11
    for row, (time, grid) in zip(series, cells):
        assert time == row["t"]
        check_forces(grid, row)
    for name in ("hold_0_x", "plane_0_z", "plane_1_x"):
        assert max(abs(row[name]) for row in series) > 1, name


CARRYING = """
[body]
cells = [4, 2, 2]
cell_size = 0.1
[material]
density = 1000
young = 1e9
poisson = 0.3
model = "MODEL"
[environment]
gravity = [2, -5, -10]
[[hold]]
box = [[0, 0, 0], [0, 1, 1]]
[solve]
integrator = "static"
duration = 1
every = 1
"""


def check_stress(mss, directory, model):
    """Sections of a beam carry the weight beyond them."""
    directory.mkdir(exist_ok=True)
    (directory / "beam.toml").write_text(CARRYING.replace("MODEL", model))
    subprocess.run([mss, "run", str(directory / "beam.toml"), "--out", str(directory / "out"), "--vtk", "1"],
                   check=True)
    grid = frames(directory / "out", "cells")[-1][1]
    particles = rows(directory / "out" / "particles.csv")
    cells, largest = stresses(grid), max(abs(s["XX"]) for s in stresses(grid))
    for layer in range(4):
        middle = 0.1 * layer + 0.05
        beyond = sum(particle["mass"] for particle in particles if particle["rest_x"] > middle)
        section = [s for i, s in enumerate(cells)
                   if abs(sum(grid.GetPoint(grid.GetCell(i).GetPointId(c))[0] for c in range(8)) / 8 - middle) < 0.01]
        assert len(section) == 4
        for component, gravity in (("XX", 2), ("XY", -5), ("XZ", -10)):
            near(0.01 * sum(s[component] for s in section), beyond * gravity, f"force through a section, {component}", 1e-3)
        assert abs(sum(s["YZ"] for s in section)) < 0.2 * largest


def run(mss, directory, *more):
    settings = ["body.cells=[8,2,2]", "body.cell_size=0.25", "environment.gravity=[0,0,-981]",
                "solve.dt=5e-4", "solve.duration=0.025", "solve.every=0.005"]
    sets = [word for setting in settings for word in ("--set", setting)]
    subprocess.run([mss, "run", "cantilever", "--out", str(directory), *sets, *more], check=True)


def check_flat(mss, directory):
    """A sheet of squares and a rope of links: as many as there are, as long as their springs, in no more numbers."""
    for scene, kind, count, corners in (("drum", 9, 32 * 32, 4), ("hanging_rope", 3, 64, 2)):
        out = directory / scene
        sets = [word for setting in ("solve.duration=0.02", "solve.every=0.01", "solve.dt=1e-5")
                for word in ("--set", setting)]
        if scene == "drum":
            sets += ["--set", "strike.0.at=0.0"]
        subprocess.run([mss, "run", scene, "--out", str(out), *sets, "--vtk", "1000"], check=True)
        particles = rows(out / "particles.csv")
        cells, springs = frames(out, "cells"), frames(out, "springs")
        assert len(cells) == 3
        grid = cells[-1][1]
        assert grid.GetNumberOfCells() == count and grid.GetNumberOfPoints() == len(particles)
        for cell in range(count):
            assert grid.GetCellType(cell) == kind and grid.GetCell(cell).GetNumberOfPoints() == corners
        assert grid.GetCellData().GetNumberOfArrays() == 0, "numbers of cells that there are not"
        check_points(grid, springs[-1][1], particles)
        size = measured(grid).GetArray("Area" if kind == 9 else "Length")
        rest = sum(size.GetValue(cell) for cell in range(count))
        near(rest / (0.4 * 0.4 if kind == 9 else 2), 1, "area or length", 0.05)


def main(mss, directory):
    watched, unwatched = directory / "watched", directory / "unwatched"
    run(mss, watched, "--vtk", "7")  # seven do not divide the ten steps of a row
    run(mss, unwatched)
    for name in ("series.csv", "particles.csv"):
        assert (watched / name).read_bytes() == (unwatched / name).read_bytes(), "frames change the motion"
    times = [time for time, _ in frames(watched, "cells")]
    assert len(times) == 8 and all(abs(time - 0.0035 * i) < 1e-12 for i, time in enumerate(times)), times

    run(mss, watched, "--vtk", "10")  # fewer frames, of which each is a row
    particles, series = rows(watched / "particles.csv"), rows(watched / "series.csv")
    cells, springs = frames(watched, "cells"), frames(watched, "springs")
    assert len(cells) == len(springs) == len(series) == 6
    assert len(list((watched / "vtk").iterdir())) == 2 * 6 + 1, "frames of the earlier run are left"
    for row, (time, grid), (spring_time, lines) in zip(series, cells, springs):
        assert time == spring_time == row["t"]
        check_cells(grid, particles, row)
        check_springs(lines, row)
    assert series[-1]["max_stretch"] > 1e-3, "nothing moved"
    check_points(cells[-1][1], springs[-1][1], particles)

    assert not (watched / "surface.vtkhdf.series").exists(), "a surface without a mesh"
    assert all(value == 0 for s in stresses(cells[0][1]) for value in s.values()), "stress at rest"
    assert max(abs(s["XX"]) for s in stresses(cells[-1][1])) > 1, "no stress"
    check_forced(mss, directory / "forced")
    for model in ("springs", "corotational"):
        check_stress(mss, directory / model, model)

    run(mss, watched)
    assert not (watched / "vtk").exists() and not (watched / "cells.vtkhdf.series").exists(), "an old series is left"

    run(mss, watched, "--vtk", "2", "--set", "solve.integrator=cvode_bdf")
    assert [time for time, _ in frames(watched, "cells")] == [0, 0.01, 0.02], "every second row"

    check_surface(mss, directory / "surface")
    check_flat(mss, directory / "flat")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
