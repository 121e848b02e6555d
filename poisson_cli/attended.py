"""Jobs with somebody watching: progress while they run, and a report when they are done."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from poisson_cli.job import Job
    from poisson_cli.settings import Reporting

__all__ = ["run"]


def run(jobs: Sequence[Job], reporting: Reporting) -> None:
    """Do jobs, all or none, and say what was done.

    Parameters
    ----------
    jobs
        What to do, by the same solver.
    reporting
        How much to say.

    Raises
    ------
    InputError, OutputError, NotConverged
        Nothing was written.
    """
    from poisson_cli import job, progress, report

    with progress.shown(reporting, jobs[0].solver) as watch:
        summaries = job.run_together(jobs, progress=watch)
    for summary in summaries:
        report.tell(summary, reporting)
