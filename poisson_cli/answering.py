"""Staying answerable during long computations.

Python runs signal handlers on the main thread only, and only between two of its own instructions: a compiled call that
takes a second is deaf for a second. So the main thread hands long work to another one and does nothing but wait,
which a signal interrupts at once, whatever is being computed.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, TypeVar

__all__ = ["do"]

_T = TypeVar("_T")

_NAP = 0.2  # seconds; where a wait without a limit hears no signal (Windows), this is how long it is deaf


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
    if threading.current_thread() is not threading.main_thread():
        return work()  # signals are not heard on this thread anyway
    outcome: list[Any] = []
    failure: list[BaseException] = []
    done = threading.Event()

    def finish() -> None:
        try:
            outcome.append(work())
        except BaseException as error:
            failure.append(error)
        finally:
            done.set()

    threading.Thread(target=finish, name="poisson work", daemon=True).start()
    while not done.wait(_NAP):
        pass
    if failure:
        raise failure.pop()
    result: _T = outcome.pop()
    return result
