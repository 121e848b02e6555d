"""``poisson batch``, from a manifest to an exit code."""

from __future__ import annotations

import contextlib
import shlex
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from poisson_cli import errors
from poisson_cli.batch import checking, display, manifest, report, running
from poisson_cli.batch.task import Task

if TYPE_CHECKING:
    from poisson_cli.batch.pool import Ahead

__all__ = ["Choices", "run"]


@dataclass(frozen=True)
class Choices:
    """What can be chosen about a batch.

    Parameters
    ----------
    jobs
        Processes; None: as many as there are cores. On a cluster: jobs at a time.
    keep_going
        Begin further jobs after one has failed.
    skip_existing
        Skip jobs whose outputs are there.
    overwrite
        Let jobs replace outputs that are there.
    shard
        (i, n): the i-th of n equal shares of the jobs, from 1.
    defaults
        Names and values, as text, said for all jobs.
    report
        Where to write the report; None for nowhere, ``-`` for stdout.
    dry_run
        Say what would be done, and do nothing.
    memory
        Bytes for all jobs that run; None: most of what is free.
    timeout
        Seconds after which a job has failed; None: never.
    make_folders
        Make the folders of outputs that are not there.
    scheduler
        Address of a Dask scheduler, ``"local"``, or None.
    quiet
        Say nothing but why jobs failed.
    """

    jobs: int | None = None
    keep_going: bool = True
    skip_existing: bool = False
    overwrite: bool = False
    shard: tuple[int, int] = (1, 1)
    defaults: tuple[tuple[str, str], ...] = ()
    report: Path | None = None
    dry_run: bool = False
    memory: int | None = None
    timeout: float | None = None
    make_folders: bool = False
    scheduler: str | None = None
    quiet: bool = False


def run(path: Path, choices: Choices) -> int:
    """Do the jobs of a manifest.

    Parameters
    ----------
    path
        The manifest; ``-`` is standard input, whose paths are relative to the current folder.
    choices
        How.

    Returns
    -------
    int
        The exit code: 0, or 1 if some jobs failed.

    Raises
    ------
    Mistakes
        Everything that is wrong with the manifest; nothing was run.
    InputError, OutputError
        If the manifest cannot be read, or the report not be written.
    """
    standard_input = str(path) == "-"
    folder = running.folder_for("" if standard_input else path.parent, choices.scheduler)
    listed = manifest.parse(sys.stdin.buffer.read() if standard_input else _read(path))
    share, shares = choices.shard
    jobs = len(listed.entries[share - 1 :: shares])
    # Workers take as long to get ready as a thousand lines to be checked.
    surely = jobs > 0 and not (choices.scheduler or choices.skip_existing or choices.dry_run)
    ready = running.ahead(jobs, workers=choices.jobs, quiet=choices.quiet) if surely else None
    with ready or contextlib.nullcontext() as begun:
        with display.checking(sys.stderr, quiet=choices.quiet, name=str(path)) as watch:
            tasks = checking.check(
                listed,
                folder=folder,
                defaults=choices.defaults,
                overwrite=choices.overwrite,
                skip_existing=choices.skip_existing,
                make_folders=choices.make_folders,
                name=str(path),
                watch=watch,
            )
        tasks = tasks[share - 1 :: shares]
        if choices.dry_run:
            _say_what_would_be_done(tasks)
            return errors.DONE
        return _run(tasks, str(path), choices, begun)


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise errors.InputError(f"{path}: cannot be read ({error.strerror or error})") from error


def _say_what_would_be_done(tasks: Sequence[Task]) -> None:
    """Each job as the command line that would do it; one that would be skipped as a comment."""
    for task in tasks:
        skipped = "# there already: " if task.skip_existing and task.is_done() else ""
        print(f"{skipped}{shlex.join(['poisson', task.tool, *task.words])}")


def _run(tasks: Sequence[Task], name: str, choices: Choices, begun: Ahead | None) -> int:
    tally = report.Tally(len(tasks))
    began = time.monotonic()
    code = errors.BUG  # if something else ends this
    with report.opened(choices.report, goes_on=choices.skip_existing, overwrite=choices.overwrite) as lines:
        shared = lines is not None and lines is sys.stdout and lines.isatty()
        screen = display.Display(tally, sys.stderr, quiet=choices.quiet, name=name, shared=shared)
        results = running.results(
            tasks,
            workers=choices.jobs,
            keep_going=choices.keep_going,
            memory=choices.memory,
            timeout=choices.timeout,
            make_folders=choices.make_folders,
            scheduler=choices.scheduler,
            quiet=choices.quiet,
            begins=screen.begins,
            begun=begun,
        )
        try:
            with screen.fresh(), contextlib.closing(results):
                for result in results:
                    tally.add(result)
                    report.write(report.as_dict(result), lines)
                    screen.ends(result)
            code = tally.exit_code
        except BaseException as error:
            code = errors.code_of(error)
            raise
        finally:
            seconds = time.monotonic() - began
            if not choices.quiet:
                screen.say(display.ending(tally, seconds))
            report.write(tally.summary(seconds, code), lines)
    return code
