"""Jobs with somebody watching: progress while they run, and a report when they are done.

Every command that edits hands its jobs over to `run`, as plain data, and does nothing else with them. Whoever wants
the jobs of a command line without running them, a batch for one, asks `handed_over` to collect them instead.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING

from poisson_cli import answering

if TYPE_CHECKING:
    from poisson_cli.settings import Job, MaskJob, Reporting

__all__ = ["handed_over", "run"]

_collecting: ContextVar[list[Job | MaskJob] | None] = ContextVar("_collecting", default=None)


@contextmanager
def handed_over() -> Iterator[list[Job | MaskJob]]:
    """Collect the jobs that commands hand over meanwhile; none of them is run.

    Yields
    ------
    list
        Filled by and by.
    """
    jobs: list[Job | MaskJob] = []
    before = _collecting.set(jobs)
    try:
        yield jobs
    finally:
        _collecting.reset(before)


def run(jobs: Sequence[Job] | Sequence[MaskJob], reporting: Reporting) -> None:
    """Do jobs, all or none, and say what was done.

    Parameters
    ----------
    jobs
        Edits by the same solver, or one selection that is to be written.
    reporting
        How much to say.

    Raises
    ------
    InputError, OutputError, NotConverged
        Nothing was written.
    """
    collecting = _collecting.get()
    if collecting is not None:
        collecting += jobs
        return
    answering.do(_load)
    from poisson_cli import compiling, job, progress, report

    compiling.announce(quiet=reporting.quiet)
    edits: list[Job] = []
    for one in jobs:
        if isinstance(one, job.Job):
            edits.append(one)
        else:
            from poisson_cli import masking

            report.tell_mask(masking.run(one), reporting)
    if edits:
        with progress.shown(reporting, edits[0].solver) as watch:
            summaries = job.run_together(edits, progress=watch)
        for summary in summaries:
            report.tell(summary, reporting)


def _load() -> None:
    """Import what the work needs; to be called on another thread, whose stack is empty.

    Python keeps the frames of its calls in pieces of 16 KiB. Where the end of one falls between a function and what it
    calls again and again, each call gets another piece from the system and gives it back. Below click's frames that
    happened to numpy more than a thousand times, and its import took a third longer.
    """
    import numpy  # noqa: F401  # first, before other imports lie below it

    from poisson_cli import job  # noqa: F401
