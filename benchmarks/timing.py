"""Interleaved repeats: what the machine does meanwhile falls on every row alike.

Each round visits every task once, in an order that rotates by one per round, so that no task always runs in
the cache that the same neighbour leaves.  A visit is a short burst of calls, so that a task of milliseconds
gets as many samples as fit in `BURST` seconds and is measured warm, as it is used.
"""

from __future__ import annotations

import gc
import statistics
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

BURST = 0.1  # seconds of calls per visit
AT_LEAST = 3  # visits, whatever they cost, unless one call takes longer than the whole budget


@dataclass
class Timing:
    """Seconds of each call of one task, in the order they were made."""

    seconds: list[float] = field(default_factory=list)

    @property
    def median(self) -> float:
        return statistics.median(self.seconds)

    @property
    def fastest(self) -> float:
        return min(self.seconds)

    @property
    def slowest(self) -> float:
        return max(self.seconds)

    @property
    def runs(self) -> int:
        return len(self.seconds)

    def quartiles(self) -> tuple[float, float]:
        """First and third quartile; the only sample twice where there is one."""
        if self.runs == 1:
            return self.median, self.median
        first, _, third = statistics.quantiles(self.seconds, n=4, method="inclusive")
        return first, third


def interleave(
    tasks: Mapping[str, Callable[[], Any]],
    *,
    rounds: int,
    seconds: float,
    check: Callable[[str, Any], None],
) -> dict[str, Timing]:
    """Time every task `rounds` times over, interleaved.

    Parameters
    ----------
    tasks
        Name -> call without arguments.  A task warms itself up before it comes here.
    rounds
        Visits per task.
    seconds
        Budget per task: a task that has used it up sits out the later rounds, after `AT_LEAST` visits (one
        visit, if a single call is dearer than the budget).
    check
        Called with the name and the answer of the last call of every visit, off the clock.
    """
    timings = {name: Timing() for name in tasks}
    names = list(tasks)
    for visit in range(rounds):
        turn = visit % max(len(names), 1)
        for name in names[turn:] + names[:turn]:
            timing = timings[name]
            spent = sum(timing.seconds)
            if spent > seconds and (visit >= AT_LEAST or timing.fastest > seconds):
                continue
            check(name, _burst(tasks[name], timing))
    return timings


def _burst(task: Callable[[], Any], timing: Timing) -> Any:
    """Call `task` for about `BURST` seconds, at least once; the last answer."""
    gc.collect()
    gc.disable()
    try:
        left = BURST
        while True:
            start = perf_counter()
            answer = task()
            took = perf_counter() - start
            timing.seconds.append(took)
            left -= took
            if left < took:
                return answer
            del answer
    finally:
        gc.enable()
