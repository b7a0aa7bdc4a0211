#!/usr/bin/python3
"""thirty_lines.py EXPORT_DIR RESULT_DIR STEP: springs, dampers and gravity by semi-implicit Euler."""
import csv, json, os, sys, time
import numpy as np

export, result, step = sys.argv[1], sys.argv[2], float(sys.argv[3])
scene = json.load(open(f"{export}/scene.json"))
p = np.genfromtxt(f"{export}/particles.csv", delimiter=",", names=True)
s = np.genfromtxt(f"{export}/springs.csv", delimiter=",", names=True)
a, b, mass, free = s["a"].astype(int), s["b"].astype(int), p["mass"][:, None], p["held"][:, None] == 0
x, v = (np.stack([p[f"start_{kind}{axis}"] for axis in "xyz"], axis=1) for kind in ("", "v"))

def acceleration():
    along = x[b] - x[a]
    length = np.linalg.norm(along, axis=1)[:, None]
    along /= length
    pull = s["stiffness"][:, None] * (length - s["rest_length"][:, None]) * along
    pull += s["damping"][:, None] * np.sum((v[b] - v[a]) * along, axis=1, keepdims=True) * along
    f = mass * scene["gravity"]
    np.add.at(f, a, pull)
    np.subtract.at(f, b, pull)
    return free * f / mass

rows, now, begin = [], 0, time.process_time()
for t in scene["sample_times"]:
    for dt in [(t - now) / n for n in [round((t - now) / step)] for _ in range(n)]:
        v += dt * acceleration()
        x += dt * v
    now = t
    rows += [(t, id, *x[id]) for id in range(len(x))]
spent = time.process_time() - begin
os.makedirs(result, exist_ok=True)
csv.writer(open(f"{result}/samples.csv", "w")).writerows([("t", "id", "x", "y", "z")] + rows)
json.dump({"engine": "thirty lines", "version": "1", "step": step, "iterations": None, "precision": "double",
           "threads": 1, "wall_seconds": spent, "cpu_seconds": spent}, open(f"{result}/cost.json", "w"))
