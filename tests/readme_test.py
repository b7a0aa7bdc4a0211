#!/usr/bin/env python3
"""Texts lead somewhere: links and pictures are there, README.md's commands are run.sh's, and its first screen needs no
glossary."""

import json
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[1]
TEXTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("*/README.md"), *ROOT.glob("core/*/README.md"),
                *ROOT.glob("integrators/*/README.md"), *ROOT.glob("experiments/*/*.md"), *ROOT.glob("reference/*/README.md"),
                ROOT / "core/GLOSSARY.md", ROOT / "reference/THESIS.md"])
LINK = re.compile(r'\]\(([^()\s]+)(?:\s+"[^"]*")?\)|\bsrc="([^"]+)"')
# Words of the glossary that the first screen uses as it explains them.
EXPLAINED = {"cell", "spring", "thesis", "sheet", "rope"}
TEXTS += [*sorted(ROOT.glob("results/*/README.md")), ROOT / "results/conclusions.md"]


def prose(text):
    """Without code, in which brackets are no links."""
    return re.sub(r"```.*?```|`[^`\n]*`|^    .*?$", "", text, flags=re.S | re.M)


def anchors(text):
    """Of headings, as GitHub names them."""
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.S), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def wrong_links(file):
    links = [a or b for a, b in LINK.findall(prose(file.read_text()))]
    wrong = []
    for link in links:
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = (file.parent / path) if path else file
        is_figure = path.endswith(".csv")  # whose anchor is a query's name: results/figures.py
        if not target.exists() or (anchor and not is_figure and anchor not in anchors(target.read_text())):
            wrong.append(link)
    return links, wrong


def first_screen():
    return (ROOT / "README.md").read_text().split("\n## What came out")[0]


def glossary():
    """Its words; a row may have several, and kinds after a colon."""
    table = (ROOT / "core/GLOSSARY.md").read_text()
    rows = [row.split("|")[1] for row in table.splitlines() if row.startswith("| ")][1:]
    return {word.strip() for row in rows for word in row.split(":")[0].split(",")}


class Readme(unittest.TestCase):
    def test_links_lead_somewhere(self):
        count = 0
        for file in TEXTS:
            links, wrong = wrong_links(file)
            count += len(links)
            self.assertEqual(wrong, [], file)
        self.assertGreater(count, 100)

    def test_wrong_links_are_found(self):
        self.assertEqual(LINK.findall('[a](b/c.csv "1 d") <img src="e.png">'), [("b/c.csv", ""), ("", "e.png")])
        self.assertEqual(anchors("## frames: `mss frames --out a/b`\n"), {"frames-mss-frames---out-ab"})

    def test_first_screen_is_one_and_needs_no_glossary(self):
        lines = first_screen().splitlines()
        self.assertLess(len(lines), 50)
        words = glossary() - EXPLAINED
        self.assertIn("fold guard", words)
        self.assertIn("sweep", words)
        screen = re.sub(r"\]\([^)]*\)", "]", first_screen())
        self.assertEqual([word for word in words if re.search(rf"\b{re.escape(word)}s?\b", screen, re.I)], [])

    def test_first_screen_shows_bodies(self):
        pictures = re.findall(r'src="results/view/(\w+)\.png"', first_screen())
        self.assertGreater(len(pictures), 2)
        script = (ROOT / "results/view/run.sh").read_text()
        for picture in pictures:
            self.assertRegex(script, rf"(?m)^body {picture} ")
        for picture in (ROOT / "results/view").glob("*.png"):
            self.assertRegex(script, rf"(?m)^(body|view) {picture.stem} ")

    def test_is_short(self):
        lines = (ROOT / "README.md").read_text().splitlines()
        self.assertLessEqual(len(lines), 150)
        self.assertLessEqual(max(map(len, lines)), 400)

    def test_findings_have_charts_and_figures(self):
        rows = re.findall(r"^\| <a href=.*$", (ROOT / "README.md").read_text(), re.M)
        self.assertEqual(len(rows), 6)
        for row in rows:
            self.assertRegex(row, r'<a href="(results/[^"]*\.png)"><img src="\1"')
            self.assertRegex(row, r'\]\(results/\S*\.csv#')

    def test_ten_commands_are_commands(self):
        block = (ROOT / "README.md").read_text().split("## Ten commands\n")[1].split("\n##")[0]
        shown = re.findall(r"^    build/release/mss ([a-z-]+)", block, re.M)
        known = re.findall(r"^\| `mss ([a-z-]+)", (ROOT / "experiments/README.md").read_text(), re.M)
        self.assertEqual(len(shown), 10)
        self.assertEqual([word for word in shown if word not in known], [])
        scenes = re.findall(r"mss (?:view|run|modes|advise|peer export) (\w+)", block)
        self.assertEqual(len(scenes), 6)
        for scene in scenes:
            self.assertTrue((ROOT / f"experiments/scenes/{scene}.toml").exists(), scene)

    def test_nothing_ran_beside_the_studies(self):
        """As TIMING.md says, counted by each study itself; advice counts processor time, and `check` has no times."""
        shares = {}
        for file in (ROOT / "results").glob("*/meta.json"):
            if file.parent.name not in ("advise", "check", "reproduce"):
                shares[file.parent.name] = json.loads(file.read_text())["provenance"]["other_work"]["share"]
        self.assertGreater(len(shares), 20)
        self.assertIn("other work took at most a hundredth of the cores in any study", (ROOT / "experiments/harness/TIMING.md").read_text())
        self.assertEqual({name: share for name, share in shares.items() if share > 0.01}, {})

    def test_results_are_of_one_commit(self):
        """As results/README.md says; baselines are promoted one by one."""
        commits = {json.loads(file.read_text())["provenance"]["commit"]
                   for file in (ROOT / "results").rglob("meta.json") if file.parent.name != "check"}
        self.assertEqual(len(commits), 1)
        self.assertIn("All are of one commit", (ROOT / "results/README.md").read_text())

    def test_commands_are_those_of_run_sh(self):
        refused = subprocess.run([ROOT / "run.sh", "no such command"], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        commands = set(re.findall(r"\./run\.sh (\w+)", refused.stderr))
        self.assertEqual(commands, {"build", "reproduce", "test"})
        self.assertEqual(set(re.findall(r"(?m)^    \./run\.sh (\w+)", first_screen())), commands)
        too_many = subprocess.run([ROOT / "run.sh", "build", "--quick"], capture_output=True, text=True)
        self.assertEqual((too_many.returncode, too_many.stderr), (2, refused.stderr))

    def test_scenes_that_run_sh_suggests_are_there(self):
        for text in (first_screen(), (ROOT / "run.sh").read_text()):
            scenes = re.findall(r"mss (?:view|run) ([a-z]\w+)", text)
            self.assertGreaterEqual(len(scenes), 2)
            for scene in scenes:
                self.assertTrue((ROOT / f"experiments/scenes/{scene}.toml").exists(), scene)


if __name__ == "__main__":
    unittest.main()
