"""`python -m benchmarks memory`: what a clone of a large colour disk needs beyond the pictures.

A child process makes the pictures, lets a small clone load and compile everything, notes its resident memory, clones,
and notes the peak.  Beyond the pictures is the peak less that baseline (interpreter, libraries, both pictures and
the mask) and less the result.  It is told per pixel of the crop, the region's bounding box and the ring around it.

The answer is checked without solving anything: the destination is the source plus a ramp u, black in the disk.  A ramp
is harmonic, so the solution is source + u again, within the half level that the destination was rounded by along the
rim (maximum principle), and the picture shows it within another half.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks import machine, pictures, shapes
from benchmarks.table import duration, render, three

Array = np.ndarray[Any, Any]

LIMIT = 64.0  # bytes per pixel of the crop
OFF = 1.01  # levels: what no value may be off, two halves and the solver's tolerance
MEAN_OFF = 0.1  # and the middle of the picture on average: it hardly feels how single pixels were rounded
RAMP = 50.0  # levels
ROWS = 16  # of a picture that are checked at a time
SMALL = 4_000  # pixels, to warm up with
HEADER = (
    "region",
    "unknowns",
    "crop",
    "pictures",
    "beyond them",
    "bytes per pixel",
    "clone",
    "largest error",
    "mean error",
)


def run(arguments: Namespace) -> list[str]:
    pixels = round(arguments.megapixels * 1e6)
    root = Path(__file__).resolve().parent.parent.parent
    # Freed memory goes back at once, so that what is resident is what is used.
    environment = os.environ | {"MALLOC_TRIM_THRESHOLD_": "0", "MALLOC_MMAP_THRESHOLD_": "65536"}
    child = subprocess.run(
        [sys.executable, "-m", __name__, str(pixels)],
        cwd=root,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    found = json.loads(child.stdout)
    print(machine.describe())
    print("\nA clone of a disk in 3 channels, uint8 -> uint8, one thread, in a process of its own.\n")
    per_pixel = found["beyond"] / found["crop"]
    row = [
        "disk",
        f"{found['unknowns']:,}",
        f"{found['crop']:,}",
        _mebibytes(found["pictures"]),
        _mebibytes(found["beyond"]),
        three(per_pixel),
        duration(found["seconds"]),
        three(found["largest"]),
        three(found["mean"]),
    ]
    print(render(HEADER, [row], markdown=arguments.markdown))
    wrong = []
    if per_pixel > LIMIT:
        wrong.append(f"{per_pixel:.1f} bytes per pixel of the crop, {LIMIT:g} are allowed")
    if not (found["largest"] <= OFF and found["mean"] <= MEAN_OFF):
        wrong.append(f"off by {found['largest']:.3g} levels at most, by {found['mean']:.3g} in the middle")
    if found["outside"]:
        wrong.append("pixels outside the region were changed")
    return wrong


def measure(pixels: int) -> dict[str, Any]:
    """One clone of a disk whose crop has about so many pixels; in a fresh process."""
    from poisson_cli.editing import clone

    small = _pictures(shapes.disk_of(SMALL))
    clone(*small, threads=1)
    region = shapes.disk_of(round(pixels * np.pi / 4))
    destination, source, mask = _pictures(region)
    baseline = _resident("VmRSS")
    _forget_peak()
    start = perf_counter()
    edit = clone(destination, source, mask, threads=1)
    seconds = perf_counter() - start
    peak = _resident("VmHWM")
    largest, mean = errors(source, mask, edit.image)
    _, _, height, width = edit.report.rectangle
    return {
        "unknowns": edit.report.unknowns,
        "crop": (height + 2) * (width + 2),
        "pictures": destination.nbytes + source.nbytes + mask.nbytes + edit.image.nbytes,
        "beyond": peak - baseline - edit.image.nbytes,
        "seconds": seconds,
        "largest": largest,
        "mean": mean,
        "outside": int(np.count_nonzero((edit.image != destination).any(2) & ~mask)),
    }


def errors(source: Array, mask: Array, image: Array) -> tuple[float, float]:
    """Largest error of a value inside, and size of the mean error in the middle ninth of the picture; in levels."""
    largest, total, count = 0.0, 0.0, 0
    height, width = mask.shape
    for rows in _bands(height):
        off = image[rows] - _exact(source, rows)
        largest = max(largest, float(np.abs(off[mask[rows]]).max(initial=0.0)))
        if height // 3 <= rows.start and rows.stop <= height * 2 // 3:
            middle = off[:, width // 3 : width * 2 // 3]
            total += float(middle.sum(dtype=np.float64))
            count += middle.size
    return largest, abs(total) / max(count, 1)


def _pictures(region: Array) -> tuple[Array, Array, Array]:
    source = pictures.source(*region.shape) // 2 + np.uint8(64)
    destination = np.empty_like(source)
    for rows in _bands(len(region)):
        destination[rows] = np.rint(_exact(source, rows))
        destination[rows][region[rows]] = 0
    return destination, source, region


def _exact(source: Array, rows: slice) -> Array:
    """The source plus the ramp, from -RAMP in one corner to RAMP in the opposite one."""
    height, width = source.shape[:2]
    row = np.arange(rows.start, rows.stop, dtype=np.float32)[:, None, None] / height
    col = np.arange(width, dtype=np.float32)[:, None] / width
    exact: Array = source[rows] + np.float32(RAMP) * (row + col - 1)
    return exact


def _bands(height: int) -> Iterator[slice]:
    for first in range(0, height, ROWS):
        yield slice(first, min(first + ROWS, height))


def _resident(entry: str) -> int:
    """Bytes, as the system's `entry` for this process says."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(entry + ":"):
            return int(line.split()[1]) * 1024
    raise OSError(f"the system does not tell {entry}")


def _forget_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def _mebibytes(n: float) -> str:
    return f"{three(n / 2**20)} MiB"


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))
