"""`python -m benchmarks [paper | tools | convergence | sizes | shapes | memory | startup | threads | batch]`.

One thread each, but for the last two; this module only parses and hands over.

Exit codes: 0 every answer was right, 1 some answer was wrong (the table says which), 2 usage.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path

# Read by the libraries when they are loaded, so set before anything imports numpy.
ONE_THREAD = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMBA_NUM_THREADS",
)


def parser() -> argparse.ArgumentParser:
    top = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Time poisson beside other tools, one thread each, and check every answer.",
        epilog="Without a command: paper.",
    )
    shared = argparse.ArgumentParser(add_help=False)
    shared.add_argument("--markdown", action="store_true", help="print tables for a README")

    timed = argparse.ArgumentParser(add_help=False)
    timed.add_argument(
        "--rounds", type=int, default=9, metavar="N", help="interleaved rounds (default: %(default)s)"
    )
    timed.add_argument(
        "--seconds",
        type=float,
        default=15.0,
        metavar="S",
        help="budget per row, three runs at least (default: %(default)s)",
    )

    peered = argparse.ArgumentParser(add_help=False)
    peered.add_argument(
        "--without",
        action="append",
        default=[],
        metavar="WORD",
        help="leave out rows with WORD in their name",
    )

    commands = top.add_subparsers(dest="command", metavar="COMMAND")
    paper = commands.add_parser(
        "paper",
        parents=[shared, timed, peered],
        help="the paper's case, a disk of 60,000 pixels in colour: everyone",
    )
    paper.add_argument("--slow", action="store_true", help="also run what takes more than a minute a time")
    commands.add_parser(
        "tools",
        parents=[shared, timed, peered],
        help="every tool on that disk, beside OpenCV's of the same purpose",
    )
    commands.add_parser("convergence", parents=[shared], help="convergence factor per region shape and cycle")
    shapes = commands.add_parser(
        "shapes", parents=[shared, timed], help="time and true error per region shape"
    )
    shapes.add_argument(
        "--unknowns", type=int, default=60_000, metavar="N", help="pixels per shape (default: %(default)s)"
    )
    sizes = commands.add_parser(
        "sizes", parents=[shared, timed, peered], help="figure: time against unknowns"
    )
    sizes.add_argument(
        "figure", type=Path, nargs="?", metavar="PNG", help="write the figure here (default: table only)"
    )
    sizes.add_argument(
        "--largest", type=int, default=4_000_000, metavar="N", help="unknowns (default: %(default)s)"
    )
    memory = commands.add_parser(
        "memory", parents=[shared], help="bytes beyond the pictures, per pixel, for a large disk"
    )
    memory.add_argument(
        "--megapixels", type=float, default=16.0, metavar="N", help="size of the crop (default: %(default)s)"
    )
    threads = commands.add_parser(
        "threads", parents=[shared, timed], help="1, 4 and 16 M unknowns with one thread and with several"
    )
    threads.add_argument(
        "--threads",
        type=int,
        nargs="+",
        default=[2],
        metavar="N",
        help="numbers to compare with one (default: 2)",
    )
    threads.add_argument(
        "--largest",
        type=int,
        default=16_000_000,
        metavar="N",
        help="leave out larger sizes (default: %(default)s)",
    )
    startup = commands.add_parser(
        "startup", parents=[shared], help="whole processes: a clone, the help, the first run"
    )
    startup.add_argument(
        "--rounds", type=int, default=15, metavar="N", help="interleaved rounds (default: %(default)s)"
    )
    batch = commands.add_parser(
        "batch", parents=[shared], help="many small jobs: one batch, and a loop of commands"
    )
    batch.add_argument("--jobs", type=int, default=2_000, metavar="N", help="jobs (default: %(default)s)")
    batch.add_argument(
        "--loop", type=int, default=50, metavar="N", help="of them, as single commands (default: %(default)s)"
    )
    batch.add_argument(
        "--rounds", type=int, default=3, metavar="N", help="interleaved rounds (default: %(default)s)"
    )
    return top


def main(argv: list[str]) -> int:
    options_only = all(word.startswith("-") for word in argv[:1]) and argv[:1] not in (["-h"], ["--help"])
    arguments = parser().parse_args(["paper", *argv] if options_only else argv)
    for variable in ONE_THREAD:
        os.environ[variable] = "1"
    os.environ["ENABLE_TAICHI_HEADER_PRINT"] = (
        "0"  # fpie imports taichi where it is installed; it greets on stdout
    )
    command = importlib.import_module(f"benchmarks.commands.{arguments.command}")
    try:
        wrong: list[str] = command.run(arguments)
    except ModuleNotFoundError as missing:
        print(f"benchmarks: {missing.name} is not installed: pip install '.[bench]'", file=sys.stderr)
        return 2
    for line in wrong:
        print(f"WRONG: {line}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
