"""How far a long solve has come: one line on a terminal, written over and wiped out at the end."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, TextIO

if TYPE_CHECKING:
    from poisson_cli.settings import Reporting, Solver

__all__ = ["DELAY", "INTERVAL", "Line", "Overwritten", "is_terminal", "shown"]

DELAY: Final = 0.5
"""Seconds before the first word: what takes less needs no progress."""

INTERVAL: Final = 0.1
"""Seconds between two words, at least."""


class Overwritten:
    """One line of a terminal that is written over and over.

    Parameters
    ----------
    stream
        A terminal.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._width = 0
        self._closed = False
        self._lock = threading.Lock()

    def write(self, text: str) -> None:
        """Write over what is there: with blanks, since not every terminal knows how to erase."""
        import shutil

        text = text[: shutil.get_terminal_size().columns - 1]
        with self._lock:
            if self._closed or not (text or self._width):
                return
            self._stream.write(f"\r{text:<{self._width}}" + ("" if text else "\r"))
            self._stream.flush()
            self._width = len(text)

    def close(self) -> None:
        """Wipe the line out; nothing is written after that."""
        self.write("")
        with self._lock:
            self._closed = True


class Line:
    """The line of one solve; call it after each step of a solver, from any thread.

    Parameters
    ----------
    stream
        A terminal.
    unit
        What is counted: ``"cycle"`` or ``"sweep"``.
    tolerance
        The error that the solver is to reach, in levels.
    clock
        Seconds, from any beginning.
    """

    def __init__(
        self, stream: TextIO, unit: str, tolerance: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._unit, self._tolerance, self._clock = unit, tolerance, clock
        self._due = clock() + DELAY
        self._first_error = math.inf
        self._line = Overwritten(stream)

    def __call__(self, iteration: int, error: float) -> None:
        """Say how far it has come, if the last word is old enough.

        Parameters
        ----------
        iteration
            Cycles or sweeps so far.
        error
            Estimated error in levels.
        """
        if not math.isfinite(self._first_error):
            self._first_error = error
        now = self._clock()
        if now >= self._due:
            self._due = now + INTERVAL
            self._line.write(
                f"solving: {self._done(error):3.0%}, {self._unit} {iteration:,}{self._about(error)}"
            )

    def close(self) -> None:
        """Wipe the line out; nothing is written after that."""
        self._line.close()

    def _done(self, error: float) -> float:
        """Share of the way: an iteration gains digits at a steady rate."""
        way = math.log(self._first_error / self._tolerance) if 0 < self._first_error < math.inf else 0.0
        if way <= 0 or not 0 < error < math.inf:
            return 0.0
        return min(max(math.log(self._first_error / error) / way, 0.0), 1.0)

    def _about(self, error: float) -> str:
        return f", error about {error:.1g} levels" if math.isfinite(error) else ""


def is_terminal(stream: TextIO) -> bool:
    """Whether a line can be written over there."""
    return stream.isatty() and os.environ.get("TERM") != "dumb"


@contextmanager
def shown(reporting: Reporting, solver: Solver) -> Iterator[Line | None]:
    """Show progress on stderr if that is a terminal and nobody asked for quiet.

    Parameters
    ----------
    reporting
        How much to say.
    solver
        What will run.

    Yields
    ------
    Line or None
        To be called after each step; None if nothing is to be shown.
    """
    stream = sys.stderr
    if reporting.quiet or not is_terminal(stream):
        yield None
        return
    line = Line(stream, "cycle" if solver.solver == "multigrid" else "sweep", solver.tolerance)
    try:
        yield line
    finally:
        line.close()
