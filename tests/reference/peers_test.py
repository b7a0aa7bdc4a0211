#!/usr/bin/python3
"""Adapters of reference/peers compute what their engines are known to: where cantilevers and bars come to rest.

usage: peers_test.py ENGINE MSS BULLET EMPTY_DIRECTORY

ENGINE is jolt, mujoco, bullet or calculix; BULLET the adapter that CMake built, or what is not there.
"""

import csv
import json
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BENDING, HANGING = (2, "[0, 0, -9.81]"), (0, "[9.81, 0, 0]")  # axis of displacements, gravity

ENGINE, MSS, BULLET, FOLDER = sys.argv[1], sys.argv[2], sys.argv[3], pathlib.Path(sys.argv[4])
COMMAND = {
    "jolt": ["node", str(ROOT / "reference/peers/jolt.mjs")],
    "mujoco": ["node", str(ROOT / "reference/peers/mujoco.mjs")],
    "bullet": [BULLET],
    "calculix": [sys.executable, str(ROOT / "reference/peers/calculix.py")],
}[ENGINE]


def skip_where_missing():
    try:
        run = subprocess.run([*COMMAND, "--version"], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        print(f"skipped: there is no {COMMAND[0]}")
        sys.exit(77)
    if run.returncode != 0:
        print("skipped:", run.stderr.strip())
        sys.exit(77)
    print(run.stdout.strip())


def export(across, load, poisson=0.3, seconds=1.3):
    """The folder of a bar of 4 x 1 x 1 m, held at x = 0, sampled at its beginning and end only."""
    folder = FOLDER / f"bar_{across}_{load[0]}_{poisson}"
    changes = (f"body.cells=[{4 * across}, {across}, {across}]", f"body.cell_size={1 / across}", f"material.poisson={poisson}",
               f"environment.gravity={load[1]}", f"solve.duration={seconds}")
    subprocess.run([MSS, "peer", "export", str(ROOT / "reference/peers/reports/bar.toml"), "--every", str(seconds), "--out",
                    str(folder), *(word for change in changes for word in ("--set", change))], check=True, capture_output=True)
    return folder


def changed(exported, **keys):
    """A copy of an export with other values in scene.json."""
    folder = exported.with_name("changed")
    shutil.copytree(exported, folder, dirs_exist_ok=True)
    scene = json.loads((exported / "scene.json").read_text())
    (folder / "scene.json").write_text(json.dumps({**scene, **keys}))
    return folder


def table(file):
    with open(file, newline="", encoding="utf-8") as stream:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(stream)]


def rest(exported, load, *options):
    """Mean displacement of the free end when the adapter's run ends."""
    result = exported.with_name("result")
    subprocess.run([*COMMAND, str(exported), str(result), *options], check=True)
    cost = json.loads((result / "cost.json").read_text())
    assert cost["status"] == "ok", cost
    assert cost["cpu_seconds"] > 0, cost
    particles, samples = table(exported / "particles.csv"), table(result / "samples.csv")
    assert len(samples) == 2 * len(particles), "a row for every particle at both sample times"
    axis, moved = "xyz"[load[0]], []
    for particle, sample in zip(particles, samples[len(particles):]):
        assert sample["id"] == particle["id"], "particles in their order"
        if particle["x"] > 4 - 1e-9:
            moved.append(sample[axis] - particle[axis])
    return sum(moved) / len(moved)


def expect(what, found, expected, within):
    print(f"{what}: {found:.6g}, expected {expected:.6g} within {within:.2g}")
    assert abs(found - expected) <= within, what


def refused(words, *arguments):
    """A wrong call ends with status 2 and one clear sentence."""
    run = subprocess.run([*COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert run.returncode == 2 and words in run.stderr + run.stdout, (run.returncode, run.stderr)


def refuse_other_scenes(exported):
    """What an adapter does not give its engine is refused, or warned of, and never left out in silence."""
    refused("the scene has loads", changed(exported, loads=[{"id": 4, "force": [0, 0, -2.5]}]), FOLDER / "none")
    ground = {"normal": [0, 0, 1], "point": [0, 0, -9], "law": "impulse", "friction": 0.4, "restitution": 0}
    planes = [ground, {**ground, "friction": 0.2}]
    words = "planes are not given" if ENGINE == "calculix" else "planes of different"
    refused(words, changed(exported, planes=planes), FOLDER / "none")
    if ENGINE != "jolt":  # which takes springs
        refused("no single E and nu", changed(exported, young=None, poisson=None), FOLDER / "none")
    scene = changed(exported) / "scene.json"
    scene.write_text('{"format": ')
    refused("scene.json: is not JSON", scene.parent, FOLDER / "none")
    assert not (FOLDER / "none").exists(), "nothing is written of a scene that is refused"
    for law, is_warned_of in (("none", False), ("thesis", True)):
        short = changed(exported, damping={"law": law}, sample_times=[0, 0.01])
        run = subprocess.run([*COMMAND, str(short), str(FOLDER / "short"), "--step", "0.005"], capture_output=True, text=True, check=True)
        assert ("warning: the scene is damped" in run.stderr) == is_warned_of, run.stderr


def check_failure(exported):
    """Where ccx fails, the adapter does, and leaves no samples of an earlier run."""
    folder, result = changed(exported), exported.with_name("result")
    flat = [{**row, "z": 0.0} for row in table(exported / "particles.csv")]
    with open(folder / "particles.csv", "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, flat[0])
        writer.writeheader()
        writer.writerows(flat)
    run = subprocess.run([*COMMAND, str(folder), str(result), "--rest", "--step", "1.3"], capture_output=True, text=True, check=False)
    assert run.returncode == 1 and "ccx ended with an error" in run.stderr, (run.returncode, run.stderr)
    assert json.loads((result / "cost.json").read_text())["status"] == "ccx ended with an error"
    assert not (result / "samples.csv").exists()


def check_jolt():
    beam = export(4, BENDING)
    for iterations, tip in ((5, -0.2846), (20, -0.0522), (80, -0.0366)):  # substeps: by default seven times too soft
        found = rest(beam, BENDING, "--drag", "27", "--iterations", str(iterations))
        expect(f"tip, {iterations} iterations", found, tip, 0.01 * abs(tip))
    refused("negative stiffness", export(2, HANGING, 0, 0.4), FOLDER / "none")
    refused("whole number of 1 or more", beam, FOLDER / "none", "--iterations", "2.5")
    refuse_other_scenes(export(2, BENDING))


def check_mujoco():
    coarse, fine, drag = export(2, BENDING), export(4, BENDING), ("--drag", "27")
    doubled = ("--recalibrate", "yes")
    expect("tip, shear doubled", rest(coarse, BENDING, *drag, *doubled, "--step", "0.002"), -0.03393, 1e-5)
    expect("tip, as documented", rest(coarse, BENDING, *drag, "--step", "0.002"), -0.06057, 1e-5)
    expect("tip, 16x4x4", rest(fine, BENDING, *drag, *doubled, "--step", "0.008"), -0.03757, 2e-5)
    bar = export(2, HANGING, 0, 0.4)
    sag = rest(bar, HANGING, "--drag", "60", "--step", "0.002")
    expect("bar, over rho g L^2 / 2E", sag / (10 * 9.81 * 16 / 2e6), 2, 1e-3)
    refused("trilinear or full", bar, FOLDER / "none", "--dof", "cubic")
    refuse_other_scenes(coarse)


def check_bullet():
    beam, bar = export(2, BENDING), export(2, HANGING, 0, 0.4)
    neo_hookean = ("--model", "neo_hookean", "--step", "0.0041666667")
    expect("tip", rest(beam, BENDING, "--drag", "27", "--step", "0.0041666667"), -0.02064, 1e-5)
    expect("tip, neo-Hookean", rest(beam, BENDING, "--drag", "27", *neo_hookean), -0.02903, 2e-5)
    sag = rest(bar, HANGING, "--drag", "60", *neo_hookean, "--recalibrate")
    expect("bar, neo-Hookean, over rho g L^2 / 2E", sag / (10 * 9.81 * 16 / 2e6), 1, 2e-3)
    refused("linear,neo_hookean,links", beam, FOLDER / "none", "--model", "cubic")
    refuse_other_scenes(beam)


def check_calculix():
    coarse, fine = export(2, BENDING), export(4, BENDING)
    expect("tip, C3D4", rest(coarse, BENDING, "--rest", "--element", "C3D4", "--step", "1.3"), -0.02063, 1e-5)
    expect("tip, C3D20", rest(fine, BENDING, "--rest", "--element", "C3D20", "--step", "1.3"), -0.039095, 1e-6)
    refused("does not divide", coarse, FOLDER / "none", "--step", "0.7")
    refuse_other_scenes(coarse)
    check_failure(coarse)


skip_where_missing()
{"jolt": check_jolt, "mujoco": check_mujoco, "bullet": check_bullet, "calculix": check_calculix}[ENGINE]()
refused("mss peer export", FOLDER / "missing", FOLDER / "none")
