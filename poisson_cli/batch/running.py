"""From tasks to results: what is there already is skipped, the rest goes to workers here or on a cluster."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Generator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from poisson_cli.batch import groups, outputs
from poisson_cli.batch import memory as memory_
from poisson_cli.batch.task import Result, Task

if TYPE_CHECKING:
    from poisson_cli.batch.pool import Ahead

__all__ = ["ahead", "cores", "folder_for", "results"]


def folder_for(folder: str | Path, scheduler: str | None) -> str:
    """What paths are relative to, as a prefix of them: none for the current folder, so that names stay as they are.

    On a cluster the current folder is another one.
    """
    if scheduler is not None:
        return os.path.abspath(folder or ".")
    return "" if str(folder) in ("", ".") else str(folder)


def cores() -> int:
    """How many jobs to do at a time by default: one for each core, or for each that a container may use."""
    from solvers.team import available_cores

    return max(1, math.ceil(min(available_cores(), groups.cores())))


def ahead(jobs: int, *, workers: int | None, quiet: bool) -> AbstractContextManager[Ahead]:
    """Workers on this machine, for so many jobs, that get ready while the jobs are checked; for `results`."""
    from poisson_cli.batch import pool

    return pool.Ahead(min(workers or cores(), jobs), quiet=quiet)


def results(
    tasks: Sequence[Task],
    *,
    workers: int | None = None,
    keep_going: bool = True,
    memory: int | None = None,
    timeout: float | None = None,
    make_folders: bool = False,
    scheduler: str | None = None,
    quiet: bool = True,
    begins: Callable[[Task], None] = lambda task: None,
    begun: Ahead | None = None,
) -> Generator[Result]:
    """Do jobs, wherever it was asked for.

    Parameters
    ----------
    tasks
        From `poisson_cli.batch.checking.check`.
    workers, keep_going, memory, timeout, make_folders, scheduler
        As `poisson_cli.batch.run`.
    quiet
        Compile the solver, if it has to be, in silence.
    begins
        Called with each job that begins.
    begun
        From `ahead`.

    Yields
    ------
    Result
        As they come.
    """
    left: list[Task] = []
    for task in tasks:
        if task.skip_existing and task.is_done():
            yield Result.of(task, "skipped", attempts=0)
        else:
            # Some of several outputs: the run that wrote them was killed before it could write the others.
            left.append(task.replacing() if task.skip_existing and task.is_begun() else task)
    if not left:
        return
    if make_folders:
        outputs.make_folders(left)
    if scheduler is not None:
        from poisson_cli.batch import cluster

        yield from cluster.run(left, scheduler, at_a_time=workers, keep_going=keep_going, begins=begins)
        return
    from poisson_cli.batch import pool

    try:
        yield from pool.run(
            left,
            workers=min(workers or cores(), len(left)),
            limit=memory or memory_.available(),
            keep_going=keep_going,
            timeout=timeout,
            quiet=quiet,
            begins=begins,
            ahead=begun,
        )
    finally:
        outputs.settle(left)  # the workers did not
