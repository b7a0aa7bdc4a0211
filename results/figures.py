#!/usr/bin/env python3
"""Figures in texts are those of the tables that they link to.

    results/figures.py [TEXT ...]           names those that are not, with exit status 1
    results/figures.py --write [TEXT ...]   writes them again from their tables, with as many digits

TEXT is README.md, results/README.md, results/*/README.md, results/conclusions.md, reference/THESIS.md and
experiments/harness/TIMING.md if left out. A figure
is a link to a table, and to the row of results/figures.csv with its query: `[7.6 and 2.2](refine/refine.csv#beam)` is

    table,id,query
    refine/refine.csv,beam,abs 100 raw_error where problem=beam; cells=4|8

A query belongs to one table (paths are from results/), its id is only that table's, and several texts may use it; one that none
uses is named too. A link may also give the query as its title, `[7.6](refine/refine.csv "abs 100 raw_error where ...")`.

Its numbers are those of the table, in its order, each rounded to the digits shown; "A to B" are the smallest and the largest,
"A [B, C]" a median and its quartiles. Query: [min|max|median|sum] [abs] [factor] TERM [over|off TERM], or `count [where
conditions]`. TERM: [min of|max of|median of|sum of] column,column [where conditions]. A condition is a column, one of
= != >= <= > <, and a value, or several with bars between them; between conditions is "; ". `over` divides, row by row, or by the
one row there is; `off` is how far the quotient is from 1."""

import csv
import functools
import pathlib
import re
import statistics
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
QUERIES = ROOT / "results/figures.csv"
PAGES = sorted(f"results/{path.parent.name}/README.md" for path in ROOT.glob("results/*/README.md") if any(path.parent.glob("*.csv")))
TEXTS = "README.md", "results/README.md", *PAGES, "results/conclusions.md", "reference/THESIS.md", "experiments/harness/TIMING.md"
FIGURE = re.compile(r'\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^() #]+\.csv)(?:#([^() ]+)|\s+"([^"]*)")\)')
CONDITION = re.compile(r"(\w+)(!=|>=|<=|=|>|<)(.*)")
TERM = re.compile(r"(?:(min|max|median|sum) of )?(.*?)(?: where (.*))?")
QUERY = re.compile(r"(?:(min|max|median|sum) (?!of ))?(abs )?(?:([-+.0-9e]+) )?(.*)")
AGGREGATES = {"min": min, "max": max, "median": statistics.median, "sum": sum}
RELATIONS = {">=": lambda a, b: a >= b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, "<": lambda a, b: a < b}


@functools.cache
def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


@functools.cache
def queries_in(path):
    """By table and id."""
    queries = {}
    for row in rows_of(path):
        key = (path.parent / row["table"]).resolve(), row["id"]
        if key in queries:
            raise ValueError(f"{path}: {row['table']} has two queries '{row['id']}'")
        queries[key] = row["query"]
    return queries


def number(text):
    """A number, or None."""
    try:
        return float(text)
    except ValueError:
        return None


def compares(cell, relation, value):
    a, b = number(cell), number(value)
    if relation == "=":
        return cell == value if a is None or b is None else a == b
    return a is not None and b is not None and RELATIONS[relation](a, b)


def check_condition(table, condition):
    """Of the names that a condition gives one at least stands in the column: else it counts none, whatever happened."""
    part = CONDITION.fullmatch(condition)
    if not part or part[1] not in (table[0] if table else ()):
        raise ValueError(f"'{condition}' is no condition on {', '.join(table[0] if table else ())}")
    names = {row[part[1]] for row in table}
    if all(number(value) is None and value not in names for value in part[3].split("|")):
        raise ValueError(f"there is no '{part[3]}' under {part[1]}, only {', '.join(sorted(names)[:20])}")


def rows_where(table, conditions):
    """Rows that meet all conditions."""
    def meets(row, condition):
        part = CONDITION.fullmatch(condition)
        unequal = part[2] == "!="
        found = any(compares(row[part[1]], "=" if unequal else part[2], value) for value in part[3].split("|"))
        return found != unequal
    all_conditions = [condition for condition in (conditions or "").split("; ") if condition]
    for condition in all_conditions:
        check_condition(table, condition)
    return [row for row in table if all(meets(row, condition) for condition in all_conditions)]


def values_of(table, term):
    aggregate, columns, conditions = TERM.fullmatch(term).groups()
    rows = rows_where(table, conditions)
    if not rows:
        raise ValueError(f"no row for '{term}'")
    for column in columns.split(","):
        if column not in rows[0]:
            raise ValueError(f"there is no column '{column}', only {', '.join(rows[0])}")
    values = [number(row[column]) for row in rows for column in columns.split(",")]
    if None in values:
        raise ValueError(f"a row of '{term}' has no number")
    return [AGGREGATES[aggregate](values)] if aggregate else values


def evaluate(query, table):
    """The numbers that a query asks for."""
    if query == "count" or query.startswith("count where "):
        return [len(rows_where(table, query[len("count where "):]))]
    aggregate, absolute, factor, terms = QUERY.fullmatch(query).groups()
    two = re.fullmatch(r"(.*) (over|off) (.*)", terms)
    values = values_of(table, two[1] if two else terms)
    if two:
        divisors = values_of(table, two[3])
        if len(divisors) not in (1, len(values)):
            raise ValueError(f"{len(values)} values over {len(divisors)}")
        values = [a / divisors[i % len(divisors)] - (two[2] == "off") for i, a in enumerate(values)]
    if absolute:
        values = [abs(value) for value in values]
    values = [float(factor or 1) * value for value in values]
    return [AGGREGATES[aggregate](values)] if aggregate else values


def shown_numbers(text):
    """Numbers as a text shows them, and half a unit of the last digit of each."""
    text = re.sub(r"(\d),(?=\d{3}(?!\d))", r"\1", text)
    for part in re.finditer(r"-?\d+(?:\.(\d+))?(?:e(-?\d+))?", text):
        yield float(part[0]), 0.5 * 10.0 ** (int(part[2] or 0) - len(part[1] or ""))


def is_range(shown):
    return " to " in shown and len(list(shown_numbers(shown))) == 2


def problem_with(shown, values):
    """What is wrong with a figure; None if nothing is."""
    values = [min(values), max(values)] if is_range(shown) else values
    numbers = list(shown_numbers(shown))
    right = len(numbers) == len(values) and all(
        abs(value - number) <= half * (1 + 1e-9) + 1e-12 * abs(value) for value, (number, half) in zip(values, numbers))
    return None if right else "the table says " + ", ".join(f"{value:.6g}" for value in values)


def rounded(value, digits):
    """A number with so many significant digits."""
    if value == int(value) and abs(value) < 1e6:
        return f"{int(value):,}"
    exponent = int(f"{value:.{digits - 1}e}".split("e")[1])
    if not -4 < exponent < 6:
        mantissa, power = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa}e{int(power)}"
    decimals = digits - 1 - exponent
    return f"{value:.{decimals}f}" if decimals > 0 else f"{int(round(value)):,}"


def written(shown, values):
    """The figure with other values, in the form and with the digits that it has."""
    significant = [part.replace(".", "").lstrip("0") for part in re.findall(r"\d[\d.]*(?=e|\D|$)", shown.replace(",", ""))]
    digits = min(max(max(len(part) for part in significant), 2 if "." in shown else 1), 4)

    def signed(value):
        return "+" * ("+" in shown and value > 0) + rounded(value, digits)

    texts = [signed(value) for value in values]
    if is_range(shown):
        return f"{signed(min(values))} to {signed(max(values))}"
    if "[" in shown and len(texts) == 3:
        return "{} [{}, {}]".format(*texts)
    return texts[0] if len(texts) == 1 else ", ".join(texts[:-1]) + " and " + texts[-1]


def check(path, write, query_file=QUERIES):
    """The figures of a text, as table and id each (with a title, the id of the query that it is, or None), and the problems."""
    text, problems, figures = path.read_text(), [], []
    queries = queries_in(query_file) if query_file.exists() else {}
    names = {(table, query): name for (table, name), query in queries.items()}

    def visit(match):
        shown, link, name, query = match.groups()
        table = (path.parent / link).resolve()
        figures.append((table, name or names.get((table, " ".join(query.split())))))
        try:
            if not table.exists():
                raise ValueError("there is no such table")
            if name and (table, name) not in queries:
                raise ValueError(f"{query_file.name} has no '{name}' of it")
            query = queries[table, name] if name else " ".join(query.split())
            values = evaluate(query, rows_of(table))
            problem = problem_with(shown, values)
        except ValueError as error:
            problem, values = str(error), None
        if problem and write and values:
            return match[0].replace(f"[{shown}]", f"[{written(shown, values)}]", 1)
        if problem:
            line = text.count("\n", 0, match.start()) + 1
            problems.append(f"{path}:{line}: '{shown}' is shown, and {link}: {problem} ({query or name})")
        return match[0]

    new = FIGURE.sub(visit, text)
    if new != text:
        path.write_text(new)
    return figures, problems


def unused(used, query_file=QUERIES):
    """Queries that no text uses."""
    return [f"{query_file}: no text uses '{name}' of {table.name}"
            for table, name in queries_in(query_file) if (table, name) not in used]


def main(arguments):
    write = arguments[:1] == ["--write"]
    texts, used, failed = [pathlib.Path(name) for name in arguments[write:]], set(), False
    for text in texts or [ROOT / name for name in TEXTS]:
        figures, problems = check(text, write)
        used.update(figures)
        print(*problems, f"{text}: {len(figures)} figures, {len(problems)} wrong", sep="\n")
        failed = failed or problems or not figures
    left = [] if texts else unused(used)
    print(*left, sep="\n", end="\n" if left else "")
    return 1 if failed or left else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
