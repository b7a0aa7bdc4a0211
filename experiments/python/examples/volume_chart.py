#!/usr/bin/env python3
"""Runs `mss volume` and draws with matplotlib what results/volume/volume.png shows the error of: volume_chart.py FILE.png [--quick].

In Debian: python3-matplotlib. Exit status 77 without it. The marks of cells are those of editors that run scripts as notebooks.
"""

import sys

import numpy as np

import mss

try:
    import matplotlib
except ImportError:
    sys.exit((print("skipped: matplotlib is not installed; its package is python3-matplotlib", file=sys.stderr), 77)[1])
matplotlib.use("Agg")  # without a screen
import matplotlib.pyplot as plt

OUTPUT = sys.argv[1] if len(sys.argv) > 1 else "volume_chart.png"

# %% The study: a dict of arrays for each of its tables
tables = mss.run_study("volume", {"quick": "--quick" in sys.argv})
stretched = (tables["volume"]["study"] == "cells") & (tables["volume"]["status"] == "ok")
rows = {name: column[stretched] for name, column in tables["volume"].items()}
poisson = dict(zip(tables["volume_models"]["model"], tables["volume_models"]["poisson"]))

# %% The change of volume
figure, axes = plt.subplots(figsize=(8, 6))
elasticity = {}
styles = ["o-", "s--", "D-", "^-.", "v-", "P--", "X-."]
for model, style in zip(dict.fromkeys(rows["model"]), styles):
    of_model = rows["model"] == model
    axes.plot(rows["cells"][of_model], (rows["drift"] / rows["strain"])[of_model], style, label=model)
    if np.isfinite(poisson[model]):
        elasticity[poisson[model]] = (rows["predicted"] / rows["strain"])[of_model][0]
for nu, swelling in elasticity.items():
    axes.axhline(swelling, color="0.4", linestyle=":")
    axes.annotate(f"elasticity, nu = {nu:g}", (1, swelling), (4, 4), textcoords="offset points", color="0.3")
cells = np.unique(rows["cells"])
axes.set_xscale("log")
axes.set_xticks(cells, [str(n) for n in cells])
axes.minorticks_off()
axes.set_xlabel("cells per edge, n")
axes.set_ylabel("change of volume / strain")
axes.set_title(f"Cube of 1 m, ends clamped, stretched by {100 * rows['strain'][0]:g} %", loc="left")
axes.grid(color="0.9")
axes.legend()
figure.savefig(OUTPUT, dpi=150)
print("wrote", OUTPUT)

# %% The same body by hand: its lowest frequency, and a second of motion
cube = mss.load({"body": {"cells": [4, 4, 4], "cell_size": 0.25}, "material": {"young": 1e5, "poisson": 0.3, "density": 1000}})
omega = cube.modes(7)["omega"][6]  # the first six are rigid
cube.set_state(0, cube.positions * [1, 1, 1.001], np.zeros_like(cube.positions))
cube.advance(1)
print(f"lowest frequency {omega / (2 * np.pi):.2f} Hz; after {cube.time:.3f} s {cube.energies()['total']:.3e} J")
