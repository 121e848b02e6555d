"""One edit from files to a file: read, select, edit, write.

A `Job` is plain data, so whatever can build one can run one: a subcommand from its options today, a line of a manifest
just as well. Nothing is printed here.
"""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from poisson_cli import answering, editing
from poisson_cli.errors import InputError
from poisson_cli.images import Picture, prepare, read, write
from poisson_cli.masks import Canvas, leave_out_transparent, select
from poisson_cli.settings import Output, Placement, Selection, Solver

__all__ = ["Job", "Summary", "run"]


@dataclass(frozen=True)
class Job:
    """What to do with which files.

    Parameters
    ----------
    tool
        Name of a function in `poisson_cli.editing`.
    destination
        The picture that is edited.
    selection
        Which pixels.
    output
        Where the result goes.
    source
        The picture whose gradients are cloned; None for a tool that needs none.
    placement
        Where the source lies; of no effect without one.
    solver
        How the equations are solved.
    parameters
        Further keywords of the tool.
    """

    tool: str
    destination: Path
    selection: Selection
    output: Output
    source: Path | None = None
    placement: Placement = Placement()
    solver: Solver = Solver()
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Summary:
    """What was done.

    Parameters
    ----------
    edit
        What the tool says.
    selected
        Pixels in the selection, before any of them fell off the destination.
    output
        The file that was written.
    seconds
        Seconds per stage in order, reading and writing included.
    profile_dropped
        Whether the destination's ICC profile had to stay behind, because the format cannot hold it.
    notices
        What the user should know about the inputs, a line each.
    """

    edit: editing.EditReport
    selected: int
    output: Path
    seconds: Mapping[str, float]
    profile_dropped: bool
    notices: tuple[str, ...] = ()


def run(job: Job, progress: Callable[[int, float], None] | None = None) -> Summary:
    """Do a job.

    Parameters
    ----------
    job
        What to do.
    progress
        Called as the solver goes, with the cycles or sweeps so far and the estimated error in levels.

    Returns
    -------
    Summary
        What was done; the output is on the disk.

    Raises
    ------
    InputError, OutputError, NotConverged
        Nothing was written.
    """
    seconds: dict[str, float] = {}
    target = prepare(job.output.path, overwrite=job.output.overwrite)
    with _timed(seconds, "read"):
        destination = read(job.destination)
        target.check_fits(destination)
        source = None if job.source is None else _read_source(job, destination)
    with _timed(seconds, "select"):
        selected = select(job.selection, _canvas(job, destination, source))
        if source is not None:
            where = job.placement
            selected = leave_out_transparent(
                selected, source, job.selection.threshold, where.offset, where.mask_on
            )
    mask = selected.mask
    tool: Callable[..., editing.Edit] = getattr(editing, job.tool)
    keywords = {**dataclasses.asdict(job.solver), "progress": progress, **job.parameters}
    if source is None:
        work = functools.partial(tool, destination.pixels, mask, **keywords)
    else:
        work = functools.partial(
            tool,
            destination.pixels,
            source.pixels,
            mask,
            offset=job.placement.offset,
            mask_on=job.placement.mask_on,
            **keywords,
        )
    edit = answering.do(work)
    seconds |= edit.report.seconds
    with _timed(seconds, "write"):
        write(target, dataclasses.replace(destination, pixels=edit.image))
    profile = destination.profile
    return Summary(
        edit=edit.report,
        selected=int(np.count_nonzero(mask)),
        output=job.output.path,
        seconds=seconds,
        profile_dropped=profile is not None and not target.form.can_hold_profile(profile),
        notices=selected.notices,
    )


def _read_source(job: Job, destination: Picture) -> Picture:
    """Read the source, and refuse one whose colours have no place in the destination."""
    assert job.source is not None
    source = read(job.source)
    if source.pixels.ndim > destination.pixels.ndim and not job.parameters.get("monochrome"):
        way_out = " or add --monochrome" if "monochrome" in job.parameters else ""
        raise InputError(
            f"{source.name} is {source.layout}, but the destination {destination.name} is {destination.layout}; "
            f"convert one of them{way_out}"
        )
    return source


def _canvas(job: Job, destination: Picture, source: Picture | None) -> Canvas:
    """The picture that the selection is drawn on."""
    if source is None:
        return Canvas("image", destination)
    roles = {"source": source, "destination": destination}
    other = "destination" if job.placement.mask_on == "source" else "source"
    return Canvas(job.placement.mask_on, roles[job.placement.mask_on], (other, roles[other]))


@contextmanager
def _timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    started = time.perf_counter()
    yield
    seconds[stage] = time.perf_counter() - started
