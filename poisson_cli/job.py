"""One edit from files to a file: read, select, edit, write.

A `Job` is plain data (`poisson_cli.settings`), so whatever can build one can run one: a subcommand from its options, a
line of a manifest just as well. Nothing is printed here.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poisson_cli import answering, editing, images, interrupts, steps
from poisson_cli.errors import InputError
from poisson_cli.images import Asking, Depth, Picture, Target
from poisson_cli.images.depth import DTYPES, full_scale
from poisson_cli.masks import Canvas, leave_out_transparent, select
from poisson_cli.settings import Edges, Job

__all__ = ["Job", "Progress", "Summary", "outputs", "run", "run_together"]

Progress = Callable[[int, float], None]
"""Called as the solver goes, with the cycles or sweeps so far and the estimated error in levels."""

_OF_ANY_RANGE: Final = frozenset({"tonemap"})
"""Tools that bring any range into 0 to 1: if a smaller depth is asked for, what they make is converted, and not what
they are given, which would be cut off first."""


class Summary(NamedTuple):
    """What was done.

    Parameters
    ----------
    edit
        What the tool says.
    selected
        Pixels in the selection, before any of them fell off the destination; None where nothing is selected.
    output
        The file that was written.
    seconds
        Seconds per stage in order, reading and writing included.
    profile_dropped
        Whether the destination's ICC profile had to stay behind, because the format cannot hold it.
    beside
        Other files that were written: what they show, and where.
    guarded
        Whether anything was done against colours that bleed in.
    tinted
        Whether the source has no hue of its own, so that the destination's is wanted.
    notices
        What the user should know about the inputs and the output, a line each.
    """

    edit: editing.EditReport
    selected: int | None
    output: Path
    seconds: Mapping[str, float]
    profile_dropped: bool
    beside: Mapping[str, Path] = {}
    guarded: bool = False
    tinted: bool = False
    notices: tuple[str, ...] = ()


def outputs(job: Job) -> dict[str, Path]:
    """Every file that a job writes, by what it shows: ``"result"`` first, then ``"edges"`` and ``"preview"``."""
    edges = _edges(job)
    wanted = {
        "result": job.output.path,
        "edges": None if edges is None else edges.show,
        "preview": job.preview,
    }
    return {what: path for what, path in wanted.items() if path is not None}


def run(
    job: Job, progress: Progress | None = None, before_commit: images.Committing = interrupts.finishing.set
) -> Summary:
    """Do a job.

    Parameters
    ----------
    job
        What to do.
    progress
        Called as the solver goes.
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
    (summary,) = run_together([job], progress, before_commit)
    return summary


def run_together(
    jobs: Sequence[Job],
    progress: Progress | None = None,
    before_commit: images.Committing = interrupts.finishing.set,
) -> list[Summary]:
    """Do several jobs on aligned pictures: all of them, or none.

    Parameters
    ----------
    jobs
        What to do; their destinations must have one size.
    progress, before_commit
        As in `run`.

    Returns
    -------
    list of Summary
        What was done, in the order of the jobs; all outputs are on the disk. Each has its share of the time that
        writing took.

    Raises
    ------
    InputError, OutputError, NotConverged
        Nothing was written.
    """
    targets = [_targets(job) for job in jobs]
    images.refuse_doubles([target for one in targets for target in one.values()])
    stages: list[dict[str, float]] = [{} for _ in jobs]
    with images.asking(jobs[0].inputs.page, jobs[0].inputs.max_pixels) as asking:
        inputs = [_read(*one, asking) for one in zip(jobs, targets, stages, strict=True)]
        _refuse_misaligned([one.destination for one in inputs])
        made = [_make(*one, asking, progress) for one in zip(jobs, inputs, stages, strict=True)]
        asking.refuse_unpaged()
    outputs = [
        (files[what], picture)
        for files, one in zip(targets, made, strict=True)
        for what, picture in one.pictures.items()
    ]
    started = time.perf_counter()
    images.write_together(outputs, before_commit)
    share = (time.perf_counter() - started) / len(jobs)
    return [
        _summary(job, one, files, {**seconds, "write": share})
        for job, one, files, seconds in zip(jobs, made, targets, stages, strict=True)
    ]


class _Inputs(NamedTuple):
    """The pictures of a job."""

    destination: Picture
    source: Picture | None


class _Made(NamedTuple):
    """What became of a job: the report, the pixels selected, notices, and the pictures to write, by what they are.

    `tinted` is that of `Summary`.
    """

    report: editing.EditReport
    selected: int | None
    notices: tuple[str, ...]
    pictures: dict[str, Picture]
    tinted: bool


def _targets(job: Job) -> dict[str, Target]:
    """Look at everything that will be written, before any work is done for it."""
    return {
        what: images.prepare(
            path,
            overwrite=job.output.overwrite,
            form=job.output.format if what == "result" else None,
            quality=job.output.quality if what == "result" else None,
        )
        for what, path in outputs(job).items()
    }


def _read(job: Job, targets: Mapping[str, Target], seconds: dict[str, float], asking: Asking) -> _Inputs:
    """Read the pictures."""
    with _timed(seconds, "read"):
        destination = images.read(job.destination)
        wanted = job.output.bit_depth
        if wanted is not None and (job.tool not in _OF_ANY_RANGE or _is_finer(wanted, destination.depth)):
            destination = _in_depth(destination, wanted, "as asked for", asking)
        for what in targets.keys() & {"result", "preview"}:
            targets[what].check_fits(_stand_in(destination, wanted))
        return _Inputs(destination, None if job.source is None else _read_source(job, destination, asking))


def _make(
    job: Job, inputs: _Inputs, seconds: dict[str, float], asking: Asking, progress: Progress | None
) -> _Made:
    """Select, and let the tool do its work."""
    destination, source = inputs
    tool: Callable[..., editing.Edit] = getattr(editing, job.tool)
    arrays: list[NDArray[Any]] = [picture.pixels for picture in inputs if picture is not None]
    keywords = {**job.solver._asdict(), "progress": progress, **job.parameters}
    n_selected: int | None = None
    if source is not None:
        keywords |= job.placement._asdict()
    if job.selection is not None:
        with _timed(seconds, "select"):
            selected = select(job.selection, _canvas(job, destination, source))
            if source is not None:
                selected = leave_out_transparent(
                    selected,
                    source,
                    job.selection.threshold,
                    job.placement.offset,
                    job.placement.mask_on,
                )
        n_selected = int(np.count_nonzero(selected.mask))
        asking.notices += selected.notices
        arrays.append(selected.mask)
    edges, edges_of = _edges(job), source or destination
    sieve = None if edges is None else steps.edge_keywords(edges, edges_of)
    if job.then is not None:
        keywords["then"] = steps.transforms(job.then, sieve)
    elif sieve is not None:
        keywords |= sieve
    edit = answering.do(functools.partial(tool, *arrays, **keywords))
    seconds |= edit.report.seconds
    result = destination._replace(pixels=edit.image, alpha=_alpha(job, destination))
    if job.output.bit_depth is not None:
        result = _in_depth(result, job.output.bit_depth, "as asked for", asking)
    pictures = {"result": result}
    if edges is not None and sieve is not None and edges.show is not None:
        pictures["edges"] = Picture(str(edges.show), steps.drawn_edges(edges_of, **sieve))
    if job.preview is not None:
        pictures["preview"] = _three_times_three(result)
    notices, asking.notices = tuple(asking.notices), []
    hueless = source is not None and source.pixels.ndim == 2
    tinted = hueless or bool(job.parameters.get("monochrome"))
    return _Made(edit.report, n_selected, notices, pictures, tinted)


def _edges(job: Job) -> Edges | None:
    """Where edges are, if anything is flattened."""
    return job.edges if job.then is None else job.then.flatten


def _alpha(job: Job, destination: Picture) -> NDArray[Any] | None:
    """The destination's opacity, cut out where the tool cuts something out."""
    rectangle = job.parameters.get("rect")
    if destination.alpha is None or rectangle is None:
        return destination.alpha
    row, col, height, width = rectangle
    return destination.alpha[row : row + height, col : col + width]


def _three_times_three(picture: Picture) -> Picture:
    """A picture side by side with itself, to see whether it tiles."""
    return picture._replace(
        pixels=np.tile(picture.pixels, (3, 3, 1)[: picture.pixels.ndim]),
        alpha=None if picture.alpha is None else np.tile(picture.alpha, (3, 3)),
    )


def _summary(job: Job, made: _Made, targets: Mapping[str, Target], seconds: Mapping[str, float]) -> Summary:
    """What to say of a job whose files are on the disk."""
    dropped = images.fitting(made.pictures["result"].metadata, targets["result"].form)[1]
    left = [kind for kind in dropped if kind != "profile"]
    notice = (f"left out of the output, which cannot hold it: {', '.join(left)}",) if left else ()
    return Summary(
        edit=made.report,
        selected=made.selected,
        output=targets["result"].path,
        seconds=seconds,
        profile_dropped="profile" in dropped,
        beside={what: target.path for what, target in targets.items() if what != "result"},
        guarded=bool(job.parameters.get("screen") or job.parameters.get("robust")),
        tinted=made.tinted,
        notices=(*made.notices, *notice),
    )


def _refuse_misaligned(pictures: Sequence[Picture]) -> None:
    """Refuse pictures that cannot be edited alike, because their sizes differ."""
    first = pictures[0]
    for picture in pictures[1:]:
        if picture.shape != first.shape:
            raise InputError(
                f"{first.name} is {first.size}, but {picture.name} is {picture.size}; pictures that belong together "
                "have one size: edit these one by one"
            )


def _read_source(job: Job, destination: Picture, asking: Asking) -> Picture:
    """Read the source, refuse one whose colours have no place in the destination, and bring it to its scale."""
    assert job.source is not None
    source = images.read(job.source)
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
    return _in_depth(source, destination.depth, "the destination's", asking)


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


def _is_finer(depth: Depth, other: Depth) -> bool:
    """Whether one depth holds all values of another, and more."""
    order: tuple[Depth, ...] = ("8", "16", "float")
    return order.index(depth) > order.index(other)


def _stand_in(picture: Picture, depth: Depth | None) -> Picture:
    """A picture of that size and depth, as opaque, that holds no values: for what must be known before there is one."""
    if depth is None:
        return picture
    nothing = DTYPES[depth].type(0)
    opacity = DTYPES[depth].type(full_scale(depth) if picture.opaque else 0)
    alpha = None if picture.alpha is None else np.broadcast_to(opacity, picture.alpha.shape)
    return picture._replace(pixels=np.broadcast_to(nothing, picture.pixels.shape), alpha=alpha)


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
