"""What a person sees of a batch: one line that is written over on a terminal, plain lines now and then elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final, TextIO

from poisson_cli.batch.report import Tally
from poisson_cli.batch.task import Result, Task
from poisson_cli.progress import INTERVAL, Overwritten, is_terminal

__all__ = ["Display", "ending"]

PLAIN_INTERVAL: Final = 30.0
"""Seconds between two plain lines, at least."""


class Display:
    """Shows how far a batch has come.

    Parameters
    ----------
    tally
        What has become of the jobs; somebody else counts.
    stream
        Where to.
    quiet
        Say nothing but why jobs failed.
    name
        What to call the manifest.
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
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._tally, self._stream, self._quiet, self._name, self._clock = tally, stream, quiet, name, clock
        self._line = Overwritten(stream) if is_terminal(stream) and not quiet else None
        self._began = clock()
        self._due = self._began + (INTERVAL if self._line else PLAIN_INTERVAL)
        self._running: dict[int, Task] = {}

    def begins(self, task: Task) -> None:
        """A job begins."""
        self._running[task.number] = task
        self._refresh()

    def ends(self, result: Result) -> None:
        """A job has ended, and is counted."""
        self._running.pop(result.job, None)
        if result.status == "failed":
            self.say(f"poisson: {self._name}:{result.line}: {result.error}")
        self._refresh()

    def say(self, text: str) -> None:
        """Say something that stays; the line goes on below it."""
        if self._line is not None:
            self._line.write("")
        print(text, file=self._stream, flush=True)

    def close(self) -> None:
        """Wipe the line out."""
        if self._line is not None:
            self._line.close()

    def _refresh(self) -> None:
        now = self._clock()
        if self._quiet or now < self._due:
            return
        if self._line is not None:
            self._due = now + INTERVAL
            self._line.write(self._text(now))
        else:
            self._due = now + PLAIN_INTERVAL
            print(f"poisson: {self._text(now)}", file=self._stream, flush=True)

    def _text(self, now: float) -> str:
        """Such as ``812 of 2,000 done, 3 failed, 54.1 a second, 22 s left; clone out/0813.png``."""
        tally = self._tally
        failed = f", {tally.failed:,} failed" if tally.failed else ""
        ended = tally.done + tally.failed
        pace = ""
        if ended and now > self._began:
            rate = ended / (now - self._began)
            pace = f", {_rate(rate)}, {_span(tally.left / rate)} left"
        oldest = next(iter(self._running.values()), None)
        runs = "" if oldest is None else f"; {oldest.tool} {oldest.outputs[0]}"
        return f"{tally.done + tally.skipped:,} of {tally.jobs:,} done{failed}{pace}{runs}"


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
