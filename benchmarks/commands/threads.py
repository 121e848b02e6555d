"""`python -m benchmarks threads`: large disks with one thread and with several, turn by turn, and the same bits."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks import machine, pictures, shapes
from benchmarks.table import duration, render, three
from benchmarks.timing import interleave

Array = np.ndarray[Any, Any]

SIZES = (1_000_000, 4_000_000, 16_000_000)
HEADER = ("median", "min", "max", "runs", "faster (medians)", "faster (min)", "values that differ")


def run(arguments: Namespace) -> list[str]:
    print(machine.describe())
    print(
        "\nTime of a whole clone, uint8 -> uint8, disks in 3 channels, by number of threads, turn by turn.\n",
        flush=True,
    )
    wrong: list[str] = []
    for unknowns in (size for size in SIZES if size <= arguments.largest):
        wrong += _compare(unknowns, arguments)
    return wrong


def _compare(unknowns: int, arguments: Namespace) -> list[str]:
    """One size: prints its table, returns what went wrong."""
    import poisson_cli

    region = shapes.disk_of(unknowns)
    destination, source = pictures.destination(*region.shape), pictures.source(*region.shape)

    def clone(threads: int) -> Callable[[], Array]:
        return lambda: np.asarray(poisson_cli.clone(destination, source, region, threads=threads))

    tasks = {f"{n} thread{'s' if n > 1 else ''}": clone(n) for n in (1, *arguments.threads)}
    alone = "1 thread"
    expected = tasks[alone]()
    for task in tasks.values():
        task()  # warm-up: each number of threads has its own habits in memory
    differing = dict.fromkeys(tasks, 0)

    def check(name: str, image: Array) -> None:
        differing[name] = max(differing[name], int(np.count_nonzero(image != expected)))

    timings = interleave(tasks, rounds=arguments.rounds, seconds=arguments.seconds, check=check)
    one = timings[alone]
    rows = [
        [
            name,
            duration(timing.median),
            duration(timing.fastest),
            duration(timing.slowest),
            str(timing.runs),
            three(one.median / timing.median),
            three(one.fastest / timing.fastest),
            f"{differing[name]:,}",
        ]
        for name, timing in timings.items()
    ]
    print(render([f"{int(region.sum()):,} unknowns", *HEADER], rows, markdown=arguments.markdown), flush=True)
    print()
    return [
        f"{unknowns:,} unknowns, {name}: {count:,} values are not those of one thread"
        for name, count in differing.items()
        if count
    ]
