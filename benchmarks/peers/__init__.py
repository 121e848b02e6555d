"""One module per tool, all behind the same small interface: `Peer.prepare(case, limit)` -> `Prepared`.

`prepare` does once whatever a tool needs to be warm (imports, compilation, choosing a tolerance), `Prepared.run` is
what the clock sees, and `Prepared.answer` turns its result into an `Answer` off the clock.  A module offers its peers
as the tuple `PEERS`, and imports the tool itself only inside `prepare`.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any

from benchmarks.accuracy import Accuracy, Answer
from benchmarks.case import Case

MODULES = ("ours", "direct", "algebraic_multigrid", "conjugate_gradients", "opencv", "fpie_jacobi")

TARGET = (
    0.01  # levels: the largest error at which iterative peers may stop; ours has to be twenty times better
)


class Scope(Enum):
    """What the clock sees."""

    CLONE = "clone, uint8 -> uint8"  # from the three arrays to the finished picture
    SOLVE = "solve only"  # the equations are there, the values at the unknowns are wanted; set-up included


class Promise(Enum):
    """What must be true of an answer."""

    PICTURE = "the picture of a direct solve"
    VALUES = "the exact values, closely"
    IMPROVEMENT = "nearer to the exact picture than pasting is"


class TooSlowError(Exception):
    """One run would take longer than the limit; `seconds` is measured or extrapolated."""

    def __init__(self, seconds: float) -> None:
        super().__init__(f"one run takes about {seconds:.0f} s")
        self.seconds = seconds


@dataclass(frozen=True)
class Prepared:
    run: Callable[[], Any]
    answer: Callable[[Any], Answer]
    unrounded: Callable[[], Any] | None = (
        None  # the values (n, 3) in levels, of a tool that can be asked for them
    )


@dataclass(frozen=True)
class Peer:
    name: str
    scope: Scope
    promise: Promise
    prepare: Callable[[Case, float], Prepared]  # (case, seconds one run may take), may raise TooSlowError
    needs: tuple[str, ...] = ()  # modules that must be installed
    reference: bool = False  # the row that the others of its scope are compared to

    @property
    def missing(self) -> str | None:
        """The first module that is not installed."""
        return next((name for name in self.needs if importlib.util.find_spec(name) is None), None)


def every() -> Iterator[Peer]:
    """All peers, ours first."""
    for module in MODULES:
        yield from importlib.import_module(f"benchmarks.peers.{module}").PEERS


def reference(scope: Scope) -> Peer:
    """The row that the others of its scope are compared to."""
    return next(peer for peer in every() if peer.reference and peer.scope is scope)


def broken(promise: Promise, accuracy: Accuracy, pasted_rms: float) -> list[str]:
    """What was promised and not kept, a line each; `pasted_rms` is the error of pasting the source as it is."""
    if not math.isfinite(accuracy.largest):
        return ["values that are not finite"]
    if promise is Promise.IMPROVEMENT:
        if accuracy.rms < pasted_rms:
            return []
        return [f"rms error {accuracy.rms:.3g} levels, pasting has {pasted_rms:.3g}: called the wrong way?"]
    found = []
    if accuracy.outside:
        found.append(f"{accuracy.outside} pixels changed outside the region")
    allowed = TARGET + 0.5 * accuracy.rounded
    if accuracy.largest > allowed:
        found.append(f"largest error {accuracy.largest:.3g} levels, allowed {allowed}")
    if promise is Promise.PICTURE and accuracy.identical < 0.9999:
        found.append(f"{accuracy.identical:.4%} of the values identical after rounding, promised 99.99 %")
    return found
