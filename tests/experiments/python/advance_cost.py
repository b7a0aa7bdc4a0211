#!/usr/bin/env python3
"""What 1,000 steps through `advance` cost, over the same loop in C++ (`mss run`), interleaved: in ten calls, and in one call
a step. Needs the module on PYTHONPATH; the program mss is the first argument, the number of rounds may be the second.
Prints the ratios, which a busy machine changes; fails if calls in Python take other steps, or make arrays of the body."""

import json
import statistics
import subprocess
import sys
import tempfile
import time
import tracemalloc
from pathlib import Path

import mss

PROGRAM, ROUNDS = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 3
DT, STEPS = 1e-5, 1000
SETTINGS = {"body.cells": [20, 20, 20], "solve.integrator": "verlet", "solve.dt": DT, "solve.duration": STEPS * DT,
            "solve.threads": 1}
CALLS = {"10 calls": 10, "1,000 calls": STEPS}


def seconds_in_cpp(calls, out):
    """Of stepping only, as mss run measures them; a call of the core is a row of series.csv."""
    settings = dict(SETTINGS, **{"solve.every": STEPS * DT / calls})
    options = [f"--set={key}={value}" for key, value in settings.items()]
    subprocess.run([PROGRAM, "run", "free_cube", *options, "--out", out], check=True, capture_output=True)
    summary = json.loads((Path(out) / "summary.json").read_text())
    assert summary["steps"] == STEPS, summary
    return summary["wall_seconds"]


def seconds_in_python(calls):
    simulation = mss.load("free_cube", SETTINGS)
    start = time.perf_counter()
    for call in range(1, calls + 1):
        simulation.advance(call * STEPS * DT / calls)
    seconds = time.perf_counter() - start
    assert simulation.work["steps"] == STEPS
    return seconds


def bytes_in_python():
    """Most that the calls hold at once, and what an array of positions takes."""
    simulation = mss.load("free_cube", SETTINGS)
    array = simulation.positions.nbytes
    tracemalloc.start()
    for call in range(1, STEPS + 1):
        simulation.advance(call * DT)
    most = tracemalloc.get_traced_memory()[1]
    simulation.positions
    assert tracemalloc.get_traced_memory()[1] > array  # arrays are seen
    tracemalloc.stop()
    return most, array


def main():
    for name, calls in CALLS.items():
        cpp, python = [], []
        with tempfile.TemporaryDirectory() as out:
            for _ in range(ROUNDS):
                cpp.append(seconds_in_cpp(calls, out))
                python.append(seconds_in_python(calls))
        ratio = min(python) / min(cpp)
        print(f"{STEPS} steps in {name}: {min(python):.4f} s in Python, {min(cpp):.4f} s in C++, ratio {ratio:.4f} (shortest of "
              f"{ROUNDS}; medians {statistics.median(python):.4f}, {statistics.median(cpp):.4f})")
    most, array = bytes_in_python()
    print(f"{STEPS} calls hold {most} bytes at most; an array of positions takes {array}")
    return 0 if most < array / 2 else 1


if __name__ == "__main__":
    sys.exit(main())
