"""Being asked to stop: SIGINT, SIGTERM and SIGHUP end the process, until its output takes its name.

An exit code other than 0 promises that there is no new output. So a signal that comes when the output is about to
take its name comes too late: what is left to do takes no time, and the run ends as done.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType
from typing import Final

from poisson_cli.errors import HungUp, Terminated

__all__ = ["check", "finishing", "held", "hushed", "let_in", "listen"]

finishing: Final = threading.Event()
"""Set when the output is about to take its name; a signal has no effect any more."""

_ECHO: Final = 0.5
"""Seconds in which a second signal counts as the first one, sent to the process and to its group."""


_KINDS: Final[dict[str, type[BaseException]]] = {
    "SIGINT": KeyboardInterrupt,
    "SIGTERM": Terminated,
    "SIGHUP": HungUp,  # not on Windows
}


_heard: Final[list[type[BaseException]]] = []
"""What signals have raised."""


def check() -> None:
    """Raise once more what a signal has raised, if the process goes on all the same.

    Python drops what is raised in a destructor. So whoever waits for long, and lets others' destructors run, asks.
    """
    if _heard:
        raise _heard[-1]


@contextlib.contextmanager
def hushed() -> Iterator[None]:
    """Let Python say nothing of a signal's exception that it drops, because `check` is asked soon."""
    usual = sys.unraisablehook

    def tell(dropped: sys.UnraisableHookArgs) -> None:
        if dropped.exc_type not in _KINDS.values():
            usual(dropped)

    sys.unraisablehook = tell
    try:
        yield
    finally:
        sys.unraisablehook = usual


def listen() -> None:
    """Make the signals exceptions on the main thread, but for those that the process was started deaf to."""
    last = [float("-inf")]  # when one was heard
    _heard.clear()

    def stop(number: int, _frame: FrameType | None) -> None:
        now = time.monotonic()
        # An echo must not come between a `finally` and what it has to clean up.
        if finishing.is_set() or now - last[0] < _ECHO:
            return
        last[0] = now
        _heard.append(_KINDS[signal.Signals(number).name])
        raise _heard[-1]

    for name in _KINDS:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, stop)


@contextlib.contextmanager
def held() -> Iterator[None]:
    """Hear of a signal that comes meanwhile only at the end; threads and processes that are started meanwhile never do.

    Only if no other thread can hear it. So whoever starts one should hold signals while doing so.
    """
    if not hasattr(
        signal, "pthread_sigmask"
    ):  # Windows, where a Ctrl-C in between is the worst that can happen
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _numbers())
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def let_in() -> None:
    """Hear of signals again, in a process that was started while they were held."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _numbers())


def _numbers() -> list[int]:
    return [getattr(signal, name) for name in _KINDS if hasattr(signal, name)]
