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

from poisson_cli import answering, editing, images, interrupts
from poisson_cli.errors import InputError
from poisson_cli.images import Asking, Depth, Picture, Target
from poisson_cli.masks import Canvas, select
from poisson_cli.settings import Inputs, Output, Placement, Selection, Solver

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
    inputs
        How all the pictures are read.
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
    inputs: Inputs = Inputs()
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
        What the user should know about the inputs and the output, a line each.
    """

    edit: editing.EditReport
    selected: int
    output: Path
    seconds: Mapping[str, float]
    profile_dropped: bool
    notices: tuple[str, ...] = ()


def run(
    job: Job,
    progress: Callable[[int, float], None] | None = None,
    before_commit: Callable[[], None] | None = interrupts.finishing.set,
) -> Summary:
    """Do a job.

    Parameters
    ----------
    job
        What to do.
    progress
        Called as the solver goes, with the cycles or sweeps so far and the estimated error in levels.
    before_commit
        Called when the output is about to take its name; by default nothing stops the process from then on.

    Returns
    -------
    Summary
        What was done; the output is on the disk.

    Raises
    ------
    InputError, OutputError, NotConverged
        Nothing was written.
    """
    output = job.output
    target = images.prepare(
        output.path, overwrite=output.overwrite, form=output.format, quality=output.quality
    )
    with images.asking(job.inputs.page, job.inputs.max_pixels) as asking:
        return _run(job, target, asking, progress, before_commit)


def _run(
    job: Job,
    target: Target,
    asking: Asking,
    progress: Callable[[int, float], None] | None,
    before_commit: Callable[[], None] | None,
) -> Summary:
    """The job, with notices gathered in `asking`."""
    seconds: dict[str, float] = {}
    with _timed(seconds, "read"):
        destination = images.read(job.destination)
        if job.output.bit_depth is not None:
            destination = _in_depth(destination, job.output.bit_depth, "as asked for", asking)
        target.check_fits(destination)
        source = None if job.source is None else _read_source(job, destination, asking)
    with _timed(seconds, "select"):
        mask = select(job.selection, _canvas(job, destination, source))
        asking.refuse_unpaged()
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
    dropped = images.fitting(destination.metadata, target.form)[1]
    with _timed(seconds, "write"):
        result = dataclasses.replace(destination, pixels=edit.image)
        images.write(target, result, before_commit=before_commit)
    left = [kind for kind in dropped if kind != "profile"]
    if left:
        asking.notices.append(f"left out of the output, which cannot hold it: {', '.join(left)}")
    return Summary(
        edit=edit.report,
        selected=int(np.count_nonzero(mask)),
        output=job.output.path,
        seconds=seconds,
        profile_dropped="profile" in dropped,
        notices=tuple(asking.notices),
    )


def _read_source(job: Job, destination: Picture, asking: Asking) -> Picture:
    """Read the source, refuse one whose colours have no place in the destination, and bring it to its scale."""
    assert job.source is not None
    source = images.read(job.source)
    if source.alpha is not None and source.in_8_bits().alpha.min() < 255:  # type: ignore[union-attr]
        raise InputError(
            f"{source.name}: the source is transparent in places; flatten it onto a background first "
            "(as a mask, with -m, its opaque part selects)"
        )
    if source.pixels.ndim > destination.pixels.ndim and not job.parameters.get("monochrome"):
        way_out = " or add --monochrome" if "monochrome" in job.parameters else ""
        raise InputError(
            f"{source.name} is {source.layout}, but the destination {destination.name} is {destination.layout}; "
            f"convert one of them{way_out}"
        )
    one, other = source.metadata.profile, destination.metadata.profile
    if not images.same_colours(one, other):
        asking.notices.append(
            f"the colours of {source.name} ({images.called(one)}) are taken as if they were those of "
            f"{destination.name} ({images.called(other)})"
        )
    source = _in_depth(source, destination.depth, "the destination's", asking)
    return dataclasses.replace(source, alpha=None)


def _in_depth(picture: Picture, depth: Depth, why: str, asking: Asking) -> Picture:
    """A picture in another depth, with a notice if that changes anything."""
    if picture.depth == depth:
        return picture
    converted, lost = picture.converted(depth)
    notice = f"{picture.name} is converted from {images.in_words(picture.depth)} to {images.in_words(depth)}, {why}"
    if lost.clipped:
        notice += f"; {lost.clipped:,} values outside 0 to 1 are clipped"
    if lost.undefined:
        notice += f"; {lost.undefined:,} values that are no numbers become 0"
    asking.notices.append(notice)
    return converted


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
