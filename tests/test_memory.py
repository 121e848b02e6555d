"""Beside the pictures there is little: the solver's own fields, and bands of a few rows."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import solvers.canvas
import solvers.memory
from poisson_cli.editing import clone, mix
from poisson_cli.editing.guidance import mixed
from poisson_cli.editing.layers import Layer
from poisson_cli.editing.placement import place
from poisson_cli.editing.window import Window
from solvers import Guidance, PoissonProblem
from solvers.canvas import gather
from solvers.memory import Arena
from tests.photographs import crop
from tests.regions import SHAPES, disk
from tests.tools import TOOLS

BYTES_PER_PIXEL = 64
"""Of the crop, in three channels (issue: "It must show")."""


CHILD = """
import sys
from pathlib import Path
import numpy as np
import solvers.memory
from tests.regions import disk
from tests.tools import TOOLS

def resident(entry):  # getrusage would tell the peak of the process that this one was forked from
    status = Path("/proc/self/status").read_text()
    return 1024 * int(status.partition(entry + ":")[2].split()[0])

solvers.memory.KEPT = 0  # as with pictures so large that nothing is kept
tool, dtype, side = TOOLS[sys.argv[1]], np.dtype(sys.argv[2]), int(sys.argv[3])
mask = disk(side, side)
mask = mask[mask.any(1)][:, mask.any(0)]
mask = np.pad(mask, 1)  # the picture is the crop
destination, source = (np.empty((*mask.shape, 3), dtype) for _ in range(2))
rng = np.random.default_rng(0)
for rows in zip(destination, source):
    for row in rows:
        row[:] = rng.integers(40, 200, row.shape) * (1 if dtype.kind == "u" else 1 / 255)
tool.edit(destination[:99, :99], source[:99, :99], disk(99, 99))  # compiles
Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
before = resident("VmRSS")
image = tool.edit(destination, source, mask, tolerance=0.1, threads=1).image
print((resident("VmHWM") - before - image.nbytes) / mask.size)
"""


@pytest.mark.parametrize(
    ("tool", "dtype"), [("clone", "u1"), ("average", "u2"), ("mix", "u1"), ("fill", "u1"), ("clone", "f4")]
)
def test_bytes_per_pixel_beyond_the_pictures(tool, dtype):
    """In a process of its own, which has no memory left from other tests; by Linux' own books, so only there.

    What `tracemalloc` would tell counts arrays that are laid out for all levels and never touched but on one.
    """
    child = subprocess.run(
        [sys.executable, "-c", CHILD, tool, dtype, "2000"],
        cwd=Path(__file__).parent.parent,
        env=os.environ | {"MALLOC_TRIM_THRESHOLD_": "0", "MALLOC_MMAP_THRESHOLD_": "65536"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert 40 < float(child.stdout) <= BYTES_PER_PIXEL


# --- bands -------------------------------------------------------------------------------------------------------


@pytest.fixture
def narrow_bands(monkeypatch):
    """Call it to have bands of two rows from then on, the fewest that there can be."""

    def narrow() -> None:
        monkeypatch.setattr(solvers.canvas, "BAND", 1)
        monkeypatch.setattr(solvers.canvas, "FEWEST_ROWS", 2)

    return narrow


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("shape", ["lasso", "noise", "edge_touching", "unknown_frame", "strokes_of_1_pixel"])
def test_bands_change_no_bit(tool, dtype, shape, narrow_bands):
    scale = {np.uint8: 1, np.uint16: 257}.get(dtype, 1 / 255)
    destination, source = (
        (crop(name, 45, 38) * np.float64(scale)).astype(dtype) for name in ("coffee.png", "chelsea.png")
    )
    mask = SHAPES[shape](45, 38)
    whole = TOOLS[tool].edit(destination, source, mask)
    narrow_bands()
    banded = TOOLS[tool].edit(destination, source, mask)
    assert banded.image.tobytes() == whole.image.tobytes()
    assert banded.report.clipped == whole.report.clipped


@pytest.mark.parametrize("offset", [(0, 0), (3, 2), (-3, 2), (2, -5), (-4, -4)])
@pytest.mark.parametrize("tool", [clone, mix])
def test_bands_where_the_source_ends(tool, offset, narrow_bands):
    destination, source = crop("coffee.png", 33, 30), crop("chelsea.png", 33, 30)
    whole = tool(destination, source, np.ones((33, 30), bool), offset=offset).image
    narrow_bands()
    assert np.array_equal(tool(destination, source, np.ones((33, 30), bool), offset=offset).image, whole)


def test_a_picture_of_which_nothing_is_known(narrow_bands):
    """The mean of the destination is kept: it is taken over all bands."""
    narrow_bands()
    destination, source = crop("coffee.png", 31, 30) / 255, crop("chelsea.png", 31, 30) / 255
    image = clone(destination, source, np.ones((31, 30), bool)).image
    assert image.mean((0, 1)) == pytest.approx(destination.mean((0, 1)), abs=1e-9)
    assert np.ptp(image - source, axis=(0, 1)).max() <= 1e-5


def test_what_a_canvas_hands_out_in_bands_is_the_whole_problem(narrow_bands):
    destination, source = crop("coffee.png", 31, 30), crop("chelsea.png", 31, 30)
    placement = place(destination.shape, source.shape, disk(31, 30))
    window = Window(destination, placement, Layer.of_source(source, placement, 3), mixed)
    problem = PoissonProblem.on_canvas(placement.region, window)
    at_once = gather(window)
    narrow_bands()
    for name in ("values", "across", "down"):
        assert np.array_equal(getattr(gather(window), name), getattr(at_once, name))
    assert problem.guidance is not None
    assert problem.rhs is None
    # f* - g, and the stronger gradient less the source's, of the same rows and columns
    rows, cols = (
        slice(start, start + n)
        for start, n in zip((placement.top, placement.left), problem.region.shape, strict=True)
    )
    f, g = destination[rows, cols].astype(float), source[rows, cols].astype(float)
    assert np.array_equal(problem.values, np.where(problem.region[..., None], 0, f - g))
    for part in ("across", "down"):
        own, other = getattr(Guidance.of(f), part), getattr(Guidance.of(g), part)
        w = np.where(abs(own) > abs(other), own - other, 0)
        assert np.array_equal(getattr(problem.guidance, part), w)


def test_a_canvas_of_another_size_is_refused():
    canvas = PoissonProblem(disk(20, 20), np.zeros((20, 20))).canvas
    with pytest.raises(ValueError, match="canvas"):
        PoissonProblem.on_canvas(disk(20, 21), canvas)
    with pytest.raises(ValueError, match="level"):
        PoissonProblem.on_canvas(disk(20, 20), canvas, level=0)


# --- the arena ---------------------------------------------------------------------------------------------------


def test_the_arena_takes_back_only_what_nobody_looks_at():
    arena = Arena()
    kept, dropped = arena.zeros(100), arena.zeros(80)
    part = dropped[10:20]
    part[:] = 1
    del dropped
    arena.reclaim()
    assert not np.shares_memory(arena.zeros(80), part)
    assert (part == 1).all()
    where = part.ctypes.data
    del part
    arena.reclaim()
    again = arena.zeros(75)
    assert 0 <= where - again.ctypes.data < 80 * 4
    assert (again == 0).all()
    assert not np.shares_memory(again, kept)


def test_the_arena_keeps_no_more_than_it_may(monkeypatch):
    monkeypatch.setattr(solvers.memory, "KEPT", 1000)
    arena = Arena()
    first = arena.zeros(400).ctypes.data
    arena.rewind()
    assert arena.zeros(300).ctypes.data == first
    arena.zeros(900)
    arena.rewind()
    assert arena._idle == []
