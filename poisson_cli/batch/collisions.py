"""Jobs that get in each other's way, so that what comes out would depend on which of them is faster."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence

from poisson_cli.batch.mistakes import Mistake
from poisson_cli.batch.task import Task
from poisson_cli.masking import MaskJob
from poisson_cli.settings import Combine, MaskFile

__all__ = ["collisions"]


def collisions(tasks: Sequence[Task]) -> Iterator[Mistake]:
    """Find files that are written twice, or read and written.

    Two jobs that write one file; one that writes a file twice; one that reads what another writes; and one that
    replaces what it reads, which a second attempt would do a second time.

    Parameters
    ----------
    tasks
        All jobs of a batch.

    Yields
    ------
    Mistake
        In no particular order.
    """
    files = _Files()
    writers: dict[str, Task] = {}
    for task in tasks:
        own: set[str] = set()
        for path in task.outputs:
            real = files.real(str(path))
            first = writers.setdefault(real, task)
            if real in own:
                yield Mistake(task.line, f"{path} is written twice; give each output its own name")
            elif first is not task:
                yield Mistake(
                    task.line, f"{path} is also written by line {first.line}; give each its own name"
                )
            own.add(real)
    for task in tasks:
        for name in _inputs(task):
            writer = writers.get(files.real(name))
            if writer is task:
                yield Mistake(task.line, f"{name} is read and written; give the output another name")
            elif writer is not None:
                text = f"{name} is written by line {writer.line}; read it in another batch, after this one"
                yield Mistake(task.line, text)


class _Files:
    """Where files really are. Many jobs read the same one, and many files share a folder: each is looked at once."""

    def __init__(self) -> None:
        self._folders: dict[str, str] = {}
        self._known: dict[str, str] = {}

    def real(self, name: str) -> str:
        """A name that all names of one file have in common."""
        known = self._known.get(name)
        if known is None:
            known = self._known[name] = self._look(name)
        return known

    def _look(self, name: str) -> str:
        if os.path.islink(name):
            return os.path.realpath(name)
        folder, own = os.path.split(name)
        if folder not in self._folders:
            self._folders[folder] = os.path.realpath(folder)
        return os.path.join(self._folders[folder], own)


def _inputs(task: Task) -> Iterator[str]:
    """The names of the files that a job reads."""
    for job in task.jobs:
        if isinstance(job, MaskJob):
            yield str(job.image)
        else:
            yield str(job.destination)
            if job.source is not None:
                yield str(job.source)
            edges = job.edges if job.then is None else job.then.flatten
            if edges is not None and edges.file is not None:
                yield str(edges.file)
        for step in () if job.selection is None else job.selection.steps:
            if isinstance(step, Combine) and isinstance(step.area, MaskFile):
                yield from _names(step.area.name)


def _names(mask: str) -> Iterator[str]:
    """What a mask's file may be called: what follows a colon may be part of its name, or the part of it that is meant.

    Which of them it is, only the files tell that are there when the job runs.
    """
    end = len(mask)
    while end > 0:
        yield mask[:end]
        end = mask.rfind(":", 0, end)
