"""Staying answerable during long computations.

Python runs signal handlers on the main thread only, and only between two of its own instructions: a compiled call that
takes a second is deaf for a second. So the main thread hands long work to another one and does nothing but wait,
which a signal interrupts at once, whatever is being computed.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, TypeVar

__all__ = ["be_patient", "do"]

_T = TypeVar("_T")

_NAP = 0.2  # seconds; where a wait without a limit hears no signal (Windows), this is how long it is deaf


class _Outcome:
    """What becomes of some work."""

    def __init__(self) -> None:
        self.done = threading.Event()
        self.result: Any = None
        self.failure: BaseException | None = None


class _Hand:
    """A thread that does one thing after the other: a new one for each would begin with memory of its own."""

    def __init__(self) -> None:
        self._given: SimpleQueue[tuple[Callable[[], Any], _Outcome]] = SimpleQueue()
        threading.Thread(target=self._serve, name="poisson work", daemon=True).start()

    def give(self, work: Callable[[], Any]) -> _Outcome:
        """Have it do some work, when it has done what it was given before."""
        outcome = _Outcome()
        self._given.put((work, outcome))
        return outcome

    def _serve(self) -> None:
        while True:
            work, outcome = self._given.get()
            try:
                outcome.result = work()
            except BaseException as error:
                outcome.failure = error
            outcome.done.set()
            del work, outcome  # not to be kept until there is more to do


_idle: list[_Hand] = []
"""Those that have nothing to do."""


_patient = False


def be_patient() -> None:
    """Do all work on the thread that asks for it, in a process that need not answer at once.

    Handing work over takes a while when all processors are busy.
    """
    global _patient
    _patient = True


def do(work: Callable[[], _T]) -> _T:
    """Do some work on another thread and wait for it.

    Parameters
    ----------
    work
        Must leave nothing behind that has to be cleaned up: after an interrupt it is abandoned, not stopped. It
        ends with the process (see `poisson_cli.main`).

    Returns
    -------
    object
        What the work returns; what it raises is raised here.
    """
    if _patient or threading.current_thread() is not threading.main_thread():
        return work()  # nobody waits for an answer, or signals are not heard on this thread anyway
    hand = _idle.pop() if _idle else _Hand()
    outcome = hand.give(work)
    while not outcome.done.wait(_NAP):
        pass
    _idle.append(hand)
    if outcome.failure is not None:
        raise outcome.failure
    result: _T = outcome.result
    return result
