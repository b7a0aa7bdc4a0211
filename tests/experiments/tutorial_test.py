#!/usr/bin/env python3
"""tutorial_test.py MSS SOURCES FOLDER: what experiments/tutorial/README.md shows happens, run in FOLDER.

A block of sh is run; the block of text below it has lines of what it prints, in this order; others may stand between.
Numbers may differ by 1e-3 of their size, or where comments before the block say so:

    <!-- differs: REGEX; REGEX -->      numbers in what these match are not compared
    <!-- an example: why -->            the block is not compared at all
    <!-- matches: REGEX -->             what is printed has a match

A block that needs what is not installed (xvfb-run, gnuplot, NumPy), or a window where the program was built without, is left
out, and named."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

CLOSE = 1e-3
PART = re.compile(r"((?:^<!--[^\n]*-->\n)*)^```(sh|text)\n(.*?)^```$", re.M | re.S)
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


def close(a, b):
    return abs(float(a) - float(b)) <= CLOSE * max(abs(float(a)), abs(float(b))) + 1e-12


def same(shown, printed, differs):
    """Whether lines are the same but for rounding and for what differs."""
    for pattern in differs:
        shown, printed = (re.sub(pattern, lambda m: NUMBER.sub("~", m[0]), line) for line in (shown, printed))
    words = [re.sub(r"\s+", " ", NUMBER.sub("#", line)).strip() for line in (shown, printed)]
    numbers = [NUMBER.findall(line) for line in (shown, printed)]
    return words[0] == words[1] and all(map(close, *numbers))


def missing_lines(text, printed, differs):
    """Lines of a block that are not printed, in its order."""
    left, missing = iter(printed.splitlines()), []
    for line in text.splitlines():
        before = list(left)
        found = next((i for i, other in enumerate(before) if same(line, other, differs)), None)
        if found is None:
            missing.append(line)
        left = iter(before if found is None else before[found + 1:])
    return missing


def problems(notes, text, printed):
    """Of a block of text with the comments before it."""
    remarks = re.findall(r"<!-- ([\w ]+): (.*) -->", notes)
    differs = [pattern for kind, said in remarks if kind == "differs" for pattern in said.split("; ")]
    found = [f"no match of {said}" for kind, said in remarks if kind == "matches" and not re.search(said, printed)]
    if not any(kind == "an example" for kind, _ in remarks):
        found += [f"not printed: {line}" for line in missing_lines(text, printed, differs)]
    return found


def lacks(block):
    """What a block needs and this system has not; None if it has all."""
    if "mss view" in block and os.environ.get("MSS_HAS_WINDOW") == "0":
        return "the window"
    draws = any(f"mss {command}" in block for command in ("precision", "advise", "check-mesh", "peer score"))
    for program, is_used in (("xvfb-run", "xvfb-run" in block), ("gnuplot", draws)):
        if is_used and not shutil.which(program):
            return program
    imports_numpy = ["/usr/bin/python3", "-c", "import numpy"]
    if "thirty_lines.py" in block and subprocess.run(imports_numpy, capture_output=True).returncode != 0:
        return "NumPy of /usr/bin/python3"
    return None


class Tutorial(unittest.TestCase):
    def test_planted_mistakes_are_found(self):
        shown = "a: ok after 12 steps, in 0.5 s\nb: 2e-3 m\n"
        notes = "<!-- differs: in [\\d.]+ s -->\n"
        self.assertEqual(problems(notes, shown, "a: ok after 12 steps, in 0.7 s\nmore\nb:  0.002 m\n"), [])
        first, second = shown.splitlines()
        for printed in (f"{first.replace('12', '13')}\n{second}", f"{second}\n{first}", second, f"{first}\nb: 2.1e-3 m",
                        f"{first.replace('ok', 'not ok')}\n{second}"):
            self.assertEqual(len(problems(notes, shown, printed)), 1, printed)
        self.assertEqual(len(problems("", shown, shown.replace("0.5", "0.7"))), 1)
        example = "<!-- an example: why -->\n<!-- matches: error [\\d.]+ % -->\n"
        self.assertEqual(problems(example, "anything", "error 5 %"), [])
        self.assertEqual(len(problems(example, "anything", "error none")), 1)

    def test_all_blocks_do_as_shown(self):
        page = (SOURCES / "experiments/tutorial/README.md").read_text()
        parts = PART.findall(page)
        self.assertGreater(sum(kind == "sh" for _, kind, _ in parts), 10)
        self.assertGreater(sum(kind == "text" for _, kind, _ in parts), 9)
        self.assertEqual(len(parts), page.count("\n```") // 2)
        self.assertEqual(len(re.findall(r"^## \d\. ", page, re.M)), 6)
        printed = None
        for notes, kind, block in parts:
            if kind == "text":
                if printed is not None:
                    self.assertEqual(problems(notes, block, printed), [], f"of what was printed:\n{printed}")
                continue
            if lack := lacks(block):
                print(f"left out, without {lack}: {block}")
                printed = None
                continue
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", block], cwd=FOLDER, env=ENVIRONMENT, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            printed = done.stdout
            self.assertEqual(done.returncode, 0, f"{block}\nprinted:\n{printed}")


if __name__ == "__main__":
    FOLDER, SOURCES, MSS = (pathlib.Path(sys.argv.pop()).resolve() for _ in range(3))
    shutil.rmtree(FOLDER, ignore_errors=True)
    (FOLDER / "build/release").mkdir(parents=True)
    (FOLDER / "build/release/mss").symlink_to(MSS)
    for folder in ("experiments", "reference"):
        (FOLDER / folder).symlink_to(SOURCES / folder)
    ENVIRONMENT = {**os.environ, "PATH": f"{FOLDER}/build/release:{os.environ['PATH']}"}
    unittest.main()
