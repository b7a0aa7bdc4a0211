#!/usr/bin/env python3
"""Figures in texts are those of their tables (results/figures.py): planted mistakes are named, and there are none in ours."""

import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "results"))
sys.dont_write_bytecode = True
import figures  # noqa: E402

TABLE = """body,cells,error,seconds,status
beam,4,0.0763,2e-6,ok
beam,8,0.0221,9e-6,ok
"bar, long",8,1003,4e-3,ok
beam,16,,,stalled
"""


class Figures(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.text = pathlib.Path(self.folder.name) / "text.md"
        (self.text.parent / "b.csv").write_text(TABLE)

    def problem(self, shown, title, write=False):
        self.text.write_text(f'Seen: [{shown}](b.csv "{title}").')
        found, problems = figures.check(self.text, write)
        self.assertEqual(len(found), 1)
        return " ".join(problems)

    def queries(self, *rows):
        file = self.text.parent / "figures.csv"
        file.write_text("\n".join(("table,id,query", *rows)) + "\n")
        figures.rows_of.cache_clear()
        figures.queries_in.cache_clear()
        return file

    def test_right_ones_are_found(self):
        for shown, title in (
                ("7.6 and 2.2", "100 error where body=beam; cells<=8"), ("2 us [9]", "1e6 seconds where body=beam; cells=4|8"),
                ("2.2 to 7.6", "100 error where body=beam; status=ok"), ("1,003", "error where body=bar, long"),
                ("0.0763 in 2e-6 s", "error,seconds where cells=4"), ("0.08", "max error where body=beam; cells<16"),
                ("4.5", "seconds where body=beam; cells=8 over seconds where cells=4"),
                ("350 percent", "100 seconds where body=beam; cells=8 off seconds where cells=4"),
                ("50 percent", "abs 100 cells where cells=4 off cells where body=beam; cells=8"),
                ("2000", "max of seconds where status=ok over min of seconds where status=ok"), ("3", "count where body=beam"),
                ("1", "count where status!=ok")):
            self.assertEqual(self.problem(shown, title), "", title)

    def test_wrong_ones_are_named(self):
        for shown, title, said in (
                ("7.7", "100 error where cells=4", "7.63"), ("7.60", "100 error where cells=4", "7.63"),
                ("2.2", "100 error where body=beam; cells<=8", "7.63, 2.21"), ("2.2 to 7.7", "100 error where status=ok", "2.21"),
                ("0", "error where cells=16", "no number"), ("7.6", "100 eror where cells=4", "no column 'eror'"),
                ("7.6", "100 error where cells=5", "no row"), ("7.6", "100 error where cells", "no condition"),
                ("2", "count where body=beam", "3"), ("0", "count where body=beem", "no 'beem'")):
            self.assertIn(said, self.problem(shown, title), title)

    def test_are_written_with_as_many_digits(self):
        for shown, title, new in (
                ("9.9 and 9.9", "100 error where body=beam; cells<=8", "7.6 and 2.2"), ("1", "error where body=bar, long", "1,003"),
                ("1.11 to 2.22", "100 error where body=beam; status=ok", "2.21 to 7.63"),
                ("+9.9", "100 error where body=beam; cells=4", "+7.6"), ("0.9", "100 error where body=beam; cells=4", "7.6"),
                ("+1.1 to +2.2", "100 error where body=beam; status=ok", "+2.2 to +7.6")):
            self.assertEqual(self.problem(shown, title, write=True), "")
            self.assertIn(f"[{new}]", self.text.read_text())

    def test_have_their_queries_in_a_file(self):
        file = self.queries("b.csv,beam,100 error where body=beam; cells<=8", 'b.csv,long,"error where body=bar, long"',
                            "b.csv,old,error where cells=4")
        self.text.write_text("[7.6 and 2.2](b.csv#beam) of [1,003](b.csv#long) of [7](b.csv#long) of "
                             "[9](b.csv#none) [table](b.csv)")
        found, problems = figures.check(self.text, False, file)
        self.assertEqual([name for _, name in found], ["beam", "long", "long", "none"])
        self.assertEqual(len(problems), 2)
        self.assertIn("'7' is shown, and b.csv: the table says 1003", problems[0])
        self.assertIn("has no 'none'", problems[1])
        self.assertEqual([problem.split(": ")[1] for problem in figures.unused(found, file)], ["no text uses 'old' of b.csv"])
        self.text.write_text('[0.0763](b.csv "error where cells=4")')
        self.assertEqual([name for _, name in figures.check(self.text, False, file)[0]], ["old"])
        self.text.write_text("[1,003](b.csv#long) of [7](b.csv#long)")
        figures.check(self.text, True, file)
        self.assertIn("[1,003](b.csv#long) of [1,003](b.csv#long)", self.text.read_text())

    def test_no_two_queries_have_one_name(self):
        file = self.queries("b.csv,beam,count", "b.csv,beam,max cells")
        self.assertRaisesRegex(ValueError, "two queries 'beam'", figures.queries_in, file)

    def test_of_our_texts_are_those_of_the_tables(self):
        used = set()
        for name in figures.TEXTS:
            found, problems = figures.check(ROOT / name, False)
            self.assertEqual(problems, [])
            self.assertGreater(len(found), 0, name)
            used.update(found)
        self.assertEqual(figures.unused(used), [])

    def test_each_study_has_a_page_with_some(self):
        front = (ROOT / "results/README.md").read_text()
        folders = [path.parent.name for path in (ROOT / "results").glob("*/meta.json")]
        studies = [name for name in folders if name not in ("check", "reproduce")]
        self.assertGreaterEqual(len(studies), 17)
        for study in studies:
            self.assertTrue(figures.FIGURE.search((ROOT / f"results/{study}/README.md").read_text()), study)
            self.assertIn(f"]({study}/README.md)", front)


if __name__ == "__main__":
    unittest.main()
