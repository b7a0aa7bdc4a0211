#!/usr/bin/python3
"""protocol_test.py MSS SOURCES FOLDER: a solver of thirty lines follows experiments/peer/README.md, its results
are scored, and faults planted in them are named. Exit status 77: NumPy is missing."""
import csv
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as xml

try:
    import numpy as np
except ImportError:
    print("NumPy is not installed")
    sys.exit(77)

mss, sources, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
solver = sources / "reference/peers/thirty_lines.py"
limits = ["--error", "0.5%", "--volume", "0.1%", "--momentum", "0.5%", "--spin", "0.1%", "--energy", "1%"]

scene = """[body]
cells = [3, 3, 3]
cell_size = 0.1
[material]
density = 1000
young = 5e4
poisson = 0.25
[environment]
gravity = [0, 0, -9.81]
[start]
velocity = [1, 0, 2]
angular_velocity = [0, 3, 6]
[solve]
duration = 0.5
[expect]
displacement = { box = [[0, 0, 0], [0.3, 0.3, 0.3]], value = [0.5, 0, -0.22625], within = 1e-2 }
"""


def run(*arguments, status=0):
    """Runs mss; its stdout, or with exit status 2 its stderr."""
    ran = subprocess.run([mss, *map(str, arguments)], capture_output=True, text=True)
    assert ran.returncode == status, (arguments, ran)
    return ran.stderr if status > 1 else ran.stdout


def solve(export, name, step):
    subprocess.run([sys.executable, solver, export, folder / name, str(step)], check=True)
    return folder / name


def samples_of(result):
    rows = list(csv.DictReader(open(result / "samples.csv")))
    return np.array([[float(cell) for cell in row.values()] for row in rows])


def planted(result, name, change):
    """A copy of a result whose samples (t, id, x, y, z) are changed."""
    copy = folder / name
    shutil.copytree(result, copy, dirs_exist_ok=True)
    with open(copy / "samples.csv", "w") as file:
        writer = csv.writer(file)
        writer.writerow(["t", "id", "x", "y", "z"])
        writer.writerows([row[0], int(row[1]), *row[2:]] for row in change(samples_of(result)).tolist())
    return copy


def with_cost(result, name, **changes):
    """A copy of a result whose cost.json has other values."""
    copy = folder / name
    shutil.copytree(result, copy, dirs_exist_ok=True)
    cost = json.load(open(result / "cost.json"))
    (copy / "cost.json").write_text(json.dumps(cost | changes))
    return copy


def summary_of(export, *results, options=limits, status=0):
    return run("peer", "score", *results, "--scene", export, "--json", folder / "score.json", "--junit",
               folder / "score.xml", "--out", folder / "scores", *options, status=status)


def score(export, *results, options=limits, status=0):
    """The verdict as JSON, by folder."""
    summary_of(export, *results, options=options, status=status)
    told = json.load(open(folder / "score.json"))
    return {result["result"]: result for result in told["results"]}


def test_the_page_shows_the_solver():
    page = (sources / "experiments/peer/README.md").read_text()
    shown = re.findall(r"```python\n(.*?)```", page, re.S)
    assert solver.read_text() in shown, "experiments/peer/README.md and thirty_lines.py differ"


def test_tables_agree(export):
    """What a program reads makes one body: masses, weights, volumes, forces that cancel."""
    read = lambda name: np.genfromtxt(export / name, delimiter=",", names=True)
    p, s, h, t = (read(name) for name in ("particles.csv", "springs.csv", "hexahedra.csv", "tetrahedra.csv"))
    assert p.shape == (64,) and h.shape == (27,) and t.shape == (162,)
    assert abs(p["mass"].sum() - 27.0) < 1e-9
    x = np.stack([p["x"], p["y"], p["z"]], axis=1)
    ends = x[s["b"].astype(int)] - x[s["a"].astype(int)]
    assert np.allclose(np.linalg.norm(ends, axis=1), s["rest_length"])
    corners = [x[t[name].astype(int)] for name in "abcd"]
    volumes = np.einsum("ij,ij->i", np.cross(corners[1] - corners[0], corners[2] - corners[0]),
                        corners[3] - corners[0]) / 6
    assert np.allclose(volumes, 1e-3 / 6)
    lower = x[h["n0"].astype(int)]
    for corner in range(8):
        bits = np.array([corner & 1, corner >> 1 & 1, corner >> 2])
        assert np.allclose(x[h[f"n{corner}"].astype(int)], lower + 0.1 * bits)
    told = json.load(open(export / "scene.json"))
    assert told["format"] == "mss-peer-1" and told["cells"] == [3, 3, 3] and told["young"] == 5e4
    assert np.allclose(told["sample_times"], np.arange(31) / 60)
    # The energy of springs at the reference's end and its motion: what was there at the start.
    r = read("reference.csv").reshape(31, 64)

    def energy(k):
        x, v = (np.stack([r[k][c + a] for a in "xyz"], axis=1) for c in ("", "v"))
        stretch = np.linalg.norm(x[s["b"].astype(int)] - x[s["a"].astype(int)], axis=1) - s["rest_length"]
        return (s["stiffness"] * stretch**2).sum() / 2 + (p["mass"] * ((v**2).sum(1) / 2 + 9.81 * x[:, 2])).sum()

    assert abs(energy(30) / energy(0) - 1) < 1e-5, (energy(0), energy(30))


def test_the_solver_passes(export, good):
    told = score(export, good)["good"]
    assert told["verdict"] == "met" and told["velocities"] == "differences", told
    assert {check["name"] for check in told["checks"]} == {
        "samples", "error", "volume", "momentum", "spin", "energy", "expect displacement"}
    assert 0 < told["scores"]["error"] < 2e-3
    # The same error by NumPy: reference.csv and samples.csv have the same rows.
    reference = np.genfromtxt(export / "reference.csv", delimiter=",", skip_header=1)
    start = np.tile(reference[:64, 2:5], (31, 1))
    distance = np.linalg.norm(samples_of(good)[:, 2:5] - reference[:, 2:5], axis=1)
    largest = np.linalg.norm(reference[:, 2:5] - start, axis=1).max()
    assert math.isclose(told["scores"]["error"], math.sqrt((distance**2).mean()) / largest, rel_tol=1e-9)
    assert math.isclose(told["scores"]["worst_error"], distance.max() / largest, rel_tol=1e-9)
    assert (folder / "scores/scores.csv").exists() and (folder / "scores/scores.svg").exists()
    assert xml.parse(folder / "score.xml").getroot()[0].get("failures") == "0"
    run("peer", "score", good, "--scene", export, "--error", "1e-6", "--out", folder / "scores", status=1)


def centred(samples):
    """Samples by time and particle, and their centres: masses are not equal, but this is only a fault."""
    by_time = samples.reshape(31, 64, 5)
    return by_time, by_time[:, :, 2:].mean(axis=1, keepdims=True)


def test_faults_are_named(export, good):
    def swollen(samples):
        by_time, centres = centred(samples)
        by_time[1:, :, 2:] += 0.01 * (by_time[1:, :, 2:] - centres[1:])
        return by_time.reshape(-1, 5)

    def heavier(samples):
        samples[:, 4] -= 0.5 * samples[:, 0]**2  # g = 10.81
        return samples

    def late(samples):
        samples[:, 0] += 0.004
        return samples

    def slower(samples):
        """Turned back about the z axis through the centre, by a tenth of its spin."""
        by_time, centres = centred(samples)
        angle = -0.6 * by_time[:, :1, 0]
        c, s = np.cos(angle), np.sin(angle)
        x, y = (by_time[:, :, 2:4] - centres[:, :, :2]).transpose(2, 0, 1)
        by_time[:, :, 2] = centres[:, :, 0] + c * x - s * y
        by_time[:, :, 3] = centres[:, :, 1] + s * x + c * y
        return by_time.reshape(-1, 5)

    def with_nan(samples):
        samples[samples.shape[0] // 2, 3] = math.nan
        return samples

    def far(samples):
        samples[64 * 20:, 2] *= 1e4
        return samples

    # Row 1000 is of particle 1000 % 64 = 40 at sample 1000 // 64 = 15, t = 0.25.
    faults = {
        "swollen": (swollen, "volume 3"),
        "heavier": (heavier, "momentum"),
        "slower": (slower, "spin"),
        "late": (late, "samples are late by up to 0.004 s"),
        "missing": (lambda samples: np.delete(samples, 1000, axis=0), "particle 40 is missing at t = 0.25"),
        "twice": (lambda samples: np.insert(samples, 1000, samples[1000], axis=0),
                  "particle 40 is there twice at t = 0.25"),
        "foreign": (lambda samples: np.insert(samples, 1000, [0.25, 64, 0, 0, 0], axis=0),
                    "particle 64 at t = 0.25 is not one of the 64"),
        "nan": (with_nan, "NaN in particle 32 at t = 0.25"),
        "short": (lambda samples: samples[:64 * 20], "samples end before t = 0.333333"),
        "no_rows": (lambda samples: samples[:0], "samples end before t = 0"),
        "far": (far, "blown up at t = 0.333333"),
    }
    results = [planted(good, name, change) for name, (change, _) in faults.items()]
    told = score(export, good, *results, status=1)
    for name, (_, words) in faults.items():
        missed = [check["words"] for check in told[name]["checks"] if not check["met"]]
        assert any(part.startswith(words) for part in missed), (name, words, missed)
        assert told[name]["verdict"] == "missed"
    assert told["good"]["verdict"] == "met"
    assert abs(told["swollen"]["scores"]["volume_high"] / told["good"]["scores"]["volume_high"] - 1.01**3) < 1e-4
    assert xml.parse(folder / "score.xml").getroot()[0].get("failures") == str(
        sum(not check["met"] for result in told.values() for check in result["checks"]))
    rows = {row["result"]: row for row in csv.DictReader(open(folder / "scores/scores.csv"))}
    assert rows["nan"]["status"] == "NaN in particle 32 at t = 0.25" and rows["nan"]["error"] == ""


def test_steps_are_swept(export, good):
    results = [solve(export, f"step_{step}", step) for step in (0.004, 0.03)]
    score(export, good, *results, status=1)
    [row] = csv.DictReader(open(folder / "scores/stability.csv"))
    assert (row["steps"], row["largest_stable_step"], row["smallest_unstable_step"]) == ("3", "0.004", "0.03"), row
    told = lambda *results: summary_of(export, good, *results, status=1)
    # A step that was tried twice is one step.
    again = folder / "tried_again"
    shutil.copytree(results[1], again, dirs_exist_ok=True)
    assert "2 steps tried: stable up to 0.001 s, not at 0.03 s" in told(results[1], again)
    assert "steps tried" not in told(with_cost(good, "stopped", status="blew up at t = 0.2 s"))
    # The motion that blew up speaks of the step, a program that gave up for other reasons does not.
    assert "2 steps tried: stable up to 0.001 s, not at 0.002 s" in told(
        with_cost(good, "blown", step=0.002, status="blew up at t = 0.2 s"))
    assert "steps tried" not in told(with_cost(good, "unlicensed", step=0.002, status="there is no license"))


def test_programs_that_gave_up(export, good):
    """Their samples are not read; what they say reaches the terminal as one line."""
    gave_up = with_cost(good, "gave_up", status="no\n\x1b[31mconvergence")
    for write in (lambda file: file.write_text("t,id,x,y,z\n"), lambda file: file.write_text("half a li"),
                  lambda file: file.unlink()):
        write(gave_up / "samples.csv")
        printed = summary_of(export, good, gave_up, status=1)
        assert "  gave_up: missed: no  [31mconvergence\n" in printed and "1 missed" in printed, printed
    stepped = with_cost(good, "stepped", engine="thirty\x1blines", step=0.002)
    printed = summary_of(export, stepped, with_cost(stepped, "stepped_again", step=0.001), options=[])
    assert "  thirty lines, 2 steps tried" in printed, printed


def test_what_was_not_compared_is_said(export, good):
    no_limit = summary_of(export, good, options=[])
    assert "\n    met\n" in no_limit and "1 result: all met" in no_limit, no_limit  # the scene's [expect]
    (folder / "open.toml").write_text(scene.split("[expect]")[0])
    run("peer", "export", folder / "open.toml", "--out", folder / "open")
    printed = summary_of(folder / "open", good, options=[])
    assert "\n    complete; no limit was given\n1 result: complete; no limit was given\n" in printed, printed
    told = json.load(open(folder / "score.json"))
    assert told["verdict"] == told["results"][0]["verdict"] == "complete"
    assert "1 result: all met" in summary_of(folder / "open", good)
    # An end that is between samples; an expectation that the reference misses.
    (folder / "wrong.toml").write_text(scene.replace("-0.22625", "-0.3"))
    for name, options, why in (
            ("thrown", ["--every", "0.3"], "the last sample is at 0.3 s, the scene ends at 0.5 s"),
            ("wrong", [], "the reference misses it: wrong: displacement: should be")):
        run("peer", "export", folder / f"{name}.toml", *options, "--out", folder / f"{name}_open")
        result = good if name == "wrong" else solve(folder / "thrown_open", "good_until_0.3", 1e-3)
        printed = summary_of(folder / f"{name}_open", result, options=[])
        assert f"    not checked: displacement ({why}" in printed, printed
        assert "complete; no limit was given" in printed, printed
        [told] = json.load(open(folder / "score.json"))["results"]
        assert why in [check["words"] for check in told["checks"] if check["met"] is None][0], told
        suite = xml.parse(folder / "score.xml").getroot()[0]
        assert (suite.get("failures"), suite.get("skipped")) == ("0", "1")
        assert why in suite.find("testcase/skipped").get("message")
        [row] = csv.DictReader(open(folder / "scores/scores.csv"))
        assert why in row["not_checked"] and row["verdict"] == "complete" and row["missed"] == "", row


def test_costs_that_were_not_measured(export, good):
    free = with_cost(good, "free", cpu_seconds=0)
    assert "gives no processor time\n    met" in summary_of(export, free)
    told = score(export, free, good, options=["--budget", "1s/frame"], status=1)
    [missed] = [check["words"] for check in told["free"]["checks"] if not check["met"]]
    assert missed.startswith("gives no processor time, at most "), missed
    assert told["free"]["scores"]["cpu_ms_per_frame"] == 0 and told["good"]["verdict"] == "met"


def test_folders_of_one_name(export, good):
    again = folder / "again" / "good"
    shutil.copytree(good, again, dirs_exist_ok=True)
    assert set(score(export, good, again)) == {str(good), str(again)}
    run("redraw", folder / "scores")


def test_velocities_count_where_given(export, good):
    """Given velocities are believed: with wrong ones, momentum is wrong and nothing else."""
    copy = folder / "given"
    shutil.copytree(good, copy, dirs_exist_ok=True)
    reference = (export / "reference.csv").read_text()
    (copy / "samples.csv").write_text(reference)
    told = score(export, copy)["given"]
    assert told["velocities"] == "given" and told["scores"]["error"] == 0 and told["scores"]["spin_drift"] == 0
    rows = [line.split(",") for line in reference.splitlines()]
    faster = [rows[0]] + [row[:5] + [str(1.1 * float(row[5]))] + row[6:] for row in rows[1:]]
    (copy / "samples.csv").write_text("\n".join(",".join(row) for row in faster))
    told = score(export, copy, status=1)["given"]
    missed = [check["name"] for check in told["checks"] if not check["met"]]
    assert "momentum" in missed and "error" not in missed, missed


def test_planes(good):
    """A cube falls on the ground: a solver that knows no planes is told how deep it sank."""
    text = scene.split("[expect]")[0].replace("velocity = [1, 0, 2]\nangular_velocity = [0, 3, 6]", "velocity = [0, 0, -1]")
    (folder / "ground.toml").write_text(text + "[[plane]]\npoint = [0, 0, -0.2]\nnormal = [0, 0, 1]\n")
    export = folder / "ground"
    run("peer", "export", folder / "ground.toml", "--out", export)
    sunk = solve(export, "sunk", 1e-3)
    told = score(export, sunk, options=["--penetration", "1mm"], status=1)["sunk"]
    # v t + g t^2 / 2 = 1.726 m in half a second, of which 0.2 m are above the ground; the solver is of first order.
    assert abs(told["scores"]["penetration"] - 1.526) < 0.01, told
    assert "spin_drift" not in told["scores"] and "held_drift" not in told["scores"]
    assert told["scores"]["momentum_drift"] < 5e-3, told  # until it lands
    assert "its body does not turn" in run("peer", "score", sunk, "--scene", export, "--spin", "1%", status=2)


def test_bad_files_are_refused(export, good):
    refused = lambda *arguments: run("peer", *arguments, status=2)
    score_of = lambda result: refused("score", result, "--scene", export, "--out", folder / "scores")
    copy = folder / "bad"
    shutil.copytree(good, copy, dirs_exist_ok=True)
    (copy / "samples.csv").write_text("t,id,x,y\n0,0,0,0\n")
    assert "samples.csv:1: column z is missing" in score_of(copy)
    (copy / "samples.csv").write_text("t,id,x,y,z\n0,0,0,0,zero\n")
    assert "samples.csv:2: z = 'zero' is not a number" in score_of(copy)
    (copy / "samples.csv").unlink()
    assert "samples.csv" in score_of(copy)
    cost = json.load(open(good / "cost.json"))
    (copy / "cost.json").write_text(json.dumps(cost | {"status": "exploded at 0.1 s"}))
    told = score(export, copy, status=1)["bad"]
    assert told["status"] == "exploded at 0.1 s"
    (copy / "cost.json").write_text(json.dumps(cost | {"step": -1}))
    assert '"step" = -1 is not a positive number up to 1e+09' in score_of(copy)
    (copy / "cost.json").write_text(json.dumps(cost | {"threads": 0}))
    assert '"threads" = 0 is not a whole number from 1 to 1000000000, or null' in score_of(copy)
    (copy / "cost.json").write_text(json.dumps(cost | {"status": ""}))
    assert '"status" = "" is not a text of at least one character' in score_of(copy)
    (copy / "cost.json").write_text(json.dumps(cost | {"cpu_seconds": 1e308}))
    assert '"cpu_seconds" = 1e+308 is not a non-negative number' in score_of(copy)
    damaged = folder / "damaged"
    shutil.copytree(export, damaged, dirs_exist_ok=True)
    lines = (export / "reference.csv").read_text().splitlines()
    (damaged / "reference.csv").write_text("\n".join(lines[:-1] + ["0.5,63,nan,0,0,0,0,0"]))
    assert "reference.csv:1985: a number is not finite" in refused("score", good, "--scene", damaged)
    # Rows that changed places: the last of t = 0.483 and that of t = 0.5; the last two particles.
    for first, second, words in ((-65, -1, "reference.csv:1921: particle 63 at t = 0.5 is in the place of particle 63"),
                                 (-2, -1, "reference.csv:1984: particle 63 at t = 0.5 is in the place of particle 62")):
        moved = lines.copy()
        moved[first], moved[second] = moved[second], moved[first]
        (damaged / "reference.csv").write_text("\n".join(moved))
        assert words in refused("score", good, "--scene", damaged)
    assert "give `mss peer export` or `mss peer score`" in refused()
    assert "give one that `mss peer export` made" in refused("score", good, "--scene", folder / "nowhere")
    assert "is not a share" in refused("score", good, "--scene", export, "--error", "5mm")
    for name, words in {"fig5_1_twist": "hold.1 moves", "soft_blocks": "[[strike]]"}.items():
        assert words in refused("export", name, "--out", folder / name)
        assert not (folder / name).exists()


def main():
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    test_the_page_shows_the_solver()
    (folder / "thrown.toml").write_text(scene)
    export = folder / "export"
    run("peer", "export", folder / "thrown.toml", "--out", export)
    good = solve(export, "good", 1e-3)
    test_tables_agree(export)
    test_the_solver_passes(export, good)
    test_faults_are_named(export, good)
    test_steps_are_swept(export, good)
    test_programs_that_gave_up(export, good)
    test_what_was_not_compared_is_said(export, good)
    test_costs_that_were_not_measured(export, good)
    test_folders_of_one_name(export, good)
    test_velocities_count_where_given(export, good)
    test_planes(good)
    test_bad_files_are_refused(export, good)


main()
