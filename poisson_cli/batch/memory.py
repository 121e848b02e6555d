"""How much memory jobs take, and how much there is: a job starts only if it fits beside those that run.

An estimate is for planning. It is made of what the headers of the pictures say, before anything is decoded, and takes
a selection to be as large as it can be, so that it is rather too high: for a large selection by a half, for a small one
in a mask picture up to seven times.
"""

from __future__ import annotations

import functools
import math
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from poisson_cli.batch import groups
from poisson_cli.batch.task import Task
from poisson_cli.images.depth import Depth
from poisson_cli.images.size import Size, peek
from poisson_cli.masking import MaskJob
from poisson_cli.settings import Area, Ellipse, Grow, Polygon, Rectangle, Selection

__all__ = ["available", "estimator", "said"]

WORKER: Final = 128 << 20
"""Bytes of a worker that does nothing yet: the interpreter, numpy, the compiled solver."""

PER_PIXEL: Final[dict[Depth, int]] = {"8": 10, "16": 16, "float": 30}
"""Bytes for each pixel of each picture: as decoded, as made, as encoded, the selection, and the decoder's own."""

PER_COPY: Final[dict[Depth, int]] = {"8": 4, "16": 8, "float": 16}
"""Bytes for each pixel of a further copy of the result."""

PER_UNKNOWN: Final = 80
"""Bytes for each pixel that may be solved for, in three channels: 60 for most tools, 75 for a whole picture."""

CERTIFIED: Final = 3
"""How many times as much a proof of the error takes."""

SHARE: Final = 0.8
"""Of the memory that is free when the batch begins."""


def estimator() -> Callable[[Task], int]:
    """A function that estimates the bytes of a job; it looks at a picture that many jobs share once."""
    sizes = functools.lru_cache(maxsize=4096)(peek)
    return functools.partial(_estimate, sizes=sizes)


def _estimate(task: Task, sizes: Callable[[Path], Size | None]) -> int:
    bytes_ = WORKER
    for job in task.jobs:
        paths = [job.image] if isinstance(job, MaskJob) else [job.destination, job.source]
        pictures = [size for path in paths if path is not None and (size := sizes(path)) is not None]
        if not pictures:
            continue  # it will fail, or comes from a pipe
        depth = max((*(size.depth for size in pictures), job.output.bit_depth or "8"), key=_DEPTHS.index)
        pixels = [size.height * size.width for size in pictures]
        bytes_ += PER_PIXEL[depth] * sum(pixels)
        if isinstance(job, MaskJob):
            bytes_ += PER_COPY[depth] * pixels[0]
            continue
        unknowns = pixels[0] if job.selection is None else int(min(*pixels, _extent(job.selection)))
        bytes_ += PER_UNKNOWN * (CERTIFIED if job.solver.certify else 1) * unknowns
        if job.preview is not None:
            bytes_ += 9 * PER_COPY[depth] * pixels[0]
    return bytes_


_DEPTHS: Final[tuple[Depth, ...]] = ("8", "16", "float")


def _extent(selection: Selection) -> float:
    """Pixels of the rectangle around a selection, which is what is worked on; inf where only a file tells."""
    if selection.invert:
        return math.inf
    first, last = [math.inf, math.inf], [-math.inf, -math.inf]
    for step in selection.steps:
        if isinstance(step, Grow):
            by = max(0, step.pixels)
            first, last = [at - by for at in first], [at + by for at in last]
        elif step.how == "add":
            for low, high, axis in _spans(step.area):
                first[axis], last[axis] = min(first[axis], low), max(last[axis], high)
    return math.prod(max(0.0, high - low) for low, high in zip(first, last, strict=True))


def _spans(area: Area) -> Iterator[tuple[float, float, int]]:
    """From where to where an area reaches, by rows (0) and by columns (1)."""
    if isinstance(area, Ellipse):
        area = area.box
    if isinstance(area, Rectangle):
        yield area.row, area.row + area.height, 0
        yield area.col, area.col + area.width, 1
    elif isinstance(area, Polygon):
        for axis, places in enumerate(zip(*area.points, strict=True)):
            yield math.floor(min(places)), math.ceil(max(places)), axis
    else:
        yield from ((-math.inf, math.inf, axis) for axis in (0, 1))


def available() -> int:
    """Bytes that a batch may use: a share of what is free, and of what its group of processes may use."""
    least = min(_free(), groups.memory())
    return sys.maxsize if math.isinf(least) else int(SHARE * least)


def _free() -> float:
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024.0 * int(line.split()[1])
    except OSError:
        pass
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return math.inf  # a system that does not tell


def said(size: int) -> str:
    """A number of bytes for a person, such as ``1.5 GiB``."""
    return f"{size / (1 << 30):.1f} GiB" if size >= 1 << 30 else f"{math.ceil(size / (1 << 20))} MiB"
