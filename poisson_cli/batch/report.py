"""The report of a batch: one JSON line for each job as it ends, and one for the whole at the end."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, TextIO

from poisson_cli import errors
from poisson_cli.batch.task import Result
from poisson_cli.streams import silence

__all__ = ["Tally", "as_dict", "opened", "write"]


class Tally:
    """What has become of the jobs so far.

    Parameters
    ----------
    jobs
        How many there are.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._counts: Counter[str] = Counter()

    def add(self, result: Result) -> None:
        """Count one more."""
        self._counts[result.status] += 1

    @property
    def done(self) -> int:
        """Jobs that were done."""
        return self._counts["done"]

    @property
    def failed(self) -> int:
        """Jobs that failed."""
        return self._counts["failed"]

    @property
    def skipped(self) -> int:
        """Jobs whose outputs were there."""
        return self._counts["skipped"]

    @property
    def left(self) -> int:
        """Jobs of which nothing has been heard."""
        return self.jobs - self._counts.total()

    @property
    def exit_code(self) -> int:
        """What the batch ends with, if nothing interrupts it."""
        return errors.SOME_FAILED if self.failed else errors.DONE

    def summary(self, seconds: float, exit_code: int) -> dict[str, Any]:
        """The last line of the report.

        Parameters
        ----------
        seconds
            How long the batch took.
        exit_code
            What it ends with.
        """
        return {
            "summary": {
                "jobs": self.jobs,
                "done": self.done,
                "failed": self.failed,
                "skipped": self.skipped,
                "not_run": self.left,
                "seconds": seconds,
                "exit_code": exit_code,
            }
        }


def as_dict(result: Result) -> dict[str, Any]:
    """One line of the report; the fields are those of `Result`."""
    return dict(vars(result))  # `dataclasses.asdict` copies each text and number


@contextlib.contextmanager
def opened(path: Path | None, *, goes_on: bool, overwrite: bool) -> Iterator[TextIO | None]:
    """Open the report before anything is done that it should tell of.

    Parameters
    ----------
    path
        Where; ``-`` is stdout, None nowhere.
    goes_on
        Whether a report that is there is of an earlier run of the same batch, so that this run's lines go behind it.
    overwrite
        Whether a report that is there may be replaced.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    if path is None:
        yield None
        return
    if str(path) == "-":
        yield sys.stdout
        return
    try:
        stream = open(path, "a" if goes_on else "w" if overwrite else "x", encoding="utf-8")  # noqa: SIM115
    except FileExistsError as error:
        raise errors.OutputError(
            f"{path}: exists already; add --overwrite to replace it, --skip-existing to go on with it, or choose "
            "another name"
        ) from error
    except OSError as error:
        raise errors.OutputError(f"{path}: cannot be written ({error.strerror or error})") from error
    with stream:
        _mend(stream, path)
        yield stream


def _mend(stream: TextIO, path: Path) -> None:
    """See to a last line that has no end, because the run that wrote it was killed just then, or the disk was full.

    Half a line of a report would make the whole unreadable to most programs, so it is cut off: its job has no line, as
    others that were stopped have none. Whatever else it is, it stays.
    """
    if not os.path.isfile(path):  # a pipe, which has no lines of earlier runs
        return
    with open(path, "rb+") as file:
        begin = _last_line(file)
        line = file.read()
        ours = any(line.startswith(head[: len(line)]) for head in (b'{"job": ', b'{"summary": '))
        if line and ours and not _is_json(line):
            file.truncate(begin)
        elif line:
            stream.write("\n")


def _last_line(file: BinaryIO) -> int:
    """Go to where the last line begins, which is the end if all have an end."""
    begin = file.seek(0, os.SEEK_END)
    while begin > 0:
        before = max(0, begin - 4096)
        file.seek(before)
        at = file.read(begin - before).rfind(b"\n")
        if at >= 0:
            return file.seek(before + at + 1)
        begin = before
    return file.seek(0)


def _is_json(line: bytes) -> bool:
    try:
        json.loads(line)
    except ValueError:
        return False
    return True


def write(line: dict[str, Any], stream: TextIO | None) -> None:
    """Write one line, at once, so that it is there whatever happens next.

    Raises
    ------
    OutputError
        If the disk is full, or the like. That nobody reads stdout any more is no reason to end a batch.
    """
    if stream is None:
        return
    try:
        stream.write(f"{json.dumps(line)}\n")
        stream.flush()
    except BrokenPipeError:
        silence(stream)
    except OSError as error:
        silence(stream)  # it holds what it could not write, and would try again when it is closed
        raise errors.OutputError(f"the report cannot be written ({error.strerror or error})") from error
