#!/usr/bin/env python3
"""Ranks that share a body: ranks_test.py MSS FOLDER PART...

bits     every number of ranks and threads leaves the files of one process, byte for byte
sums     where methods sum over particles ranks differ by rounding
vtk      the same of what --vtk writes
lost     a killed rank ends the run with a sentence and status 3, an interrupted run keeps its rows
refused  what ranks cannot do is refused in one sentence
without  a program built without MPI refuses to be one of several processes
"""
import concurrent.futures
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
MOST_SECONDS = 600  # that what ends at all may take, on however slow or busy a machine
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
    return subprocess.run(command(*arguments), env=environment, capture_output=True, text=True, timeout=MOST_SECONDS)


def check(holds, sentence):
    if not holds:
        sys.exit(f"ranks_test.py: {sentence}")


def summary(out):
    return json.loads((out / "summary.json").read_text())


def halo_error(name, out, ranks):
    sharing = summary(out)["sharing"]
    to_neighbour = sharing["halo_exchanges"] * sharing["halo_bytes_to_a_neighbour"]
    neighbours = [(r > 0) + (r + 1 < ranks) for r in range(ranks)]
    is_right = sharing["halo_exchanges"] > 0 and sharing["halo_bytes_sent"] == [to_neighbour * n for n in neighbours]
    return "" if is_right else f"{name}: halo of {sharing}"


def difference(name, ranks, threads):
    """What a scene leaves otherwise than one process did, as a sentence; empty: nothing."""
    scene, *settings = SCENES[name]
    alone, out = folder / name / "alone", folder / name / f"{ranks}_{threads}"
    which = f"{name} in {ranks} ranks of {threads} threads"
    finished = run(ranks, scene, out, f"solve.threads={threads}", *settings)
    if finished.returncode != 0:
        return f"{which}: {finished.stderr}"
    for file in ("particles.csv", "series.csv"):
        if (out / file).read_bytes() != (alone / file).read_bytes():
            return f"{which}: {file} differs"
    if summary(out)["ranks"] != ranks:
        return f"{which}: summary.json has {summary(out)['ranks']}"
    return halo_error(which, out, ranks) if ranks > 1 else ""


def bits():
    for name, (scene, *settings) in SCENES.items():
        alone = folder / name / "alone"
        finished = run(0, scene, alone, *settings)
        check(finished.returncode == 0 and summary(alone)["ranks"] == 1, f"{name}: {finished.stderr}")
        ways = list(itertools.product((1, 2, 3, 4), (1, 2)))
        with concurrent.futures.ThreadPoolExecutor(3) as pool:  # they mostly wait for each other to start
            for failure in pool.map(lambda way: difference(name, *way), ways):
                check(not failure, failure)


SUMMED_UP = {  # methods that decide by sums over particles, and how far ranks may end from one process
    "backward_euler": 1e-7,  # what conjugate gradients leave
    "cvode_bdf": 1e-6,
    "cvode_bdf_gmres": 1e-6,
    "arkode_dirk": 1e-6,
    "cvode_adams": 2e-4,  # where rounding may change the choice of a step: tolerances are 1e-6 of a cell, and of its
    "arkode_erk": 2e-4,  # size over the time that the fastest mode takes
}


def particles(out):
    lines = (out / "particles.csv").read_text().splitlines()[1:]
    return [[float(number) for number in line.split(",")] for line in lines]


def sums():
    """Where methods sum over particles ranks differ by rounding, and by what follows from that."""
    def distance(method):
        """Of the ends of a scene in one process and in three ranks; infinite if one has none."""
        settings = [f"solve.integrator='{method}'", "solve.linear_solver='matrix_free'", "solve.duration=0.04"]
        ends = []
        for ranks in (0, 3):
            out = folder / f"{method}_{ranks}"
            if run(ranks, "soft_table", out, *settings).returncode != 0:
                return float("inf")
            ends.append(particles(out))
        if not len(ends[0]) == len(ends[1]) > 50:
            return float("inf")
        return max(abs(a - b) for one, other in zip(*ends) for a, b in zip(one, other))

    with concurrent.futures.ThreadPoolExecutor(3) as pool:
        for (method, within), apart in zip(SUMMED_UP.items(), pool.map(distance, SUMMED_UP)):
            check(apart < within, f"{method} in ranks ends {apart} apart from one process")


def vtk():
    """Series for ParaView are the same bytes too."""
    scene = ["voxel_creature", "solve.duration=0.05"]
    files = []
    for ranks in (0, 2, 4):
        out = folder / f"vtk_{ranks}"
        shutil.rmtree(out, ignore_errors=True)
        ended = subprocess.run(command(ranks, scene[0], out, scene[1]) + ["--vtk", "5"], env=environment,
                               capture_output=True, text=True, timeout=MOST_SECONDS)
        check(ended.returncode == 0, f"vtk of {ranks} ranks: {ended.stderr}")
        files.append({file.relative_to(out): file.read_bytes() for file in out.rglob("*vtk*/*.*")} |
                     {file.relative_to(out): file.read_bytes() for file in out.glob("*.series")})
    check(len(files[0]) > 5, f"there are only {list(files[0])}")
    for other in files[1:]:
        check(other.keys() == files[0].keys(), f"files are {list(other)}, not {list(files[0])}")
        for name, content in files[0].items():
            check(other[name] == content, f"{name} differs")


def start_long_run(out):
    """A run of two ranks that has written a few rows, and the processes that work in it, by rank."""
    running = subprocess.Popen(command(2, "free_cube", out, "solve.duration=1000", "solve.every=0.001"), env=environment,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + MOST_SECONDS
    while running.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
        if (out / "series.csv").exists() and rows(out) > 3:
            return running, workers(running.pid)
    running.kill()
    sys.exit("ranks_test.py: a run of two ranks wrote no rows")


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
    deadline = time.monotonic() + MOST_SECONDS
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
        _, errors = running.communicate(timeout=MOST_SECONDS)
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
    running.communicate(timeout=MOST_SECONDS)
    check_all_end(pids.values(), "interrupted")
    check(running.returncode != 0 and summary(out)["status"] == "interrupted", "Ctrl-C left no interrupted run")
    check(rows(out) > 3 and (out / "particles.csv").exists(), "Ctrl-C left no rows")


REFUSED = {
    "implicit": (["soft_table"], 'needs linear_solver = "matrix_free"'),
    "quasi-Newton": (["soft_table", "solve.nonlinear_solver='lbfgs'"], "a nonlinear solver other than"),
    "adaptive": (["free_cube", "solve.integrator='cvode_bdf'"], 'needs linear_solver = "matrix_free"'),
    "KLU": (["free_cube", "solve.integrator='cvode_bdf_klu'"], 'integrator = "cvode_bdf_klu" is for a body in one process'),
    "positions": (["free_cube", "solve.integrator='xpbd'"], 'integrator = "xpbd" is for a body in one process'),
    "equilibrium": (["cantilever", "solve.integrator='static'"], 'integrator = "static" is for a body in one process'),
    "faces": (["mesh_bar"], "a hold of a mesh's faces is for a body in one process"),
    "sleep": (["soft_blocks"], "sleep is for a body in one process"),
    "elements": (["free_cube", "material.model='linear'"], "is for a body in one process"),
    "too_many": (["thin_slab"], "3 ranks share a body of 2 planes"),
    "misspelt": (["free_cubes"], "free_cube"),
}


def refused():
    cases = [(name, command(3, scene[0], folder / name, *scene[1:]), sentence)
             for name, (scene, sentence) in REFUSED.items()]
    cases.append(("vtk", command(2, "mesh_bear", folder / "vtk", "body.contact_on='particles'") + ["--vtk", "10"],
                  "--vtk of a body given as a mesh"))
    cases.append(("other command", ["mpirun", "-n", "2", mss, "modes", "free_cube"], "`mss modes` is for one process"))
    for name, words, sentence in cases:
        ended = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=MOST_SECONDS)
        said = [line for line in ended.stderr.splitlines() if line.startswith("mss: ") and "warning" not in line]
        check(ended.returncode == 2, f"{name}: status {ended.returncode}\n{ended.stderr}")
        check(len(said) == 1 and sentence in said[0], f"{name}: {said}")


def without():
    launched = dict(os.environ, OMPI_COMM_WORLD_SIZE="2", OMPI_COMM_WORLD_RANK="0")
    out = folder / "without"
    ended = subprocess.run(command(0, "free_cube", out), env=launched, capture_output=True, text=True, timeout=MOST_SECONDS)
    check(ended.returncode == 2 and "built without MPI" in ended.stderr, f"status {ended.returncode}: {ended.stderr}")
    check(not (out / "particles.csv").exists(), "particles were written")


parts = {"bits": bits, "vtk": vtk, "sums": sums, "lost": lost, "refused": refused, "without": without}
if shutil.which("mpirun") is None and "without" not in sys.argv:
    sys.exit(SKIPPED)
folder.mkdir(parents=True, exist_ok=True)
for part in sys.argv[3:]:
    begin = time.monotonic()
    parts[part]()
    print(f"{part}: {time.monotonic() - begin:.1f} s")
