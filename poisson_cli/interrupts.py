"""Being asked to stop: SIGINT, SIGTERM and SIGHUP end the process, until its output takes its name.

An exit code other than 0 promises that there is no new output. So a signal that comes when the output is about to
take its name comes too late: what is left to do takes no time, and the run ends as done.
"""

from __future__ import annotations

import signal
import threading
import time
from types import FrameType
from typing import Final

from poisson_cli.errors import HungUp, Terminated

__all__ = ["finishing", "listen"]

finishing: Final = threading.Event()
"""Set when the output is about to take its name; a signal has no effect any more."""

_ECHO: Final = 0.5
"""Seconds in which a second signal counts as the first one, sent to the process and to its group."""


_KINDS: Final[dict[str, type[BaseException]]] = {
    "SIGINT": KeyboardInterrupt,
    "SIGTERM": Terminated,
    "SIGHUP": HungUp,  # not on Windows
}


def listen() -> None:
    """Make the signals exceptions on the main thread, but for those that the process was started deaf to."""
    heard = [float("-inf")]

    def stop(number: int, _frame: FrameType | None) -> None:
        now = time.monotonic()
        # An echo must not come between a `finally` and what it has to clean up.
        if finishing.is_set() or now - heard[0] < _ECHO:
            return
        heard[0] = now
        raise _KINDS[signal.Signals(number).name]

    for name in _KINDS:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, stop)
