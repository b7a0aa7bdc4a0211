#!/usr/bin/env python3
"""The tables of all commands and their options in experiments/README.md are what the program's help says.

    experiments/commands.py [--mss FILE]            says which rows differ, with exit status 1
    experiments/commands.py --write [--mss FILE]    writes them again

The last column of the table of commands is written by hand: what the help does not say. It stays with its command. How long
studies take is left out, as it changes with every new measurement."""

import argparse
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "experiments/README.md"
BEGIN, END = "<!-- experiments/commands.py --write: from here -->", "<!-- to here -->"
DESCRIPTIONS = 34  # the column at which the help has them
MANY = 6  # names that a list may have before it is cut


class Command:
    """What `mss NAME --help` says: summary, positionals, options [(flags, description)], names of commands under it."""

    def __init__(self, name, text):
        self.name = name
        self.summary = text.split("\n", 1)[0]
        self.usage = re.search(r"^Usage: mss ?(.*)$", text, re.M)[1]
        self.positionals = entries(text, "Positionals")
        self.options = [(flags, said) for flags, said in entries(text, "Options") if "--help" not in flags]
        self.under = [flags for flags, _ in entries(text, "Subcommands")]
        self.is_study = any(flags == "--quick" and "samples" in said for flags, said in self.options)


def entries(text, title):
    """Names and descriptions of a section of a help text; a name that is long has its description on the next line."""
    section = re.search(rf"^{title}:\n((?:  .*\n)*)", text, re.M)
    found = []
    for line in section[1].splitlines() if section else ():
        if line.startswith(" " * DESCRIPTIONS) and found:
            found[-1][1] = (found[-1][1] + " " + line.strip()).strip()
        elif line[DESCRIPTIONS - 1:DESCRIPTIONS] == " ":
            found.append([line[:DESCRIPTIONS].strip(), line[DESCRIPTIONS:].strip()])
        else:
            found.append([line.strip(), ""])
    return [tuple(entry) for entry in found]


def help_of(mss, words):
    return subprocess.run([mss, *words, "--help"], check=True, capture_output=True, text=True).stdout


def all_commands(mss, words=()):
    """Those under `words`, each followed by the ones under it."""
    for name in Command(" ".join(words), help_of(mss, words)).under:
        command = Command(" ".join([*words, name]), help_of(mss, [*words, name]))
        yield command
        if command.under:
            yield from all_commands(mss, [*words, name])


def normal(flags, said):
    """Without what changes with measurements, and long lists cut."""
    said = re.sub(r": about .* on two cores instead of .*$", "", said)
    names = said.removeprefix("Some of ").split(", ")
    if said.startswith("Some of ") and len(names) > MANY:
        said = f"Some of {', '.join(names[:2])}, ...: its `--help` has all"
    flags = re.sub(r" (?:Needs|Excludes): \S+", "", flags)
    return re.sub(r"=out/\w+$", "=out/NAME", flags).replace(" REQUIRED", ""), said


def cell(text):
    return text.replace("|", "\\|").replace("<", "&lt;")


def option_name(flags):
    return re.split(r"[ =]", flags)[0]


def command_row(command, by_hand):
    words = re.sub(r"\[OPTIONS\] ?|\[SUBCOMMAND\]|SUBCOMMAND", "", command.usage).strip()
    names = [f"`{option_name(flags)}`" for flags, _ in command.options]
    said = cell(command.summary) + (f"<br>{' '.join(names)}" if names else "")
    return f"| `mss {words}` | {said} | {by_hand} |"


def option_rows(commands):
    """One row for each option that says the same, with the commands that take it."""
    studies = [command.name for command in commands if command.is_study and command.name != "reproduce"]
    takers = {}
    for command in commands:
        for flags, said in [*command.positionals, *command.options]:
            takers.setdefault(normal(flags, said), []).append(command.name)
    def of(names):
        left = [name for name in names if name not in studies]
        if not set(studies) <= set(names):
            left = names
        return ", ".join((["all studies"] if left is not names else []) + [f"`{name}`" for name in left])
    rows = [f"| `{flags}` | {cell(said)} | {of(names)} |" for (flags, said), names in takers.items()]
    return sorted(rows, key=lambda row: re.sub(r"[^a-z]", "", row.split("|")[1].lower()))


def written_by_hand(page):
    """The last column, by command."""
    cells = re.findall(r"^\| `mss ([^`]*)` \| .* \| (.*?) ?\|$", tables_of(page), re.M)
    return dict(cells)


def tables_of(page):
    return page.split(BEGIN)[1].split(END)[0]


def new_tables(commands, page):
    by_hand = written_by_hand(page)
    rows = []
    for command in commands:
        key = re.match(r"\| `mss ([^`]*)`", command_row(command, ""))[1]
        rows.append(command_row(command, by_hand.get(key, "")))
    return "\n".join(["\n", "| command | its help says; its options | and |", "|---|---|---|", *rows, "",
                      "| argument or option | is | of |", "|---|---|---|", *option_rows(commands), "\n"])


def differences(commands, page):
    """Rows that are only here, or only there."""
    old, new = tables_of(page).splitlines(), new_tables(commands, page).splitlines()
    return [f"not what the help says: {row}" for row in old if row not in new] + [
        f"missing: {row}" for row in new if row not in old]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--mss", default=ROOT / "build/release/mss")
    choice = parser.parse_args()
    page = PAGE.read_text()
    commands = list(all_commands(choice.mss))
    if choice.write:
        before, after = page.split(BEGIN)[0], page.split(END)[1]
        PAGE.write_text(before + BEGIN + new_tables(commands, page) + END + after)
        return 0
    problems = differences(commands, page)
    print("\n".join(problems), file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
