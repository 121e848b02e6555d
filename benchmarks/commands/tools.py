"""`python -m benchmarks tools`: every tool on a selection of 60,000 pixels, beside OpenCV's of the same purpose.

Ours and theirs take turns, each from arrays to the finished picture, one thread.  Every picture of ours is held
against the oracle of the tests: a sparse direct solve of the tool's own equations.  OpenCV solves other equations
(on the bounding box of the selection, its rim eroded, and by another guidance for some tools); of its pictures the
table tells how far they are from the exact one, and how many pixels they change outside the selection.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks import case, machine
from benchmarks.editing_cases import Row, every
from benchmarks.table import duration, render, three
from benchmarks.timing import Timing, interleave

Array = np.ndarray[Any, Any]

ALLOWED = 0.55  # levels: .05 for the values, half of one for their rounding

HEADER = (
    "tool",
    "ours",
    "largest error",
    "rms error",
    "changed outside",
    "OpenCV",
    "theirs",
    "theirs / ours",
    "their rms error",
    "they change outside",
)


def run(arguments: Namespace) -> list[str]:
    try:
        import cv2
    except ModuleNotFoundError:
        cv2 = None
    paper = case.paper()
    wanted = [
        row
        for row in every(paper, cv2)
        if not any(word.lower() in row.name.lower() for word in arguments.without)
    ]
    print(machine.describe())
    print(
        f"\nA disk of {paper.unknowns:,} pixels in 512 x 512, 3 channels, one thread; ours and theirs in turn, medians."
        "\nerror: levels, inside the selection, of the 8-bit picture against the exact one of the tool's equations (.5"
        "\nis perfect, its rms about .29); OpenCV's equations are others.  changed outside: pixels, should be 0.\n"
    )
    table, wrong = [], []
    for row in wanted:
        pictures: dict[str, Array] = {}
        for call in row.tasks.values():
            call()  # warm-up
        timings = interleave(
            row.tasks, rounds=arguments.rounds, seconds=arguments.seconds, check=_keep(pictures, wrong)
        )
        line, complaints = _line(row, pictures, timings)
        table.append(line)
        wrong += [f"{row.name}: {complaint}" for complaint in complaints]
    print(render(HEADER, table, markdown=arguments.markdown))
    if cv2 is None:
        print("left out: OpenCV is not installed")
    return wrong


def _keep(pictures: dict[str, Array], wrong: list[str]) -> Callable[[str, Array], None]:
    """Keeps each task's picture, and complains if a later run gives another."""

    def check(name: str, picture: Array) -> None:
        if not np.array_equal(pictures.setdefault(name, picture), picture):
            wrong.append(f"{name}: two runs gave different pictures")

    return check


def _line(row: Row, pictures: dict[str, Array], timings: dict[str, Timing]) -> tuple[list[str], list[str]]:
    exact = np.clip(row.exact(), 0, 255)

    def judged(picture: Array) -> tuple[float, float, int]:
        """Largest and rms error inside, pixels changed outside."""
        error = np.abs(picture[row.region] - exact[row.region])
        changed = (picture != row.before).any(axis=2) & ~row.region
        return float(error.max()), float(np.sqrt((error**2).mean())), int(changed.sum())

    largest, rms, outside = judged(pictures[row.name])
    mine = timings[row.name].median
    line = [row.name, duration(mine), three(largest), three(rms), f"{outside:,}"]
    wrong = []
    if not largest <= ALLOWED:
        wrong.append(f"largest error {largest:.3g} levels, allowed {ALLOWED}")
    if outside:
        wrong.append(f"{outside} pixels changed outside the selection")
    if row.theirs is None:
        return [*line, "none", "-", "-", "-", "-"], wrong
    _, their_rms, their_outside = judged(pictures[row.their_name])
    their = timings[row.their_name].median
    theirs = [row.their_name, duration(their), three(their / mine), three(their_rms), f"{their_outside:,}"]
    return line + theirs, wrong
