"""Put the current ``--help`` of every command into the README, or check that it is there.

Each text stands between two marks, and only what is between them is touched::

    <!-- help: clone -->
    <!-- end help -->

The name ``poisson`` marks the help of the program itself. Usage: ``python tools/readme_help.py [--check]``; with
``--check`` nothing is written, and a difference is shown and makes the exit code 1.
"""

from __future__ import annotations

import argparse
import difflib
import re
import sys
from pathlib import Path

import click

from poisson_cli.main import cli

README = Path(__file__).resolve().parent.parent / "README.md"
PROGRAM = "poisson"
COLUMNS = 88
BLOCK = re.compile(r"(?P<start><!-- help: (?P<name>[\w-]+) -->\n).*?(?P<end><!-- end help -->)", re.DOTALL)


def help_texts() -> dict[str, str]:
    """Name of every command, and of the program, to its help as a terminal of fixed width shows it."""
    program = click.Context(cli, info_name=PROGRAM, **{**cli.context_settings, "terminal_width": COLUMNS})
    texts = {PROGRAM: cli.get_help(program)}
    for name in cli.list_commands(program):
        command = cli.get_command(program, name)
        assert command is not None
        texts[name] = command.get_help(click.Context(command, info_name=name, parent=program))
    return texts


def with_current_help(document: str, texts: dict[str, str]) -> str:
    """The document with every marked block brought up to date; KeyError for the name of no command."""

    def block(match: re.Match[str]) -> str:
        name = match["name"]
        line = PROGRAM if name == PROGRAM else f"{PROGRAM} {name}"
        return f"{match['start']}```console\n$ {line} --help\n{texts[name].rstrip()}\n```\n{match['end']}"

    return BLOCK.sub(block, document)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--check", action="store_true", help="write nothing; fail if the README is out of date"
    )
    check = parser.parse_args().check

    texts = help_texts()
    old = README.read_text(encoding="utf-8")
    marked = {match["name"] for match in BLOCK.finditer(old)}
    if marked != set(texts):
        missing, unknown = sorted(set(texts) - marked), sorted(marked - set(texts))
        print(
            f"{README.name}: no block for {missing or 'nothing'}; blocks for unknown commands: {unknown or 'none'}"
        )
        return 1
    new = with_current_help(old, texts)
    if new == old:
        return 0
    if check:
        sys.stdout.writelines(
            difflib.unified_diff(old.splitlines(True), new.splitlines(True), README.name, "current --help")
        )
        print(f"{README.name} is out of date: run python tools/readme_help.py")
        return 1
    README.write_text(new, encoding="utf-8")
    print(f"{README.name}: brought up to date")
    return 0


if __name__ == "__main__":
    sys.exit(main())
