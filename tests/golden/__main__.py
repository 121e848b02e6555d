"""Adds and refreshes golden cases: see `tests.golden`."""

import argparse
from pathlib import Path

from tests.golden.case import CASES, ORACLES, Case, Stored, all_cases, read_png


def add(args: argparse.Namespace) -> None:
    """A new case from picture files."""
    folder = args.cases / args.name
    if folder.exists():
        raise SystemExit(f"{folder} exists: choose another name, or edit its files and refresh it")
    if (args.source is None) != (args.tool == "fill"):
        raise SystemExit("clone and mix need --source, fill has none")
    pictures = tuple(read_png(path) for path in (args.destination, args.source) if path is not None)
    arguments = {
        "offset": tuple(args.offset) if args.offset else None,
        "mask_on": args.mask_on,
        "gradients": args.gradients,
        "monochrome": args.monochrome or None,
    }
    given = {key: value for key, value in arguments.items() if value is not None}
    Case(args.name, args.tool, pictures, read_png(args.mask), given).save(folder)
    size = sum(path.stat().st_size for path in folder.iterdir())
    print(f"added {folder}: {size / 1000:.1f} kB; look at its expected.png")


def refresh(args: argparse.Namespace) -> None:
    """The expected pictures of cases, all of them if none is named, made anew by the oracle."""
    for folder in [args.cases / name for name in args.names] or all_cases():
        Stored.load(folder).case.save(folder)
        print(f"refreshed {folder}")


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__)
    parser.add_argument(
        "--cases", type=Path, default=CASES, help="folder of the cases (default: %(default)s)"
    )
    commands = parser.add_subparsers(required=True)
    adder = commands.add_parser("add", help=add.__doc__)
    adder.add_argument("name")
    adder.add_argument("tool", choices=ORACLES)
    for picture in ("destination", "source", "mask"):
        adder.add_argument(f"--{picture}", type=Path, required=picture != "source", metavar="FILE")
    adder.add_argument("--offset", type=int, nargs=2, metavar=("ROW", "COL"))
    adder.add_argument("--mask-on", choices=["source", "destination"])
    adder.add_argument("--gradients", choices=["source", "average"])
    adder.add_argument("--monochrome", action="store_true")
    adder.set_defaults(run=add)
    refresher = commands.add_parser("refresh", help=refresh.__doc__)
    refresher.add_argument("names", nargs="*", metavar="NAME")
    refresher.set_defaults(run=refresh)
    args = parser.parse_args(argv)
    args.run(args)


if __name__ == "__main__":
    main()
