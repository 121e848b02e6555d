"""Ten thousand jobs: a list of them is checked as a whole, then done by every core of this machine, or of a cluster.

`run` does the jobs of a list and yields what becomes of each as it comes::

    from poisson_cli import batch

    jobs = [
        {"tool": "fill", "image": f"in/{k}.png", "rect": [9, 9, 40, 20], "output": f"out/{k}.png"}
        for k in range(500)
    ]
    for result in batch.run(jobs, skip_existing=True):
        print(result.output, result.status, result.error)

A job is a line of a manifest as a dictionary: the arguments and options of a command under their names. The way of
one through this package:

    manifest -> checking (by grammar) -> Task -> pool or cluster -> Result -> report and display
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from poisson_cli.batch.task import Result

__all__ = ["run"]


def run(
    jobs: Iterable[Mapping[str, Any]],
    *,
    folder: str | Path = "",
    defaults: Mapping[str, Any] | None = None,
    workers: int | None = None,
    keep_going: bool = True,
    skip_existing: bool = False,
    overwrite: bool = False,
    memory: int | None = None,
    timeout: float | None = None,
    make_folders: bool = False,
    scheduler: str | None = None,
) -> Iterator[Result]:
    """Do jobs.

    Parameters
    ----------
    jobs
        Each with the names and values of a line of a manifest; the order of a dictionary is that of the options.
    folder
        What paths in them are relative to; the current folder if empty.
    defaults
        What is said for all jobs; what a job says itself wins.
    workers
        Processes; None: as many as there are cores. On a cluster: jobs at a time.
    keep_going
        Begin further jobs after one has failed.
    skip_existing
        Skip jobs whose outputs are there.
    overwrite
        Let jobs replace outputs that are there.
    memory
        Bytes that all jobs that run on this machine may need together, by their estimates; None: most of what is free.
    timeout
        Seconds after which a job has failed, and its process is ended; None: never. Not for a cluster.
    make_folders
        Make the folders of outputs that are not there; without it they are mistakes.
    scheduler
        Address of a Dask scheduler, or ``"local"`` for a cluster on this machine; None for plain processes.

    Returns
    -------
    iterator of Result
        One for each job as it ends, in any order. Closing it stops the jobs that run.

    Raises
    ------
    Mistakes
        At once, before any job runs: everything that is wrong with them. Their lines count from 1.
    PoissonError
        While it runs: if workers cannot be started, or the scheduler not be reached.
    """
    from poisson_cli.batch import checking, running
    from poisson_cli.batch.manifest import Entry, Manifest

    entries = [Entry(line, _plain(job)) for line, job in enumerate(jobs, start=1)]
    tasks = checking.check(
        Manifest(entries),
        folder=running.folder_for(folder, scheduler),
        defaults=_plain(defaults or {}),
        overwrite=overwrite,
        skip_existing=skip_existing,
        make_folders=make_folders,
    )
    return running.results(
        tasks,
        workers=workers,
        keep_going=keep_going,
        memory=memory,
        timeout=timeout,
        make_folders=make_folders,
        scheduler=scheduler,
        quiet=True,
    )


def _plain(values: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    """Names and values as a manifest would have them: lists for tuples, text for paths."""

    def plain(value: Any) -> Any:
        if isinstance(value, Path):
            return str(value)
        if isinstance(value, Mapping):
            return {key: plain(inner) for key, inner in value.items()}
        return [plain(inner) for inner in value] if isinstance(value, list | tuple) else value

    return tuple((name, plain(value)) for name, value in values.items())
