"""From the lines of a manifest to tasks, all of them or none: every line is checked before the first job runs.

What is checked is what a command line says of itself before it looks at any picture, and what jobs that run side by
side may not do to each other. A picture that is missing or broken is no mistake of the manifest; it fails its job.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Final

from poisson_cli.batch import grammar
from poisson_cli.batch.collisions import collisions
from poisson_cli.batch.manifest import Entry, Manifest, Pairs
from poisson_cli.batch.mistakes import Mistake, Mistakes
from poisson_cli.batch.outputs import unwritable
from poisson_cli.batch.reading import Reader
from poisson_cli.batch.task import Task
from poisson_cli.errors import PoissonError

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
    make_folders: bool = False,
    name: str = "job",
    watch: Callable[[int, int], None] = lambda checked, lines: None,
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
    make_folders
        Whether folders that outputs go to will be made, so that they need not be there.
    name
        What to call the manifest.
    watch
        Called with the number of lines that are checked so far, and of all.

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
        if not _is_known(key):
            line = 0 if key in dict(defaults) else manifest.defaults.line
            mistakes.append(Mistake(line, f'no tool has the default "{key}"'))
    if head := _unknown_columns(manifest, for_all):
        raise Mistakes([*mistakes, head], name)  # each row would say the same again
    forced: Pairs = (("overwrite", True),) if overwrite else ()
    reader = Reader()
    tasks = []
    for number, entry in enumerate(manifest.entries, start=1):
        try:
            task = _task(number, entry, for_all, forced, folder, reader)
        except (ValueError, PoissonError) as error:
            mistakes.append(Mistake(entry.line, " ".join(str(error).split())))
        else:
            tasks.append(task)
        watch(number, len(manifest.entries))
    mistakes += unwritable(tasks, make_folders=make_folders)
    mistakes += collisions(tasks)
    if mistakes:
        raise Mistakes(sorted(mistakes, key=lambda mistake: mistake.line), name)
    if skip_existing:
        return [dataclasses.replace(task, skip_existing=True) for task in tasks]
    return tasks


def _is_known(name: str) -> bool:
    return grammar.key_of(name) == grammar.TOOL or any(tool.knows(name) for tool in grammar.tools().values())


def _unknown_columns(manifest: Manifest, defaults: Pairs) -> Mistake | None:
    """What is wrong with the first line of CSV."""
    unknown = [name for name in manifest.columns if not _is_known(name)]
    if not manifest.columns or not (unknown or grammar.TOOL not in {*manifest.columns, *dict(defaults)}):
        return None
    if len(unknown) == len(manifest.columns):
        text = "neither a job in JSON nor, for CSV, names of columns such as tool,image,rect,output"
    elif unknown:
        text = f'no tool knows what the column "{unknown[0]}" says'
    else:
        text = f'no column is named "{grammar.TOOL}"'
    return Mistake(manifest.head, text)


def _merged(pairs: Pairs, winning: Pairs) -> Pairs:
    """Two lists of names and values; what both name is as the second has it."""
    keys = {grammar.key_of(name) for name, _ in winning}
    return (*(pair for pair in pairs if grammar.key_of(pair[0]) not in keys), *winning)


def _task(number: int, entry: Entry, defaults: Pairs, forced: Pairs, folder: str, reader: Reader) -> Task:
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
    return Task(number, entry.line, tool.name, reader.jobs(tool, words), tuple(words))
