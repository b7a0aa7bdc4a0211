#!/usr/bin/env python3
"""Computes tables.csv with CalculiX (Debian's calculix-ccx). Only who wants to change the tables needs to run this:

    reference/calculix/make_tables.py [--quick]

Every body is a bar of cells along x, one metre wide: length x 1 x 1, `cells` to a metre, E = 100 kPa, density
1000 kg/m^3, clamped at x = 0. C3D20 are quadratic elements, whose finest mesh is taken for the truth; C3D8 are the
trilinear ones of reference/fem, on coarse meshes, to be met digit by digit. Takes some ten minutes.
"""
import csv
import itertools
import math
import pathlib
import subprocess
import sys
import tempfile

YOUNG = 1e5
DENSITY = 1000.0
HERE = pathlib.Path(__file__).parent


class Bar:
    """Nodes and elements of a bar; positions are counted in half cells, so that midside nodes are whole numbers."""

    def __init__(self, length, cells, quadratic):
        self.quadratic, self.cells = quadratic, cells
        self.counts = (length * cells, cells, cells)
        corners = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
        middles = [(1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
                   (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]
        offsets = corners + (middles if quadratic else [])
        self.number, self.elements = {}, []
        for i, j, k in itertools.product(*map(range, self.counts)):
            element = []
            for a, b, c in offsets:
                place = (2 * i + a, 2 * j + b, 2 * k + c)
                element.append(self.number.setdefault(place, len(self.number) + 1))
            self.elements.append(element)

    def position(self, place):
        return tuple(x / (2 * self.cells) for x in place)

    def face(self, half_cells):
        """Nodes with that x, as {place: number}."""
        return {p: n for p, n in self.number.items() if p[0] == half_cells}

    def end(self):
        return self.face(2 * self.counts[0])

    def face_shares(self, axis, far):
        """What a uniform traction on a face gives each of its nodes, as {node: area}."""
        shares = {}
        area = 1.0 / self.cells ** 2
        across = [a for a in range(3) if a != axis]
        for j, k in itertools.product(*(range(self.counts[a]) for a in across)):
            for b, c in itertools.product((0, 1, 2), repeat=2):
                corner, centre = b != 1 and c != 1, b == 1 and c == 1
                place = [2 * self.counts[axis] if far else 0] * 3
                place[across[0]], place[across[1]] = 2 * j + b, 2 * k + c
                share = None
                if self.quadratic and not centre:  # eight-node face: corners -1/12, midsides 1/3
                    share = area * (-1 / 12 if corner else 1 / 3)
                elif not self.quadratic and corner:
                    share = area / 4
                if share is not None:
                    node = self.number[tuple(place)]
                    shares[node] = shares.get(node, 0.0) + share
        return shares

    def end_shares(self):
        """The same for the far end, whose area is 1."""
        return self.face_shares(0, True)

    def input(self, poisson):
        lines = ["*NODE, NSET=ALL"]
        for place, number in self.number.items():
            lines.append(f"{number}, " + ", ".join(repr(x) for x in self.position(place)))
        lines.append(f"*ELEMENT, TYPE={'C3D20' if self.quadratic else 'C3D8'}, ELSET=BODY")
        for e, nodes in enumerate(self.elements, 1):
            words = [str(n) for n in [e] + nodes]
            lines.append(", ".join(words[:11]) + ("," if len(words) > 11 else ""))
            if len(words) > 11:
                lines.append(", ".join(words[11:]))
        for name, nodes in (("CLAMP", self.face(0)), ("END", self.end())):
            lines.append(f"*NSET, NSET={name}")
            lines += [f"{n}," for n in nodes.values()]
        lines += ["*MATERIAL, NAME=SOFT", "*ELASTIC", f"{YOUNG}, {poisson}", "*DENSITY", f"{DENSITY}",
                  "*SOLID SECTION, ELSET=BODY, MATERIAL=SOFT", "*BOUNDARY", "CLAMP, 1, 3"]
        return lines


def calculix(lines):
    """Runs ccx and returns what it printed."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "job"
        path.with_suffix(".inp").write_text("\n".join(lines) + "\n")
        log = subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, text=True, check=True).stdout
        if "*ERROR" in log:
            raise RuntimeError(log)
        return path.with_suffix(".dat").read_text()


def last_vectors(printed):
    """{node: vector} of the last block of a .dat file."""
    block = {}
    for line in printed.splitlines():
        words = line.split()
        if len(words) == 4 and words[0].isdigit():
            block[int(words[0])] = tuple(map(float, words[1:]))
        elif words:
            block = {}
    return block


def deflection(cells, quadratic, poisson):
    """Of the end of a bar 4 x 1 x 1 under a shear traction of total 1 N: its mean over the end [m/N]."""
    bar = Bar(4, cells, quadratic)
    shares = bar.end_shares()
    loads = [f"{n}, 3, {share * 1e3!r}" for n, share in shares.items()]
    printed = calculix(bar.input(poisson) + ["*STEP", "*STATIC", "*CLOAD"] + loads +
                       ["*NODE PRINT, NSET=END", "U", "*END STEP"])
    return sum(shares[n] * u[2] for n, u in last_vectors(printed).items()) / 1e3


def frequencies(cells, poisson, count):
    """The lowest of a bar 4 x 1 x 1, one end clamped [Hz]."""
    printed = calculix(Bar(4, cells, True).input(poisson) + ["*STEP", "*FREQUENCY", str(count), "*END STEP"])
    table = printed.split("E I G E N V A L U E   O U T P U T")[1].split("P A R T I C I P A T I O N")[0]
    rows = [line.split() for line in table.splitlines()]
    return [float(words[3]) for words in rows if len(words) == 5 and words[0].isdigit()]


def steps(bar, places):
    """Large displacements of the end, one step for each list of {node: displacement}."""
    lines = []
    for displacements in places:
        lines += ["*STEP, NLGEOM, INC=200", "*STATIC", "0.5, 1., 1e-5, 1.", "*BOUNDARY"]
        lines += [f"{n}, {axis + 1}, {axis + 1}, {u[axis]!r}" for n, u in displacements.items() for axis in range(3)]
        lines += ["*NODE PRINT, NSET=END", "RF", "*END STEP"]
    return lines


def swelling(cells, poisson):
    """Of a cube whose two ends are glued and pulled apart by a strain: change of volume over that strain, to first order."""
    bar = Bar(1, cells, True)
    pulled = [f"END, 1, 1, {1e-2!r}", "END, 2, 3"]
    moved = last_vectors(calculix(bar.input(poisson) + ["*STEP", "*STATIC", "*BOUNDARY"] + pulled +
                                  ["*NODE PRINT, NSET=ALL", "U", "*END STEP"]))
    change = 0.0
    for axis in range(3):
        for far in (False, True):
            sign = 1 if far else -1
            change += sign * sum(share * moved[n][axis] for n, share in bar.face_shares(axis, far).items())
    return change / 1e-2


def twist_torque(cells, quadratic, poisson, degrees, count):
    """About the axis of a bar 2 x 1 x 1 whose end turns without moving [N m]."""
    bar = Bar(2, cells, quadratic)

    def turned(angle):
        moves = {}
        for place, n in bar.end().items():
            _, y, z = bar.position(place)
            y, z = y - 0.5, z - 0.5
            moves[n] = (0.0, math.cos(angle) * y - math.sin(angle) * z - y, math.sin(angle) * y + math.cos(angle) * z - z)
        return moves

    final = turned(math.radians(degrees))
    forces = last_vectors(calculix(bar.input(poisson) +
                                   steps(bar, [turned(math.radians(degrees * (i + 1) / count)) for i in range(count)])))
    torque = 0.0
    for place, n in bar.end().items():
        _, y, z = bar.position(place)
        y, z = y - 0.5 + final[n][1], z - 0.5 + final[n][2]
        torque += y * forces[n][2] - z * forces[n][1]
    return torque


def compression_force(cells, quadratic, poisson, share, count):
    """On the end of a bar 2 x 1 x 1 that is pushed in by a share of its length, both ends glued [N]."""
    bar = Bar(2, cells, quadratic)
    places = [{n: (-2 * share * (i + 1) / count, 0.0, 0.0) for n in bar.end().values()} for i in range(count)]
    return -sum(f[0] for f in last_vectors(calculix(bar.input(poisson) + steps(bar, places))).values())


def main():
    quick = "--quick" in sys.argv[1:]
    rows = []

    def add(case, poisson, element, cells, quantity, unit, value):
        rows.append([case, poisson, element, cells, quantity, unit, repr(value)])
        print(*rows[-1], flush=True)

    for poisson in (0.3, 0.45):
        for cells in (1, 2, 4):
            add("cantilever", poisson, "C3D8", cells, "deflection", "m/N", deflection(cells, False, poisson))
        for cells in (2, 4) if quick else (2, 4, 8, 12, 16):
            add("cantilever", poisson, "C3D20", cells, "deflection", "m/N", deflection(cells, True, poisson))
        for cells in (2,) if quick else (2, 4, 6):
            for mode, frequency in enumerate(frequencies(cells, poisson, 6), 1):
                add("vibration", poisson, "C3D20", cells, f"frequency_{mode}", "Hz", frequency)
        for cells in (2, 4) if quick else (2, 4, 8, 12):
            add("glued_stretch", poisson, "C3D20", cells, "swelling", "1", swelling(cells, poisson))
        for element, sizes in (("C3D8", (1, 2)), ("C3D20", (2,) if quick else (2, 4, 6))):
            for cells in sizes:
                quadratic = element == "C3D20"
                add("twist", poisson, element, cells, "torque", "N m", twist_torque(cells, quadratic, poisson, 60, 8))
                add("compression", poisson, element, cells, "force", "N",
                    compression_force(cells, quadratic, poisson, 0.2, 6))
    with open(HERE / "tables.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", "poisson", "element", "cells", "quantity", "unit", "value"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
