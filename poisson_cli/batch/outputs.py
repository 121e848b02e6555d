"""What jobs write, all together: what cannot be written, before any job runs; their folders; their names at the end."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from poisson_cli.batch.mistakes import Mistake
from poisson_cli.batch.task import Task, outputs_of
from poisson_cli.errors import OutputError
from poisson_cli.images import writing
from poisson_cli.images.target import format_for

__all__ = ["make_folders", "settle", "unwritable"]


def unwritable(tasks: Sequence[Task], *, make_folders: bool) -> Iterator[Mistake]:
    """Find outputs of no known format, and folders that are not there.

    Parameters
    ----------
    tasks
        All jobs of a batch.
    make_folders
        Whether the folders will be made.

    Yields
    ------
    Mistake
        For each such output, but for each folder only once.
    """
    first: dict[str, int] = {}
    outputs: Counter[str] = Counter()
    for task in tasks:
        for job in task.jobs:
            result, *beside = outputs_of(job)
            try:
                format_for(result, form=job.output.format, quality=job.output.quality)
                for path in beside:
                    format_for(path)
            except OutputError as error:
                yield Mistake(task.line, str(error))
        for path in task.outputs:
            folder = os.path.dirname(path)
            first.setdefault(folder, task.line)
            outputs[folder] += 1
    if make_folders:
        return
    for folder, line in first.items():
        if folder and not os.path.isdir(folder):
            number = outputs[folder]
            whose = f"{number:,} outputs" if number > 1 else "an output"
            text = f"there is no folder {folder} for {whose}; make it first, or let --make-folders do it"
            yield Mistake(line, text)


def make_folders(tasks: Sequence[Task]) -> None:
    """Make the folders that outputs go to.

    Parameters
    ----------
    tasks
        The jobs that are to be done.

    Raises
    ------
    OutputError
        If one cannot be made.
    """
    for folder in _folders(tasks) - {""}:
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            raise OutputError(f"{folder}: cannot be made ({error.strerror or error})") from error


def settle(tasks: Sequence[Task]) -> None:
    """Force the names of all outputs to the disk; a folder that is not there has none."""
    for folder in _folders(tasks):
        writing.settle(Path(folder or "."))


def _folders(tasks: Sequence[Task]) -> set[str]:
    """Where outputs go to; empty for the current folder."""
    return {os.path.dirname(path) for task in tasks for path in task.outputs}
