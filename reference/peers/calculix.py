#!/usr/bin/env python3
"""CalculiX (Debian's calculix-ccx, GPL): implicit dynamics of finite elements, by HHT's method.

    reference/peers/calculix.py EXPORT_DIR RESULT_DIR --step 0.0166667 --element C3D8I

Reads what `mss peer export` wrote, writes a deck and runs ccx on it, and writes what `mss peer score` reads from what ccx
printed; experiments/peer/README.md describes both. Elements: C3D8I, C3D8, C3D20 (hexahedra, the last with a node amid
every edge) or C3D4 (tetrahedra). A scene that has planes or loads is refused. The CPU time is that of all of
ccx, reading the deck included.
"""
import argparse
import csv
import itertools
import json
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import time

ORDER = (0, 1, 3, 2, 4, 5, 7, 6)  # of corners q = bits x, y, z, as CalculiX goes round a hexahedron
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))  # of C3D20


class InputError(Exception):
    """What a user can mend: status 2."""


class MissingEngine(Exception):
    """Status 3."""


class EngineFailed(Exception):
    """Status 1."""


def version():
    if shutil.which("ccx") is None:
        raise MissingEngine("CalculiX is not installed; Debian's package is calculix-ccx")
    words = subprocess.run(["ccx", "-v"], capture_output=True, text=True, check=False).stdout.split()
    return words[-1] if words else "of unknown version"


def read_table(file):
    try:
        with open(file, newline="", encoding="utf-8") as stream:
            return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)]
    except OSError:
        raise InputError(f'{file}: cannot be read; "mss peer export SCENE --out DIR" writes it') from None
    except (TypeError, ValueError):
        raise InputError(f"{file}: numbers are expected") from None


def read_scene(file):
    try:
        scene = json.loads(file.read_text(encoding="utf-8"))
    except OSError:
        raise InputError(f'{file}: cannot be read; "mss peer export SCENE --out DIR" writes it') from None
    except ValueError:
        raise InputError(f"{file}: is not JSON") from None
    if not isinstance(scene, dict) or scene.get("format") != "mss-peer-1":
        raise InputError(f'{file}: format: "mss-peer-1" is expected')
    for key in ("gravity", "density", "young", "poisson", "damping", "planes", "loads", "sample_times"):
        if key not in scene:
            raise InputError(f"{file}: has no key {key}")
    return scene


def is_damped(damping):
    return damping["law"] == "thesis" or damping.get("ratio", 0) > 0 or damping.get("viscosity", 0) > 0


class Export:
    def __init__(self, folder):
        self.scene = read_scene(folder / "scene.json")
        if self.scene["loads"]:
            raise InputError("the scene has loads, which this adapter does not give to CalculiX")
        if self.scene["planes"]:
            raise InputError("planes are not given to CalculiX, so no scene that has one")
        if self.scene["young"] is None or self.scene["poisson"] is None:
            raise InputError("this scene has no single E and nu, which CalculiX needs")
        self.particles = read_table(folder / "particles.csv")
        self.hexahedra = [[int(row[f"n{q}"]) for q in ORDER] for row in read_table(folder / "hexahedra.csv")]
        self.tetrahedra = [[int(row[c]) for c in "abcd"] for row in read_table(folder / "tetrahedra.csv")]

    def mesh(self, element):
        """Nodes, of which the first are the particles, and elements by the indices of their nodes."""
        if element == "C3D4":
            return self.particles, self.tetrahedra
        if element != "C3D20":
            return self.particles, self.hexahedra
        nodes, number, elements = list(self.particles), {}, []
        for corners in self.hexahedra:
            middles = [tuple(sorted((corners[a], corners[b]))) for a, b in EDGES]
            for a, b in middles:
                if (a, b) not in number:
                    number[a, b] = len(nodes)
                    nodes.append({key: (nodes[a][key] + nodes[b][key]) / 2 for key in nodes[a]})
            elements.append(corners + [number[ends] for ends in middles])
        for node in nodes:
            node["held"] = node["held"] == 1  # between a held particle and a free one: free
        return nodes, elements


def listed(values):
    """Numbers of at most twenty characters, as CalculiX reads no more."""
    return ", ".join(f"{value:.12g}" for value in values)


def numbered(lines):
    return [f"{n}, " + listed(values) for n, values in lines]


def deck(export, options):
    """The input file. Particle `id` is node id + 1."""
    scene = export.scene
    nodes, elements = export.mesh(options.element)
    held = [n for n, p in enumerate(nodes, 1) if p["held"]]
    lines = ["*NODE"]
    lines += numbered((n, (p["x"], p["y"], p["z"])) for n, p in enumerate(nodes, 1))
    lines += ["*NSET, NSET=PARTICLES, GENERATE", f"1, {len(export.particles)}, 1"]
    lines += [f"*ELEMENT, TYPE={options.element}, ELSET=BODY"]
    for n, corners in enumerate(elements, 1):  # at most sixteen numbers a line
        numbers = [str(n), *(str(a + 1) for a in corners)]
        lines += [", ".join(numbers[:12]) + ("," if len(numbers) > 12 else ""), *filter(None, [", ".join(numbers[12:])])]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", listed((scene["young"], scene["poisson"])), "*DENSITY", listed((scene["density"],)),
              "*SOLID SECTION, ELSET=BODY, MATERIAL=M"]
    if held:
        lines += ["*NSET, NSET=HELD", *(f"{n}," for n in held), "*BOUNDARY", "HELD, 1, 3"]
    for kind, key in (("DISPLACEMENT", "start_{}"), ("VELOCITY", "start_v{}")):
        values = [(n, axis, p[key.format(c)] - (p[c] if kind == "DISPLACEMENT" else 0))
                  for n, p in enumerate(nodes, 1) for axis, c in enumerate("xyz", 1)]
        values = [f"{n}, {axis}, {listed((value,))}" for n, axis, value in values if abs(value) > 1e-12]
        if values:
            lines += [f"*INITIAL CONDITIONS, TYPE={kind}", *values]
    gravity = sum(g * g for g in scene["gravity"]) ** 0.5
    load = []
    if gravity > 0:
        load = ["*DLOAD", "BODY, GRAV, " + listed((gravity, *(g / gravity for g in scene["gravity"])))]
    analysis = ["*DYNAMIC, DIRECT, ALPHA=0.", listed((options.step, scene["sample_times"][-1]))]
    if options.rest:
        analysis = ["*STATIC", "0.25, 1."]
    lines += ["*STEP, NLGEOM, INC=1000000", *analysis, *load,
              f"*NODE PRINT, NSET=PARTICLES, FREQUENCY={1 if options.rest else options.stride}", "U" if options.rest else "U, V", "*END STEP"]
    return "\n".join(lines) + "\n"


def read_printed(file, count):
    """[(t, displacements, velocities)] as ccx printed them."""
    found, times = {}, []
    with open(file, encoding="utf-8") as stream:
        rows = None
        for line in stream:
            words = line.split()
            if "and time" in line:
                kind, t = words[0], float(words[-1])
                rows = found.setdefault(t, {}).setdefault(kind, [(0.0, 0.0, 0.0)] * count)
                if t not in times:
                    times.append(t)
            elif rows is not None and len(words) == 4:
                rows[int(words[0]) - 1] = tuple(map(float, words[1:]))
    return [(t, found[t]["displacements"], found[t].get("velocities")) for t in times]


def run_ccx(folder, export, options):
    """What ccx printed, its CPU and wall time [s], and a status."""
    (folder / "deck.inp").write_text(deck(export, options), encoding="utf-8")
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    ended = subprocess.run(["ccx", "deck"], cwd=folder, capture_output=True, text=True, check=False,
                           env={**os.environ, "OMP_NUM_THREADS": "1"})
    after, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic() - start
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    printed = read_printed(folder / "deck.dat", len(export.particles)) if (folder / "deck.dat").exists() else []
    status = "ok" if ended.returncode == 0 and "*ERROR" not in ended.stdout else "ccx ended with an error"
    for suffix in ("cvg", "sta", "12d", "frd", "dat"):
        (folder / f"deck.{suffix}").unlink(missing_ok=True)
    return printed, cpu, wall, status


def samples_of(export, printed, options):
    """Rows of samples.csv: at rest the last of what was printed, at every time; else one print a sample time."""
    times = export.scene["sample_times"]
    start = [tuple(p[f"start_{c}"] for c in "xyz") for p in export.particles]
    speed = [tuple(p[f"start_v{c}"] for c in "xyz") for p in export.particles]
    rows = []
    if not options.rest:
        rows += [(times[0], n, *start[n], *speed[n]) for n in range(len(start))]
    states = itertools.repeat(printed[-1]) if options.rest else printed
    for t, (_, u, v) in zip(times if options.rest else times[1:], states):
        for n, p in enumerate(export.particles):
            x = [p[c] + u[n][axis] for axis, c in enumerate("xyz")]
            rows.append((t, n, *x, *(v[n] if v else (0.0, 0.0, 0.0))))
    return rows


def write(file, text):
    part = file.with_name(file.name + ".part")
    part.write_text(text, encoding="utf-8")
    part.rename(file)


def solve(export, options):
    options.stride = round((export.scene["sample_times"][1] - export.scene["sample_times"][0]) / options.step)
    spacing = export.scene["sample_times"][1] - export.scene["sample_times"][0]
    if options.stride < 1 or abs(options.stride * options.step - spacing) > 1e-5 * spacing:
        raise InputError(f"--step: {options.step:g} s does not divide the time between samples, {spacing:g} s")
    options.step = spacing / options.stride
    name = version()
    if is_damped(export.scene["damping"]):
        print("calculix.py: warning: the scene is damped, and this adapter does not give CalculiX the damping", file=sys.stderr)
    folder = options.result
    folder.mkdir(parents=True, exist_ok=True)
    printed, cpu, wall, status = run_ccx(folder, export, options)
    (folder / "samples.csv").unlink(missing_ok=True)  # of an earlier run
    if printed:
        rows = samples_of(export, printed, options)
        write(folder / "samples.csv", "t,id,x,y,z,vx,vy,vz\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))
    write(folder / "cost.json", json.dumps({
        "engine": "CalculiX", "version": name, "step": options.step, "iterations": None, "precision": "double",
        "wall_seconds": wall, "cpu_seconds": cpu, "threads": 1,
        "settings": {"element": options.element, "analysis": "static" if options.rest else "dynamic, HHT alpha 0"},
        "status": status}, indent=2) + "\n")
    if status != "ok":
        raise EngineFailed(status)


def main():
    parser = argparse.ArgumentParser(prog="calculix.py", description=__doc__.split("\n", 1)[0])
    parser.add_argument("--version", action="store_true", help="say which CalculiX is here")
    parser.add_argument("export", type=pathlib.Path, nargs="?", help="folder that `mss peer export` wrote")
    parser.add_argument("result", type=pathlib.Path, nargs="?", help="folder to write to")
    parser.add_argument("--step", type=float, default=1 / 60, help="[s]; 1/60")
    parser.add_argument("--element", choices=["C3D8I", "C3D8", "C3D20", "C3D4"], default="C3D8I")
    parser.add_argument("--rest", action="store_true", help="where the body hangs at rest, in place of its motion")
    options = parser.parse_args()
    try:
        if options.version:
            print("CalculiX", version())
        elif options.result is None:
            parser.error("EXPORT_DIR and RESULT_DIR are expected")
        elif not options.step > 0:
            parser.error("--step: a number above 0 is expected")
        else:
            solve(Export(options.export), options)
    except (InputError, MissingEngine, EngineFailed) as error:
        print(f"calculix.py: {error}", file=sys.stderr)
        return {InputError: 2, MissingEngine: 3, EngineFailed: 1}[type(error)]
    return 0


if __name__ == "__main__":
    sys.exit(main())
