"""One job of a batch, and what became of it: plain data, so that both can travel between processes and machines."""

from __future__ import annotations

import dataclasses
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from poisson_cli import errors
from poisson_cli.job import Job, outputs, run_together
from poisson_cli.masking import MaskJob
from poisson_cli.masking import run as run_mask

__all__ = ["Result", "Task", "outputs_of", "perform"]


@dataclass(frozen=True)
class Task:
    """What a line of a manifest asks for.

    Parameters
    ----------
    number
        Which job of the batch it is, from 1.
    line
        Of the manifest, from 1.
    tool
        Name of the command.
    jobs
        What the command would do, all or none.
    words
        The rest of the command line that would do the same.
    skip_existing
        Whether it is no failure, but somebody else's success, if the outputs appear while this is at work.
    """

    number: int
    line: int
    tool: str
    jobs: tuple[Job | MaskJob, ...]
    words: tuple[str, ...] = ()
    skip_existing: bool = False

    @property
    def outputs(self) -> tuple[Path, ...]:
        """All files that it writes, the result first."""
        return tuple(path for job in self.jobs for path in outputs_of(job))

    def is_done(self) -> bool:
        """Whether all outputs are there."""
        return all(os.path.exists(path) for path in self.outputs)

    def is_begun(self) -> bool:
        """Whether any output is there."""
        return any(os.path.lexists(path) for path in self.outputs)

    def replacing(self) -> Task:
        """The same, but outputs that are there are replaced."""
        return dataclasses.replace(
            self,
            jobs=tuple(job._replace(output=job.output._replace(overwrite=True)) for job in self.jobs),
        )


@dataclass(frozen=True)
class Result:
    """What became of a job; the fields are those of a line of the report.

    Parameters
    ----------
    job, line, tool
        Which one it is, as in `Task`.
    status
        ``"done"``; ``"failed"``; or ``"skipped"``, because its outputs were there.
    exit_code
        What the single command would have ended with; 128 + n if its process was killed by signal n.
    error
        Why it failed.
    output
        The file that it was to write.
    beside
        Other files that it was to write.
    seconds
        How long it took.
    unknowns
        Pixels that were solved for; None if nothing was solved.
    error_estimate
        Largest estimated error in any pixel, in levels.
    attempts
        How often it was begun.
    notices
        What the user should know, a line each.
    traceback
        Of an exception that nobody foresaw.
    """

    job: int
    line: int
    tool: str
    status: Literal["done", "failed", "skipped"]
    exit_code: int = errors.DONE
    error: str | None = None
    output: str = ""
    beside: tuple[str, ...] = ()
    seconds: float = 0.0
    unknowns: int | None = None
    error_estimate: float | None = None
    attempts: int = 1
    notices: tuple[str, ...] = ()
    traceback: str | None = None

    @classmethod
    def of(cls, task: Task, status: Literal["done", "failed", "skipped"], **rest: Any) -> Result:
        """The result of a task."""
        output, *beside = map(str, task.outputs)
        return cls(
            job=task.number,
            line=task.line,
            tool=task.tool,
            status=status,
            output=output,
            beside=tuple(beside),
            **rest,
        )


def perform(task: Task, attempts: int = 1) -> Result:
    """Do a job; whatever goes wrong becomes part of the result.

    Parameters
    ----------
    task
        What to do.
    attempts
        How often it has been begun, this time included.
    """
    started = time.perf_counter()
    try:
        done = _do(task)
    except Exception as error:
        code, message = errors.verdict(error)
        seconds = time.perf_counter() - started
        if task.skip_existing and isinstance(error, errors.OutputError) and task.is_done():
            return Result.of(task, "skipped", seconds=seconds, attempts=attempts)
        return Result.of(
            task,
            "failed",
            exit_code=code,
            error=message,
            seconds=seconds,
            attempts=attempts,
            traceback=None if isinstance(error, errors.PoissonError | MemoryError) else _traceback(error),
        )
    return Result.of(task, "done", seconds=time.perf_counter() - started, attempts=attempts, **done)


def _do(task: Task) -> dict[str, Any]:
    """Do the jobs, and tell what the report says of them."""
    from poisson_cli.hints import hints

    edits = [job for job in task.jobs if isinstance(job, Job)]
    notices = [
        notice for job in task.jobs if isinstance(job, MaskJob) for notice in run_mask(job, None).notices
    ]
    if not edits:
        return {"notices": tuple(notices)}
    summaries = run_together(edits, before_commit=None)
    for summary in summaries:
        notices += [*summary.notices, *hints(summary)]
    return {
        "unknowns": sum(summary.edit.unknowns for summary in summaries),
        "error_estimate": max(summary.edit.error_estimate for summary in summaries),
        "notices": tuple(notices),
    }


def outputs_of(job: Job | MaskJob) -> list[Path]:
    """All files that it writes, the result first."""
    return [job.output.path] if isinstance(job, MaskJob) else list(outputs(job).values())


def _traceback(error: Exception) -> str:
    import traceback

    return "".join(traceback.format_exception(error))
