"""From the lines of a manifest to tasks, all of them or none: every line is checked before the first job runs.

What is checked is what a command line says of itself before it looks at any picture, and what jobs that run side by
side may not do to each other. A picture that is missing or broken is no mistake of the manifest; it fails its job.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import click

from poisson_cli import attended
from poisson_cli.batch import grammar
from poisson_cli.batch.manifest import Entry, Manifest, Pairs
from poisson_cli.batch.mistakes import Mistake, Mistakes
from poisson_cli.batch.task import Task
from poisson_cli.errors import PoissonError
from poisson_cli.job import Job
from poisson_cli.masking import MaskJob
from poisson_cli.options import Chatter
from poisson_cli.settings import Combine, MaskFile

__all__ = ["check"]

_ONE_THREAD: Final[Pairs] = (("threads", 1),)
"""What is said first: the batch uses the cores for as many jobs, which is better use than sharing one job's work."""


def check(
    manifest: Manifest,
    *,
    folder: str = "",
    defaults: Pairs = (),
    overwrite: bool = False,
    skip_existing: bool = False,
    name: str = "job",
) -> list[Task]:
    """Check a manifest.

    Parameters
    ----------
    manifest
        As it was read.
    folder
        What paths in it are relative to; empty for the current folder.
    defaults
        What is said for all jobs; wins over what the manifest says for all, and loses to what it says for one.
    overwrite
        Whether every job may replace its output.
    skip_existing
        Whether jobs are skipped whose outputs are there.
    name
        What to call the manifest.

    Returns
    -------
    list of Task
        In the order of the lines.

    Raises
    ------
    Mistakes
        All that are found.
    """
    mistakes = list(manifest.mistakes)
    for_all = _merged(_merged(_ONE_THREAD, manifest.defaults.pairs), defaults)
    for key, _ in for_all:
        if grammar.key_of(key) != grammar.TOOL and not any(
            tool.knows(key) for tool in grammar.tools().values()
        ):
            line = 0 if key in dict(defaults) else manifest.defaults.line
            mistakes.append(Mistake(line, f'no tool has the default "{key}"'))
    forced: Pairs = (("overwrite", True),) if overwrite else ()
    tasks = []
    for number, entry in enumerate(manifest.entries, start=1):
        try:
            task = _task(number, entry, for_all, forced, folder)
        except (ValueError, PoissonError) as error:
            mistakes.append(Mistake(entry.line, " ".join(str(error).split())))
        else:
            tasks.append(task)
    mistakes += _collisions(tasks)
    if mistakes:
        raise Mistakes(sorted(mistakes, key=lambda mistake: mistake.line), name)
    if skip_existing:
        return [dataclasses.replace(task, skip_existing=True) for task in tasks]
    return tasks


def _merged(pairs: Pairs, winning: Pairs) -> Pairs:
    """Two lists of names and values; what both name is as the second has it."""
    keys = {grammar.key_of(name) for name, _ in winning}
    return (*(pair for pair in pairs if grammar.key_of(pair[0]) not in keys), *winning)


def _task(number: int, entry: Entry, defaults: Pairs, forced: Pairs, folder: str) -> Task:
    """One line, with what is said for all; ValueError or `PoissonError` says what is wrong with it."""
    said = dict(_merged(defaults, entry.pairs))
    names = ", ".join(grammar.tools())
    if grammar.TOOL not in said:
        raise ValueError(f'"{grammar.TOOL}" is missing; it can be {names}')
    name = said[grammar.TOOL]
    tool = grammar.tools().get(name) if isinstance(name, str) else None
    if tool is None:
        raise ValueError(f'there is no tool "{name}"; there are {names}')
    common = tuple(pair for pair in defaults if tool.knows(pair[0]))
    own = tuple(pair for pair in entry.pairs if pair[0] != grammar.TOOL)
    words = tool.words(_merged(_merged(common, own), forced), folder)
    return Task(number, entry.line, tool.name, _jobs(tool, words), tuple(words))


def _jobs(tool: grammar.Tool, words: Sequence[str]) -> tuple[Job | MaskJob, ...]:
    """What a command would do, as its own code says it."""
    try:
        with (
            attended.handed_over() as jobs,
            tool.command.make_context(tool.name, ["--quiet", *words], obj=Chatter()) as context,
        ):
            tool.command.invoke(context)
    except click.ClickException as error:
        raise ValueError(error.format_message()) from error
    return tuple(jobs)


def _collisions(tasks: Sequence[Task]) -> Iterator[Mistake]:
    """Jobs that get in each other's way, so that the result would depend on which is faster.

    Two that write one file; one that reads what another writes; and one that replaces what it reads, which a second
    attempt would do a second time.
    """
    folders: dict[Path, str] = {}  # many files share one

    def real(path: Path) -> str:
        if path.is_symlink():
            return os.path.realpath(path)
        if path.parent not in folders:
            folders[path.parent] = os.path.realpath(path.parent)
        return os.path.join(folders[path.parent], path.name)

    writers: dict[str, Task] = {}
    for task in tasks:
        for path in task.outputs:
            first = writers.setdefault(real(path), task)
            if first is not task:
                yield Mistake(
                    task.line, f"{path} is also written by line {first.line}; give each its own name"
                )
    for task in tasks:
        for path in _inputs(task):
            writer = writers.get(real(path))
            if writer is task:
                yield Mistake(task.line, f"{path} is read and written; give the output another name")
            elif writer is not None:
                text = f"{path} is written by line {writer.line}; read it in another batch, after this one"
                yield Mistake(task.line, text)


def _inputs(task: Task) -> Iterator[Path]:
    """The files that a job reads; of a mask, without the part of the file that is meant."""
    for job in task.jobs:
        if isinstance(job, MaskJob):
            yield job.image
        else:
            yield job.destination
            if job.source is not None:
                yield job.source
            edges = job.edges if job.then is None else job.then.flatten
            if edges is not None and edges.file is not None:
                yield edges.file
        for step in () if job.selection is None else job.selection.steps:
            if isinstance(step, Combine) and isinstance(step.area, MaskFile):
                yield Path(step.area.name)
