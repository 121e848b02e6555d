"""`python -m benchmarks sizes FIGURE`: time against unknowns on disks from 1,000 pixels up.

A tool is left out from the size on at which one of its runs takes more than `LIMIT` seconds, or would if its time grew
no faster than the unknowns.  Ours runs to the end.
"""

from __future__ import annotations

from argparse import Namespace
from collections import defaultdict
from pathlib import Path
from typing import Any

from benchmarks import case, field, machine, peers, shapes
from benchmarks.field import Entry
from benchmarks.peers import Scope
from benchmarks.table import duration, render, three

LIMIT = 20.0  # seconds for one run
SMALLEST, STEP = 1_000, 4
VISIBLE = 0.51  # levels: an error above this is not the exact picture rounded

Points = list[tuple[int, Entry]]


def run(arguments: Namespace) -> list[str]:
    print(machine.describe())
    print(
        "\nTime of a whole clone, uint8 -> uint8, disks in 3 channels, one thread, every answer checked.\n",
        flush=True,
    )
    going = field.wanted(peers.every(), arguments.without, Scope.CLONE)
    curves: dict[str, Points] = defaultdict(list)
    wrong: list[str] = []
    steps = sizes(arguments.largest)
    for unknowns, following in zip(steps, [*steps[1:], 0], strict=True):
        disk = case.of_region(shapes.disk_of(unknowns), f"{unknowns:,} unknowns")
        results = field.run(
            [(disk, peer) for peer in going],
            rounds=arguments.rounds,
            seconds=arguments.seconds,
            limit=LIMIT,
        )
        rows = [_row(entry, results.ratio(entry)) for entry in results.entries]
        print(render([f"{disk.unknowns:,} unknowns", *HEADER], rows, markdown=arguments.markdown))
        for name, why in results.left_out.items():
            print(f"left out from here on: {name}: {why}")
        wrong += results.wrong

        going = []
        for entry in results.entries:
            curves[entry.peer.name].append((disk.unknowns, entry))
            expected = entry.timing.median * following / unknowns
            if entry.peer.reference or expected <= LIMIT:
                going.append(entry.peer)
            else:
                print(
                    f"left out above: {entry.peer.name}: the next size would take {duration(expected)} at least"
                )
        print(flush=True)
        if arguments.figure:  # each time, so that a long run leaves what it got to
            draw(curves, arguments.figure)
    return wrong


HEADER = ("median", "min", "max", "runs", "x ours", "ns/unknown/channel", "largest error", "changed outside")


def _row(entry: Entry, ratio: float) -> list[str]:
    timing, accuracy = entry.timing, entry.accuracy
    return [
        entry.peer.name,
        duration(timing.median),
        duration(timing.fastest),
        duration(timing.slowest),
        str(timing.runs),
        three(ratio),
        three(entry.nanoseconds),
        three(accuracy.largest) + ("*" if accuracy.rounded else " "),
        f"{accuracy.outside:,}",
    ]


def sizes(largest: int) -> list[int]:
    """1,000, times four each, and `largest` itself."""
    found = []
    unknowns = SMALLEST
    while unknowns < largest / 1.5:
        found.append(unknowns)
        unknowns *= STEP
    return [*found, largest]


def draw(curves: dict[str, Points], path: Path) -> None:
    """Logarithmic axes; bars from the first to the third quartile; hollow where the picture is not the exact one."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(8, 5.5), dpi=150)
    for colour, (name, points) in enumerate(curves.items()):
        _curve(axes, name, points, f"C{colour}")
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="unknown pixels (disk, 3 channels)",
        ylabel="seconds for one clone, one thread",
    )
    axes.grid(True, which="major", alpha=0.3)
    axes.set_title("Seamless cloning, uint8 in to uint8 out (hollow: not the exact picture)", fontsize=10)
    axes.legend(fontsize=8, frameon=False)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def _curve(axes: Any, name: str, points: Points, colour: str) -> None:
    sizes_ = [unknowns for unknowns, _ in points]
    medians = [entry.timing.median for _, entry in points]
    bars = [
        [abs(entry.timing.quartiles()[side] - entry.timing.median) for _, entry in points] for side in (0, 1)
    ]
    ours = name.startswith("ours")
    axes.errorbar(
        sizes_, medians, bars, color=colour, lw=2 if ours else 1.2, capsize=2, ls="-" if ours else "--", label=name
    )  # fmt: skip
    for unknowns, entry in points:
        exact = entry.accuracy.largest <= VISIBLE
        face = colour if exact else "white"
        axes.plot(unknowns, entry.timing.median, "o", ms=5, color=colour, markerfacecolor=face)
