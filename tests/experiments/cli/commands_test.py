#!/usr/bin/env python3
"""commands_test.py MSS: the tables of commands in experiments/README.md are the program's help (experiments/commands.py)."""

import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "experiments"))
sys.dont_write_bytecode = True
import commands  # noqa: E402

HELP = """turn a body
Usage: mss turn [OPTIONS] scene

Positionals:
  scene TEXT REQUIRED             A scene

Options:
  -h,--help                       Print this help message and exit
  --out TEXT=out/turn             Directory for the results
  --quick                         Smaller and fewer samples: about 6 s on two cores instead of 6 min
  --a-name-that-is-longer-than-the-column TEXT
                                  By how much, as in a|b

Exit status: 0 done.
"""
PAGE = f"""Before.
{commands.BEGIN}
| `mss turn scene` | turn a body | by hand |
| `mss spin scene` | is gone | by hand too |
{commands.END}
After.
"""


class Commands(unittest.TestCase):
    def test_help_is_read(self):
        turn = commands.Command("turn", HELP)
        self.assertEqual((turn.summary, turn.positionals), ("turn a body", [("scene TEXT REQUIRED", "A scene")]))
        self.assertEqual([commands.option_name(flags) for flags, _ in turn.options],
                         ["--out", "--quick", "--a-name-that-is-longer-than-the-column"])
        self.assertEqual(turn.options[2][1], "By how much, as in a|b")
        self.assertTrue(turn.is_study)

    def test_tables_are_written_and_differences_named(self):
        turn = [commands.Command("turn", HELP)]
        tables = commands.new_tables(turn, PAGE)
        self.assertIn("| `mss turn scene` | turn a body<br>`--out` `--quick`", tables)
        self.assertIn("| by hand |", tables)
        self.assertIn("| `--quick` | Smaller and fewer samples | all studies |", tables)
        self.assertIn("a\\|b", tables)
        self.assertNotIn("spin", tables)
        written = PAGE.replace(commands.tables_of(PAGE), tables)
        self.assertEqual(commands.differences(turn, written), [])
        changed = [commands.Command("turn", HELP.replace("A scene", "Another"))]
        self.assertEqual(len(commands.differences(changed, written)), 2)
        self.assertIn("Another", commands.differences(changed, written)[1])

    def test_ours_are_what_the_help_says(self):
        found = list(commands.all_commands(MSS))
        names = [command.name for command in found]
        self.assertGreater(len(names), 35)
        self.assertIn("peer score", names)
        self.assertEqual(commands.differences(found, commands.PAGE.read_text()), [],
                         "experiments/commands.py --write renews them")

    def test_exit_statuses_are_those_of_the_help(self):
        said = subprocess.run([MSS, "--help"], check=True, capture_output=True, text=True).stdout.split("Exit status:")[1]
        table = commands.PAGE.read_text().split("| exit status |")[1].split("\n\n")[0]
        rows = re.findall(r"^\| (\d+) \|", table, re.M)
        self.assertEqual(rows, re.findall(r"\b\d+\b", said))


if __name__ == "__main__":
    MSS = sys.argv.pop(1)
    unittest.main()
