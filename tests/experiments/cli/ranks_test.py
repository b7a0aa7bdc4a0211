#!/usr/bin/env python3
"""Ranks that share a body: ranks_test.py MSS FOLDER PART...

bits     every number of ranks and threads leaves the files of one process, byte for byte
lost     a killed rank ends the run with a sentence and status 3, an interrupted run keeps its rows
refused  what ranks cannot do is refused in one sentence
without  a program built without MPI refuses to be one of several processes
"""
import itertools
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

SKIPPED = 77
mss, folder = sys.argv[1], pathlib.Path(sys.argv[2])
environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_hwloc_base_binding_policy="none",
                   OMPI_MCA_mpi_yield_when_idle="1")

# Contact by impulses, by the thesis's law and by penalties; boxes and voxels; damping by a ratio, a viscosity and
# none; holds that turn, loads, strikes, weights and a fold guard; methods that fuse steps and that do not.
SCENES = {
    "bounce": ["fig5_2_bounce", "solve.duration=1.0", "solve.every=0.1"],
    "thesis_contact": ["fig5_2_bounce", "solve.duration=1.0", "solve.every=0.1", "plane.0.contact='thesis'"],
    "table": ["soft_table", "solve.integrator='velocity_verlet'", "solve.dt='safe'", "solve.duration=0.1"],
    "creature": ["voxel_creature", "solve.duration=0.1", "material.fold_guard=20"],
    "viscosity": ["damped_bar", "solve.duration=0.1"],
    "twist": ["fig5_1_twist", "solve.integrator='rk4'", "solve.duration=0.5", "solve.every=0.05"],
    "strike": ["fig2_1_crumple", "solve.integrator='pefrl'", "solve.duration=0.2"],
    "single": ["free_cube", "solve.precision='single'", "solve.duration=0.2"],
}


def command(ranks, scene, out, *settings):
    launcher = ["mpirun", "-n", str(ranks)] if ranks else []
    sets = list(itertools.chain.from_iterable(("--set", s) for s in settings))
    return launcher + [mss, "run", scene, "--out", str(out)] + sets


def run(*arguments):
    return subprocess.run(command(*arguments), env=environment, capture_output=True, text=True, timeout=120)


def check(holds, sentence):
    if not holds:
        sys.exit(f"ranks_test.py: {sentence}")


def summary(out):
    return json.loads((out / "summary.json").read_text())


def check_halo(name, out, ranks):
    sharing = summary(out)["sharing"]
    to_neighbour = sharing["halo_exchanges"] * sharing["halo_bytes_to_a_neighbour"]
    neighbours = [(r > 0) + (r + 1 < ranks) for r in range(ranks)]
    check(sharing["halo_exchanges"] > 0 and
          sharing["halo_bytes_sent"] == [to_neighbour * n for n in neighbours], f"{name}: halo of {sharing}")


def bits():
    for name, (scene, *settings) in SCENES.items():
        alone = folder / name / "alone"
        finished = run(0, scene, alone, *settings)
        check(finished.returncode == 0 and summary(alone)["ranks"] == 1, f"{name}: {finished.stderr}")
        for ranks, threads in itertools.product((1, 2, 3, 4), (1, 2)):
            out = folder / name / f"{ranks}_{threads}"
            finished = run(ranks, scene, out, f"solve.threads={threads}", *settings)
            which = f"{name} in {ranks} ranks of {threads} threads"
            check(finished.returncode == 0, f"{which}: {finished.stderr}")
            check(summary(out)["ranks"] == ranks, f"{which}: summary.json has {summary(out)['ranks']}")
            for file in ("particles.csv", "series.csv"):
                check((out / file).read_bytes() == (alone / file).read_bytes(), f"{which}: {file} differs")
            if ranks > 1:
                check_halo(which, out, ranks)


def start_long_run(out):
    """A run of two ranks that has written a few rows, and the processes that work in it, by rank."""
    running = subprocess.Popen(command(2, "free_cube", out, "solve.duration=1000", "solve.every=0.001"), env=environment,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        time.sleep(0.05)
        if (out / "series.csv").exists() and rows(out) > 3:
            return running, workers(running.pid)
    running.kill()
    sys.exit("ranks_test.py: a run of two ranks wrote no rows within 20 s")


def rows(out):
    return (out / "series.csv").read_text().count("\n") - 1


def workers(launcher):
    found = {}
    for process in pathlib.Path("/proc").iterdir():
        try:
            parent = int((process / "stat").read_text().rsplit(")", 1)[1].split()[1])
            grandparent = int(pathlib.Path(f"/proc/{parent}/stat").read_text().rsplit(")", 1)[1].split()[1])
            if grandparent == launcher:
                variables = (process / "environ").read_bytes().split(b"\0")
                rank = next(v for v in variables if v.startswith(b"OMPI_COMM_WORLD_RANK="))
                found[int(rank.split(b"=")[1])] = int(process.name)
        except (OSError, ValueError, IndexError, StopIteration):
            continue
    return found


def check_all_end(pids, which):
    deadline = time.monotonic() + 10
    while any(pathlib.Path(f"/proc/{pid}").exists() for pid in pids):
        check(time.monotonic() < deadline, f"{which}: a rank works on")
        time.sleep(0.05)


def lost():
    for rank in (0, 1):
        out = folder / f"lost_{rank}"
        shutil.rmtree(out, ignore_errors=True)
        running, pids = start_long_run(out)
        check(sorted(pids) == [0, 1], f"two workers were expected, found {pids}")
        os.kill(pids[rank], signal.SIGKILL)
        _, errors = running.communicate(timeout=30)
        which = f"rank {rank} killed"
        check(running.returncode == 3, f"{which}: status {running.returncode}\n{errors}")
        check(f"mss: rank {rank} of 2 was ended by signal 9" in errors, f"{which}: {errors}")
        check(rows(out) > 3, f"{which}: {rows(out)} rows are left")
        check(not (out / "summary.json").exists(), f"{which}: there is a summary")
        check_all_end(pids.values(), which)
    out = folder / "interrupted"
    shutil.rmtree(out, ignore_errors=True)
    running, pids = start_long_run(out)
    running.send_signal(signal.SIGINT)
    running.communicate(timeout=30)
    check_all_end(pids.values(), "interrupted")
    check(running.returncode != 0 and summary(out)["status"] == "interrupted", "Ctrl-C left no interrupted run")
    check(rows(out) > 3 and (out / "particles.csv").exists(), "Ctrl-C left no rows")


REFUSED = {
    "implicit": (["fig5_2_bounce", "solve.integrator='backward_euler'"], "explicit methods of fixed step"),
    "adaptive": (["free_cube", "solve.integrator='cvode_adams'"], "explicit methods of fixed step"),
    "positions": (["free_cube", "solve.integrator='xpbd'"], "explicit methods of fixed step"),
    "sleep": (["soft_blocks"], "sleep is for a body in one process"),
    "elements": (["free_cube", "material.model='linear'"], "is for a body in one process"),
    "too_many": (["thin_slab"], "3 ranks share a body of 2 planes"),
    "misspelt": (["free_cubes"], "free_cube"),
}


def refused():
    cases = [(name, command(3, scene[0], folder / name, *scene[1:]), sentence)
             for name, (scene, sentence) in REFUSED.items()]
    cases.append(("vtk", command(2, "free_cube", folder / "vtk") + ["--vtk", "10"], "--vtk is for a body in one process"))
    cases.append(("other command", ["mpirun", "-n", "2", mss, "modes", "free_cube"], "`mss modes` is for one process"))
    for name, words, sentence in cases:
        ended = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=60)
        said = [line for line in ended.stderr.splitlines() if line.startswith("mss: ") and "warning" not in line]
        check(ended.returncode == 2, f"{name}: status {ended.returncode}\n{ended.stderr}")
        check(len(said) == 1 and sentence in said[0], f"{name}: {said}")


def without():
    launched = dict(os.environ, OMPI_COMM_WORLD_SIZE="2", OMPI_COMM_WORLD_RANK="0")
    out = folder / "without"
    ended = subprocess.run(command(0, "free_cube", out), env=launched, capture_output=True, text=True, timeout=60)
    check(ended.returncode == 2 and "built without MPI" in ended.stderr, f"status {ended.returncode}: {ended.stderr}")
    check(not (out / "particles.csv").exists(), "particles were written")


parts = {"bits": bits, "lost": lost, "refused": refused, "without": without}
if shutil.which("mpirun") is None and "without" not in sys.argv:
    sys.exit(SKIPPED)
folder.mkdir(parents=True, exist_ok=True)
for part in sys.argv[3:]:
    begin = time.monotonic()
    parts[part]()
    print(f"{part}: {time.monotonic() - begin:.1f} s")
