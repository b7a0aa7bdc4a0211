#!/usr/bin/env python3
"""Makes the surface meshes of the scenes, the same bytes each time:  ./make_meshes.py [FOLDER]

sphere, torus, box: closed forms. bracket_*: two boxes that share a face. bear: an implicit surface, a smooth
union of ellipsoids, by marching tetrahedra. Needs Python 3 alone. Lengths are metres; the box and the bracket
stand at the origin, the others about it.
"""

import math
import pathlib
import sys


def box(lower, upper):
    """The twelve triangles of an axis-aligned box."""
    vertices = [tuple((upper if c >> a & 1 else lower)[a] for a in range(3)) for c in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def torus(ring, tube, around, across):
    """A torus about the z axis."""
    vertices = []
    for i in range(around):
        for j in range(across):
            u, v = 2 * math.pi * i / around, 2 * math.pi * j / across
            r = ring + tube * math.cos(v)
            vertices.append((r * math.cos(u), r * math.sin(u), tube * math.sin(v)))
    triangles = []
    for i in range(around):
        for j in range(across):
            a, b = i * across + j, (i + 1) % around * across + j
            c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
            triangles += [(a, b, c), (a, c, d)]
    return vertices, triangles


def sphere(radius, across):
    """Meridians and parallels, one vertex at each pole."""
    around = 2 * across
    vertices = [(0.0, 0.0, -radius)]
    for i in range(1, across):
        z, r = -math.cos(math.pi * i / across), math.sin(math.pi * i / across)
        for j in range(around):
            u = 2 * math.pi * j / around
            vertices.append((radius * r * math.cos(u), radius * r * math.sin(u), radius * z))
    vertices.append((0.0, 0.0, radius))
    top, triangles = len(vertices) - 1, []
    for j in range(around):
        k = (j + 1) % around
        triangles.append((0, 1 + k, 1 + j))
        for i in range(across - 2):
            a, b = 1 + i * around + j, 1 + i * around + k
            triangles += [(a, b, b + around), (a, b + around, a + around)]
        triangles.append((top, top - around + j, top - around + k))
    return vertices, triangles


# A bear: centre and half axes of ellipsoids, mirrored in x where `both`.
BEAR = [
    ((0, 0, 0), (0.21, 0.16, 0.26), False),  # trunk
    ((0, -0.02, 0.36), (0.16, 0.15, 0.15), False),  # head
    ((0, -0.15, 0.33), (0.07, 0.07, 0.06), False),  # snout
    ((0.12, 0.0, 0.49), (0.06, 0.04, 0.06), True),  # ears
    ((0.24, -0.10, 0.12), (0.07, 0.15, 0.08), True),  # arms
    ((0.14, -0.14, -0.25), (0.09, 0.19, 0.10), True),  # legs
]


def bear(x, y, z):
    """Negative inside: a smooth minimum over ellipsoids of (scaled) distances to them."""
    total = 0.0
    for (cx, cy, cz), (a, b, c), both in BEAR:
        for side in (1, -1) if both else (1,):
            q = math.sqrt(((x - side * cx) / a) ** 2 + ((y - cy) / b) ** 2 + ((z - cz) / c) ** 2)
            total += math.exp(-(q - 1) * min(a, b, c) / 0.02)
    return -0.02 * math.log(total) if total > 0 else 1.0


def isosurface(field, lower, cells, size):
    """The zero surface of a field that is negative inside, by marching tetrahedra (six a cube, no choices)."""
    value = {}

    def at(p):
        if p not in value:
            f = field(*(lower[a] + size * p[a] for a in range(3)))
            value[p] = f if f != 0 else 1e-12
        return value[p]

    vertices, index, triangles = [], {}, []

    def cut(p, q):
        key = (p, q) if p < q else (q, p)
        if key not in index:
            p, q = key
            t = at(p) / (at(p) - at(q))
            t = min(max(t, 0.05), 0.95)  # no slivers
            index[key] = len(vertices)
            vertices.append(tuple(lower[a] + size * (p[a] + t * (q[a] - p[a])) for a in range(3)))
        return index[key]

    # The six tetrahedra about the diagonal 0-7, all of one orientation.
    tetrahedra = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]
    for k in range(cells[2]):
        for j in range(cells[1]):
            for i in range(cells[0]):
                corner = [(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)) for c in range(8)]
                if len({at(p) < 0 for p in corner}) == 1:
                    continue
                for tetrahedron in tetrahedra:
                    a, b, c, d = (corner[t] for t in tetrahedron)
                    triangles += march(at, cut, a, b, c, d)
    return vertices, triangles


def march(at, cut, *corners):
    """Triangles of one positively oriented tetrahedron, seen counter-clockwise from outside."""
    inside = [n for n in range(4) if at(corners[n]) < 0]
    if not inside or len(inside) == 4:
        return []
    p = corners
    # Even permutations that bring the odd corner first, or the two inside first.
    first = {0: (0, 1, 2, 3), 1: (1, 0, 3, 2), 2: (2, 0, 1, 3), 3: (3, 0, 2, 1)}
    if len(inside) in (1, 3):
        odd = inside[0] if len(inside) == 1 else next(n for n in range(4) if n not in inside)
        a, b, c, d = (p[n] for n in first[odd])
        triangle = (cut(a, b), cut(a, c), cut(a, d))
        return [triangle if len(inside) == 1 else triangle[::-1]]
    pairs = {(0, 1): (0, 1, 2, 3), (0, 2): (0, 2, 3, 1), (0, 3): (0, 3, 1, 2),
             (1, 2): (1, 2, 0, 3), (1, 3): (1, 3, 2, 0), (2, 3): (2, 3, 0, 1)}
    a, b, c, d = (p[n] for n in pairs[tuple(inside)])
    q = (cut(a, c), cut(a, d), cut(b, d), cut(b, c))
    return [(q[0], q[1], q[2]), (q[0], q[2], q[3])]


def volume(vertices, triangles):
    total = 0.0
    for a, b, c in triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = vertices[a], vertices[b], vertices[c]
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total / 6


def write(file, comment, mesh):
    vertices, triangles = mesh
    assert volume(vertices, triangles) > 0, file
    lines = ["# " + comment + "; made by make_meshes.py"]
    lines += ["v " + " ".join(f"{round(x, 5) + 0.0:g}" for x in v) for v in vertices]
    lines += ["f " + " ".join(str(i + 1) for i in t) for t in triangles]
    file.write_text("\n".join(lines) + "\n")


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).parent
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / "sphere.obj", "Sphere of radius 0.5 m", sphere(0.5, 24))
    write(folder / "torus.obj", "Torus of radii 0.35 and 0.15 m", torus(0.35, 0.15, 48, 24))
    write(folder / "bar.obj", "Bar of 1 x 0.25 x 0.25 m", box((0, 0, 0), (1, 0.25, 0.25)))
    write(folder / "bracket_foot.obj", "Foot of a bracket", box((0, 0, 0), (0.2, 0.3, 0.5)))
    write(folder / "bracket_arm.obj", "Arm of a bracket", box((0.2, 0, 0.3), (0.8, 0.3, 0.5)))
    write(folder / "bear.obj", "A bear, 1 m tall", isosurface(bear, (-0.4, -0.4, -0.45), (24, 24, 31), 1 / 30))


if __name__ == "__main__":
    main()
