"""Adds and refreshes golden cases: see `tests.golden`."""

import argparse
import json
from pathlib import Path
from typing import Any

from tests.golden.case import CASES, ORACLES, WITH_SOURCE, WITHOUT_MASK, Case, Stored, all_cases, read_png


def add(args: argparse.Namespace) -> None:
    """A new case from picture files."""
    folder = args.cases / args.name
    if folder.exists():
        raise SystemExit(f"{folder} exists: choose another name, or edit its files and refresh it")
    if (args.source is not None) != (args.tool in WITH_SOURCE):
        raise SystemExit("clone and mix need --source, the other tools have none")
    if (args.mask is not None) != (args.tool not in WITHOUT_MASK):
        raise SystemExit("a tool needs --mask, unless it edits whole pictures")
    if (args.edges is not None) != (args.tool == "flatten"):
        raise SystemExit("flatten needs --edges, the other tools have none")
    pictures = tuple(read_png(path) for path in (args.destination, args.source) if path is not None)
    arguments = {
        "offset": tuple(args.offset) if args.offset else None,
        "mask_on": args.mask_on,
        "gradients": args.gradients,
        "monochrome": args.monochrome or None,
        "space": args.space,
        **dict(args.set),
    }
    given = {key: value for key, value in arguments.items() if value is not None}
    mask, edges = (None if path is None else read_png(path) for path in (args.mask, args.edges))
    Case(args.name, args.tool, pictures, mask, given, edges).save(folder)
    size = sum(path.stat().st_size for path in folder.iterdir())
    print(f"added {folder}: {size / 1000:.1f} kB; look at its expected.png")


def refresh(args: argparse.Namespace) -> None:
    """The expected pictures of cases, all of them if none is named, made anew by the oracle."""
    for folder in [args.cases / name for name in args.names] or all_cases():
        Stored.load(folder).case.save(folder)
        print(f"refreshed {folder}")


def argument(text: str) -> tuple[str, Any]:
    """NAME=JSON; a list becomes a tuple."""
    name, _, value = text.partition("=")
    parsed = json.loads(value)
    return name, tuple(parsed) if isinstance(parsed, list) else parsed


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__)
    parser.add_argument(
        "--cases", type=Path, default=CASES, help="folder of the cases (default: %(default)s)"
    )
    commands = parser.add_subparsers(required=True)
    adder = commands.add_parser("add", help=add.__doc__)
    adder.add_argument("name")
    adder.add_argument("tool", choices=ORACLES)
    for picture in ("destination", "source", "mask", "edges"):
        adder.add_argument(f"--{picture}", type=Path, required=picture == "destination", metavar="FILE")
    adder.add_argument("--offset", type=int, nargs=2, metavar=("ROW", "COL"))
    adder.add_argument("--mask-on", choices=["source", "destination"])
    adder.add_argument("--gradients", choices=["source", "average"])
    adder.add_argument("--monochrome", action="store_true")
    adder.add_argument("--space", choices=["linear", "lab"])
    adder.add_argument(
        "--set", type=argument, action="append", default=[], metavar="NAME=JSON", help="any other argument"
    )
    adder.set_defaults(run=add)
    refresher = commands.add_parser("refresh", help=refresh.__doc__)
    refresher.add_argument("names", nargs="*", metavar="NAME")
    refresher.set_defaults(run=refresh)
    args = parser.parse_args(argv)
    args.run(args)


if __name__ == "__main__":
    main()
