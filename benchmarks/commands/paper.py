"""`python -m benchmarks`: the paper's case, a disk of 60,000 pixels, 3 channels, everyone in one table."""

from __future__ import annotations

from argparse import Namespace

from benchmarks import case, cold, field, machine, peers
from benchmarks.field import Entry, Results
from benchmarks.peers import Scope, TooSlowError
from benchmarks.table import duration, render, three

SLOW = 60.0  # seconds for one run, above which `--slow` must be asked for

HEADER = (
    "tool",
    "median",
    "min",
    "max",
    "runs",
    "x ours",
    "largest error",
    "rms error",
    "identical",
    "changed outside",
)


def run(arguments: Namespace) -> list[str]:
    paper = case.paper()
    results = field.run(
        [(paper, peer) for peer in field.wanted(peers.every(), arguments.without, *Scope)],
        rounds=arguments.rounds,
        seconds=arguments.seconds,
        limit=float("inf") if arguments.slow else SLOW,
    )
    print(machine.describe())
    print(
        f"\nA disk of {paper.unknowns:,} pixels in 512 x 512, 3 channels, one thread, one run, interleaved."
        "\nerror: levels, inside the disk, against the exact solution of eq. (7), both clipped to 0..255, as"
        f"\n{paper.out_of_range:.2%} of it needs.  *: of the rounded picture, all that the tool shows: .5 is perfect."
        "\nidentical: 8-bit values inside that equal the exact ones rounded.  changed outside: pixels, should be 0.\n"
    )
    rows = []
    for scope in Scope:
        rows.append([f"-- {scope.value} --"] + [""] * (len(HEADER) - 1))
        rows += [_row(entry, results) for entry in results.entries if entry.peer.scope is scope]
    print(render(HEADER, rows, markdown=arguments.markdown))
    print(_passes(paper.unknowns, results))
    for name, why in results.left_out.items():
        print(f"left out: {name}: {why}{', --slow runs it' if isinstance(why, TooSlowError) else ''}")
    return results.wrong


def _row(entry: Entry, results: Results) -> list[str]:
    timing, accuracy = entry.timing, entry.accuracy
    star = "*" if accuracy.rounded else " "
    return [
        entry.peer.name,
        duration(timing.median),
        duration(timing.fastest),
        duration(timing.slowest),
        str(timing.runs),
        three(results.ratio(entry)),
        f"{_error(accuracy.largest)}{star}",
        f"{_error(accuracy.rms)}{star}",
        f"{_percent(accuracy.identical)} %",
        f"{accuracy.outside:,}",
    ]


def _passes(unknowns: int, results: Results) -> str:
    """Our solve alone in cold passes over its own x and b (`cold`)."""
    ours = next((e for e in results.entries if e.peer.reference and e.peer.scope is Scope.SOLVE), None)
    if ours is None:
        return ""
    one = cold.pass_over(3 * unknowns)
    return (
        f"\nours, solve only: {three(ours.timing.median / one.median)} cold passes over its own x and b"
        f"\n(one pass: read b, read and write x, {3 * unknowns:,} float32 each, caches flushed: "
        f"{duration(one.median)}, from {duration(one.fastest)} to {duration(one.slowest)})"
    )


def _error(levels: float) -> str:
    return f"{levels:.1e}" if levels < 1e-3 else three(levels)


def _percent(share: float) -> str:
    """Rounded down, so that 100 means all."""
    return f"{int(share * 1e5) / 1e3:.3f}" if share < 1 else "100"
