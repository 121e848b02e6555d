"""What a person sees of a batch: one line that is written over on a terminal, plain lines now and then elsewhere."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final, TextIO

from poisson_cli.batch.report import Tally
from poisson_cli.batch.task import Result, Task
from poisson_cli.interrupts import held
from poisson_cli.progress import DELAY, INTERVAL, Overwritten, is_terminal
from poisson_cli.streams import printable, silence

__all__ = ["Display", "checking", "ending"]

PLAIN_INTERVAL: Final = 30.0
"""Seconds between two plain lines, at least."""

TICK: Final = 1.0
"""Seconds after which the line is written again even if nothing has happened, so that a long job is seen to be one."""

LONG: Final = 10.0
"""Seconds after which it is said for how long a job has been running."""


class Display:
    """Shows how far a batch has come; from any thread.

    Parameters
    ----------
    tally
        What has become of the jobs; somebody else counts.
    stream
        Where to. If nobody listens there any more, because a terminal was closed, the batch goes on in silence.
    quiet
        Say nothing but why jobs failed.
    name
        What to call the manifest.
    shared
        Whether something else is written to the same terminal, so that no line can be written over.
    clock
        Seconds, from any beginning.
    """

    def __init__(
        self,
        tally: Tally,
        stream: TextIO,
        *,
        quiet: bool,
        name: str,
        shared: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._tally, self._stream, self._quiet, self._name, self._clock = tally, stream, quiet, name, clock
        alone = is_terminal(stream) and not shared
        self._line = Overwritten(stream) if alone and not quiet else None
        self._began = clock()
        self._due = self._began + (INTERVAL if self._line else PLAIN_INTERVAL)
        self._running: dict[int, tuple[Task, float]] = {}
        self._lock = threading.Lock()

    @contextmanager
    def fresh(self) -> Iterator[None]:
        """Refresh what is seen from time to time, and wipe it out in the end."""
        over = threading.Event()

        def tick() -> None:
            while not over.wait(TICK):
                self.refresh()

        ticker = threading.Thread(target=tick, name="poisson display", daemon=True)
        if not self._quiet:
            with held():  # signals are for the main thread, which knows when not to hear them
                ticker.start()
        try:
            yield
        finally:
            over.set()
            with self._lock, self._lenient():
                if self._line is not None:
                    self._line.close()

    def begins(self, task: Task) -> None:
        """A job begins."""
        with self._lock:
            self._running[task.number] = task, self._clock()
        self.refresh()

    def ends(self, result: Result) -> None:
        """A job has ended, and is counted."""
        with self._lock:
            self._running.pop(result.job, None)
        if result.status == "failed":
            self.say(printable(f"poisson: {self._name}:{result.line}: {result.error}"))
        self.refresh()

    def say(self, text: str) -> None:
        """Say something that stays; the line goes on below it."""
        with self._lock, self._lenient():
            if self._line is not None:
                self._line.write("")
            print(text, file=self._stream, flush=True)

    def refresh(self) -> None:
        """Say how far it has come, if the last word is old enough."""
        with self._lock, self._lenient():
            now = self._clock()
            if self._quiet or now < self._due:
                return
            if self._line is not None:
                self._due = now + INTERVAL
                self._line.write(self._text(now))
            else:
                self._due = now + PLAIN_INTERVAL
                print(f"poisson: {self._text(now)}", file=self._stream, flush=True)

    @contextmanager
    def _lenient(self) -> Iterator[None]:
        try:
            yield
        except OSError:
            silence(self._stream)

    def _text(self, now: float) -> str:
        """Such as ``812 of 2,000 done, 3 failed, 54.1 a second, 22 s left; clone out/0813.png``."""
        tally = self._tally
        failed = f", {tally.failed:,} failed" if tally.failed else ""
        ended = tally.done + tally.failed
        pace = ""
        if ended and now > self._began:
            rate = ended / (now - self._began)
            pace = f", {_rate(rate)}, {_span(tally.left / rate)} left"
        runs = ""
        if self._running:
            oldest, began = next(iter(self._running.values()))
            runs = printable(f"; {oldest.tool} {oldest.outputs[0]}")
            runs += f" for {_span(now - began)}" if now - began >= LONG else ""
        return f"{tally.done + tally.skipped:,} of {tally.jobs:,} done{failed}{pace}{runs}"


@contextmanager
def checking(stream: TextIO, *, quiet: bool, name: str) -> Iterator[Callable[[int, int], None]]:
    """Show how far the check of a long list has come, on a terminal.

    Parameters
    ----------
    stream, quiet, name
        As of `Display`.

    Yields
    ------
    callable
        To be called with the number of lines that are checked, and of all.
    """
    if quiet or not is_terminal(stream):
        yield lambda checked, lines: None
        return
    line = Overwritten(stream)
    due = time.monotonic() + DELAY

    def watch(checked: int, lines: int) -> None:
        nonlocal due
        now = time.monotonic()
        if now >= due:
            due = now + INTERVAL
            with suppress(OSError):
                line.write(f"checking {printable(name)}: {checked:,} of {lines:,} lines")

    try:
        yield watch
    finally:
        with suppress(OSError):
            line.close()


def ending(tally: Tally, seconds: float) -> str:
    """The last line for a person."""
    parts = [f"{tally.done:,} done"]
    parts += [f"{tally.failed:,} failed"] if tally.failed else []
    parts += [f"{tally.skipped:,} skipped"] if tally.skipped else []
    parts += [f"{tally.left:,} not run"] if tally.left else []
    ended = tally.done + tally.failed
    pace = f", {_rate(ended / seconds)}" if ended and seconds > 0 else ""
    return f"batch: {', '.join(parts)} in {_span(seconds)}{pace}"


def _rate(rate: float) -> str:
    return f"{rate:.1f} a second" if rate >= 1 else f"{60 * rate:.1f} a minute"


def _span(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.1f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60:02} min"
