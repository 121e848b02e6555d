"""How much memory jobs take, and how much there is: a job starts only if it fits beside those that run.

An estimate is for planning. It is made of what the headers of the pictures say, before anything is decoded, and takes
every selection to be as large as it can be, so that it is rather too high.
"""

from __future__ import annotations

import functools
import math
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Final

from poisson_cli.batch.task import Task
from poisson_cli.images.size import peek
from poisson_cli.job import Job
from poisson_cli.masking import MaskJob

__all__ = ["available", "estimator", "said"]

WORKER: Final = 128 << 20
"""Bytes of a worker that does nothing yet: the interpreter, numpy, the compiled solver."""

PER_PIXEL: Final = 24
"""Bytes for each pixel of each picture: as decoded, as made, as encoded, the selection, and the decoder's own."""

PER_UNKNOWN: Final = 96
"""Bytes for each pixel that may be solved for, in three channels, half as much again as is measured for most tools."""

SHARE: Final = 0.8
"""Of the memory that is free when the batch begins."""


def estimator() -> Callable[[Task], int]:
    """A function that estimates the bytes of a job; it looks at a picture that many jobs share once."""
    sizes = functools.lru_cache(maxsize=4096)(peek)
    return functools.partial(_estimate, sizes=sizes)


def _estimate(task: Task, sizes: Callable[[Path], tuple[int, int] | None]) -> int:
    def pixels(path: Path) -> int:
        size = sizes(path)
        return 0 if size is None else math.prod(size)

    bytes_ = WORKER
    for job in task.jobs:
        if isinstance(job, MaskJob):
            bytes_ += 2 * PER_PIXEL * pixels(job.image)
        elif isinstance(job, Job):
            pictures = [pixels(path) for path in (job.destination, job.source) if path is not None]
            unknowns = min(n for n in pictures if n) if any(pictures) else 0
            larger = 1 if job.preview is None else 9
            bytes_ += PER_PIXEL * (larger * pictures[0] + sum(pictures[1:])) + PER_UNKNOWN * unknowns
    return bytes_


def available() -> int:
    """Bytes that a batch may use: a share of what is free, and of what its group of processes may use."""
    least = min(_free(), _group_limit())
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


def _group_limit() -> float:
    """What a container, or a job of a cluster, may still take (Linux, control groups 2)."""
    try:
        group = Path("/proc/self/cgroup").read_text().strip().rpartition("::")[2]
        folder = Path("/sys/fs/cgroup") / group.lstrip("/")
        limit, used = ((folder / f"memory.{name}").read_text().strip() for name in ("max", "current"))
        return math.inf if limit == "max" else max(0.0, float(limit) - float(used))
    except (OSError, ValueError):
        return math.inf


def said(size: int) -> str:
    """A number of bytes for a person, such as ``1.5 GiB``."""
    return f"{size / (1 << 30):.1f} GiB" if size >= 1 << 30 else f"{math.ceil(size / (1 << 20))} MiB"
