"""Narrow parts of a region, solved directly: against a sparse direct solve of eq. (7), alone and beside wide parts."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from poisson_cli import clone, mix
from poisson_cli.editing import window
from poisson_cli.editing.tools import cloning
from poisson_cli.editing.window import Window
from solvers import DEFAULT_TOLERANCE, Guidance, PoissonProblem, layout, narrow, solve_multigrid, solve_sor
from solvers.kernels import narrow as kernels
from solvers.kernels import scattered
from solvers.memory import Arena
from tests import oracles
from tests.agreement import assert_rounded_right, assert_untouched
from tests.photographs import crop
from tests.regions import LARGE, SHAPES, SMALL, disk
from tests.test_solvers_accuracy import Case

EXACT = 1e-9  # levels: ten digits more than pictures have, and what float64 is good for
THIN = [
    "one_pixel",
    "strokes_of_1_pixel",
    "strokes_of_2_pixels",
    "strokes_of_3_pixels",
    "islands",
    "unknown_frame",
]


# --- shapes ---------------------------------------------------------------------------------------------------------


def loops(height: int, width: int) -> np.ndarray:
    """Closed lines one pixel wide, one in another: no unknown is at an end."""
    row, col = np.mgrid[:height, :width]
    distance = np.minimum(np.minimum(row, height - 1 - row), np.minimum(col, width - 1 - col))
    return distance % 3 == 1


def net(height: int, width: int) -> np.ndarray:
    """Lines that cross every five pixels: many loops, one part."""
    row, col = np.mgrid[:height, :width]
    return (row % 5 == 2) | (col % 5 == 2)


def wide_net(height: int, width: int) -> np.ndarray:
    row, col = np.mgrid[:height, :width]
    return (row % 9 < 2) | (col % 11 < 3)


def comb(height: int, width: int) -> np.ndarray:
    row, col = np.mgrid[:height, :width]
    return (row == 1) | ((col % 2 == 0) & (row > 0) & (row < height - 1))


def spiral_of_1_pixel(height: int, width: int) -> np.ndarray:
    """Square, so that each turn is one known pixel away from the next."""
    region = np.zeros((height, width), bool)
    top, left, bottom, right = 0, 0, height - 1, width - 1
    while top < bottom and left < right:
        region[top, max(left - 2, 0) : right + 1] = True
        region[top : bottom + 1, right] = True
        region[bottom, left : right + 1] = True
        region[top + 2 : bottom + 1, left] = True
        top, left, bottom, right = top + 2, left + 2, bottom - 2, right - 2
    return region


def at_edges_and_corners(height: int, width: int) -> np.ndarray:
    region = np.zeros((height, width), bool)
    region[0, : width // 2] = region[:3, 0] = True
    region[height // 2 :, -2:] = True
    region[-1, 1] = region[-3, 0] = region[height // 2, 0] = True
    return region


def mixture(height: int, width: int) -> np.ndarray:
    """A disk, strokes beside and through it, single pixels."""
    region = np.zeros((height, width), bool)
    half = disk(height // 2, width // 2)
    region[: half.shape[0], : half.shape[1]] = half
    region[height // 2 + 3, 2:-2] = region[3:-3, width // 2 + 4] = True
    region[height // 4, : width // 2] = True
    region[height // 2 + 6 :: 3, width // 2 + 7 :: 3] = True
    region[height // 2 + 5 : -1, 3:5] = True
    return region


def squares(height: int, width: int) -> np.ndarray:
    """Of 1 x 1 to 11 x 11 pixels: eliminated in a window up to 7 x 7, the others relaxed."""
    region = np.zeros((height, width), bool)
    corner = 1
    for side in range(1, 12):
        region[corner : corner + side, corner : corner + side] = True
        corner += side
    return region


def islands_that_touch(height: int, width: int) -> np.ndarray:
    """Disks eleven pixels across on a line."""
    row, col = np.mgrid[:height, :width]
    return (np.hypot(row - height // 2, (col + 7) % 14 - 7) < 5.5) | (row == height // 2)


OWN = {
    f.__name__: f
    for f in (
        loops,
        net,
        wide_net,
        comb,
        spiral_of_1_pixel,
        at_edges_and_corners,
        mixture,
        squares,
        islands_that_touch,
    )
}
EVERY = {**{name: SHAPES[name] for name in THIN}, **OWN}


@pytest.fixture
def always(monkeypatch):
    """Every region is looked at, however well filled, and all parts are tried that are small."""
    monkeypatch.setattr(narrow, "WELL_FILLED", 2.0)


# --- the solution -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [LARGE, SMALL, (17, 64), (12, 9)], ids=str)
@pytest.mark.parametrize("shape", EVERY)
@pytest.mark.usefixtures("always")
def test_narrow_parts_are_exact(shape, size):
    region = EVERY[shape](*size)
    if not region.any() or region.all():
        region[0, 0] ^= True
    case = Case(region)
    problem = case.problem()
    result = solve_multigrid(problem)
    assert "directly" in result.method
    assert_untouched(result.solution, case.values, region)
    if "multigrid" not in result.method:
        assert case.error(result) <= result.error_estimate + 1e-12
        assert (result.iterations == 0) == (result.method == "directly")
        assert result.history == (result.error_estimate,)
    if result.method == "directly":
        assert case.error(result) <= EXACT
    assert case.error(result) <= DEFAULT_TOLERANCE
    assert result.converged


@pytest.mark.parametrize("shape", THIN)
def test_thin_shapes_need_no_cycles(shape):
    """They are found without anyone's help."""
    assert solve_multigrid(Case(SHAPES[shape](*LARGE)).problem()).method in (
        "directly",
        "directly and by sor",
    )


@pytest.mark.parametrize("shape", ["net", "wide_net", "islands_that_touch", "comb"])
@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-6, 1e-9])
@pytest.mark.usefixtures("always")
def test_long_parts_are_relaxed_to_any_tolerance(shape, tolerance):
    case = Case(EVERY[shape](150, 170))
    result = solve_multigrid(case.problem(), tolerance=tolerance)
    assert result.method == "directly and by sor"
    assert result.converged
    assert case.error(result) <= result.error_estimate <= tolerance


@pytest.mark.parametrize("shape", ["net", "wide_net", "islands_that_touch"])
@pytest.mark.usefixtures("always")
def test_over_relaxation_is_as_fast_as_can_be(shape):
    """omega is found: hardly more sweeps than the best one takes, which contracts by omega - 1 in the long run."""
    region = EVERY[shape](150, 170)
    region[[0, -1]] = region[:, [0, -1]] = False
    case = Case(region)
    rho = 1 - scipy.sparse.linalg.eigsh(_matrix(region), k=1, sigma=0, return_eigenvectors=False)[0] / 4
    best = 2 / (1 + np.sqrt(1 - rho**2))
    needed = np.log(1e-9 / np.abs(case.exact - case.values)[region].max()) / np.log(best - 1)
    assert solve_multigrid(case.problem(), tolerance=1e-9).iterations <= 1.3 * needed + 6


def _matrix(region: np.ndarray) -> scipy.sparse.csc_matrix:
    """A, for a region away from the image's edge."""
    number = np.cumsum(region).reshape(region.shape) - 1
    pairs = [
        (number[:, :-1], number[:, 1:], region[:, :-1] & region[:, 1:]),
        (number[:-1], number[1:], region[:-1] & region[1:]),
    ]
    row, col = (np.concatenate([pair[k][pair[2]] for pair in pairs]) for k in (0, 1))
    links = scipy.sparse.coo_matrix((np.ones(len(row)), (row, col)), (region.sum(), region.sum()))
    return (4 * scipy.sparse.identity(region.sum()) - links - links.T).tocsc()


@pytest.mark.parametrize("lanes", [4, 8])
@pytest.mark.parametrize("looks", [0, 1, 2])
def test_a_wave_makes_the_same_as_sweep_after_sweep(lanes, looks, monkeypatch):
    """Short chunks, so that half sweeps are under way in many places; against loops over neighbours."""
    monkeypatch.setattr(kernels, "CHUNK", 3)
    region = wide_net(17, 23) & (np.random.default_rng(2).random((17, 23)) < 0.8)
    region[[0, -1]] = region[:, [0, -1]] = False
    parts = narrow.Parts.of(np.flatnonzero(region), region.shape, Arena())
    n, near = len(parts.place), parts.near
    slot, members = np.zeros(n, np.int32), np.zeros(n, np.int32)
    red = kernels.put_into_slots(slot, members, parts.colour, np.arange(n), 0, n)
    assert np.array_equal(np.sort(members), np.arange(n))
    assert (parts.colour[members[:red]] == layout.RED).all()
    links, inverse = np.zeros(2 * (n + 2), np.int64), np.zeros(n + 2, np.float32)
    reach = np.zeros((2, n), np.int32)
    kernels.join_slots(links, inverse, reach, near, slot, members, red, n, lanes)
    x, r = np.zeros((2, n + 2, lanes), np.float32)
    r[slot] = np.random.default_rng(3).normal(size=(n, lanes)).astype(np.float32)
    seen, found = np.zeros(4 * lanes, np.int32), np.zeros(4 * lanes, np.float32)
    where = links, inverse, reach, np.zeros(12, np.int64), seen, found, red, n, lanes
    kernels.sweep_slots(
        x.reshape(-1), r.reshape(-1), *where, np.float32(1.4), np.float32(1.1), count := 5, looks
    )

    expected = np.zeros((n + 1, lanes), np.float32)  # the last one stands for all that is known
    for half in range(2 * count):
        for i in np.flatnonzero(parts.colour == half % 2):
            north, west, east, south = (expected[j if j >= 0 else n] for j in near[i])
            around = (north + south) + (west + east)
            d = np.float32(1.0 / (near[i] != layout.BEYOND).sum())
            omega = np.float32(1.4 if half < 2 * (count - 1) else 1.1)
            expected[i] += omega * (d * (around + r[slot[i]]) - expected[i])
    assert np.array_equal(x[slot], expected[:n])
    assert not x[[red, n + 1]].any()
    left = (_matrix(region) @ expected[:n] - r[slot]) * (parts.colour < looks)[:, np.newaxis]
    largest = seen.view(np.float32).reshape(4, lanes).max(0)
    np.testing.assert_allclose(4 * largest, np.abs(left).max(0), rtol=1e-5)


@pytest.mark.parametrize("channels", [1, 2, 4, 5, 8])
@pytest.mark.parametrize("shape", ["wide_net", "strokes_of_2_pixels", "squares"])
@pytest.mark.usefixtures("always")
def test_any_number_of_channels(shape, channels):
    region = EVERY[shape](60, 70)
    values = np.random.default_rng(channels).integers(0, 256, (60, 70, channels)).astype(np.float64)
    exact = oracles.solve(region, values, *oracles.guidance(oracles.zero, values, values))
    result = solve_multigrid(PoissonProblem(region, values))
    assert "multigrid" not in result.method or shape == "squares"
    assert np.abs(result.solution - exact).max() <= DEFAULT_TOLERANCE


@pytest.mark.parametrize(
    "shape", ["disk", "lasso", "noise", "checkerboard", "pins", "all_but_one_pixel", "everything"]
)
def test_wide_and_dense_ones_are_left_to_multigrid(shape):
    assert solve_multigrid(Case(SHAPES[shape](*LARGE)).problem()).method == "multigrid F"


@pytest.mark.usefixtures("always")
def test_a_mixture_is_split():
    region = mixture(*LARGE)
    case = Case(region)
    problem = case.problem()
    solution = narrow.split(problem, Arena(), DEFAULT_TOLERANCE)
    assert solution is not None
    taken = np.zeros(region.shape, bool)
    taken.reshape(-1)[solution.place] = True
    assert not (taken & ~region).any()
    assert np.array_equal(solution.rest(), region & ~taken)
    half = disk(*(side // 2 for side in region.shape))
    assert not taken[: half.shape[0], : half.shape[1]][
        half
    ].any()  # the disk, and the stroke that goes through it
    assert taken.sum() == (region & ~_connected(region, (region.shape[0] // 4, region.shape[1] // 4))).sum()
    error = np.abs(solution.values[:, :3] + case.values[taken] - case.exact[taken]).max()
    assert error <= solution.error <= DEFAULT_TOLERANCE
    result = solve_multigrid(problem)
    assert result.method == "directly and by sor and by multigrid F"
    assert case.error(result) <= DEFAULT_TOLERANCE
    assert result.history[-1] == result.error_estimate


def _connected(region: np.ndarray, pixel: tuple[int, int]) -> np.ndarray:
    """The part of the region that a pixel belongs to."""
    from scipy import ndimage

    labels, _ = ndimage.label(region)
    return labels == labels[pixel]


def test_parts_are_those_that_are_connected(monkeypatch):
    from scipy import ndimage

    monkeypatch.setattr(narrow, "LONG_CALL", 100)
    region = np.random.default_rng(3).random((60, 47)) < 0.45
    parts = narrow.Parts.of(np.flatnonzero(region), region.shape, Arena())
    labels, count = ndimage.label(region)
    assert len(parts.sizes) == count
    assert np.array_equal(parts.part + 1, labels[region])
    assert np.array_equal(parts.sizes, np.bincount(labels[region])[1:])
    assert np.array_equal(parts.order[parts.rank], np.arange(region.sum()))
    down = np.bincount(labels[1:][region[1:] & region[:-1]], minlength=count + 1)
    across = np.bincount(labels[:, 1:][region[:, 1:] & region[:, :-1]], minlength=count + 1)
    assert np.array_equal(parts.pairs, (down + across)[1:])


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (3, 5), (8, 8), (31, 101)], ids=str)
@pytest.mark.parametrize("unaligned", [0, 3])
def test_every_unknown_is_found_wherever_the_mask_begins(size, unaligned, monkeypatch):
    monkeypatch.setattr(narrow, "LONG_CALL", 5)
    area = size[0] * size[1]
    pixels = np.random.default_rng(9).random(unaligned + area) < 0.3
    pixels[-1] = True
    region = pixels[unaligned:].reshape(size)
    assert np.array_equal(narrow.places(region, int(region.sum()), Arena()), np.flatnonzero(region))


@pytest.mark.parametrize("size", [(1, 1), (7, 33), (8, 32), (31, 100)], ids=str)
def test_the_first_look_counts_unknowns_and_pixels_of_their_tiles(size):
    region = np.random.default_rng(5).random(size) < 0.1
    region[-1, -1] = True
    height, width = size
    tiles = [
        region[row : row + 2, col : col + scattered.TILE]
        for row in range(0, height, 2)
        for col in range(0, width, scattered.TILE)
    ]
    pixels = sum(tile.size for tile in tiles if tile.any())
    assert tuple(int(n) for n in scattered.survey(region, 0, height, 1)) == (region.sum(), pixels)
    pairs = np.concatenate([region[row : row + 2] for row in range(0, height, 6)])
    assert scattered.survey(region, 0, height, 3)[0] == pairs.sum()


def test_the_first_look_need_not_see_everything(monkeypatch):
    monkeypatch.setattr(narrow, "ENOUGH", 5)
    monkeypatch.setattr(narrow, "BAND", 1)
    assert solve_multigrid(Case(SHAPES["islands"](*LARGE)).problem()).method == "directly"
    assert solve_multigrid(Case(SHAPES["disk"](*LARGE)).problem()).method == "multigrid F"
    speck = np.zeros((40, 40), bool)
    speck[15:17, 20:23] = True  # between the rows that are looked at
    assert solve_multigrid(Case(speck).problem()).method == "directly"


@pytest.mark.parametrize(("name", "value"), [("LARGEST_PART", 40), ("MOST_LANES", 200), ("NARROW", 0.8)])
@pytest.mark.usefixtures("always")
def test_what_is_too_large_or_wide_is_left_to_multigrid(name, value, monkeypatch):
    case = Case(net(*LARGE))
    assert "multigrid" not in solve_multigrid(case.problem()).method
    monkeypatch.setattr(narrow, name, value)
    result = solve_multigrid(case.problem())
    assert "multigrid F" in result.method
    assert case.error(result) <= DEFAULT_TOLERANCE


@pytest.mark.usefixtures("always")
def test_what_takes_too_many_sweeps_is_left_to_multigrid_after_all():
    """A disk with long hair is narrow on average, but its middle is far from all that is known."""
    row, col = np.mgrid[:130, :130]
    inside = (np.minimum(row, col) > 1) & (np.maximum(row, col) < 128)
    hairy = ((np.hypot(row - 64, col - 64) < 40) | (row % 4 == 0) | (col == 2)) & inside
    assert narrow.Parts.of(np.flatnonzero(hairy), hairy.shape, Arena()).narrow.all()
    with_speck = hairy.copy()
    with_speck[-1, -1] = True
    for region, method in ((hairy, "multigrid F"), (with_speck, "directly and by multigrid F")):
        case = Case(region)
        result = solve_multigrid(case.problem())
        assert result.method == method
        assert case.error(result) <= DEFAULT_TOLERANCE


@settings(deadline=None, max_examples=60)
@given(
    region=arrays.arrays(np.bool_, st.tuples(st.integers(1, 14), st.integers(1, 14))),
    seed=st.integers(0, 1000),
)
def test_any_mask(region, seed):
    if not region.any() or region.all():
        return
    rng = np.random.default_rng(seed)
    values = rng.integers(0, 256, (*region.shape, 2)).astype(np.float64)
    field = oracles.guidance(oracles.imported, values, rng.integers(0, 256, values.shape).astype(np.float64))
    exact = oracles.solve(region, values, *field)
    problem = PoissonProblem(region, values, Guidance(*field))
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (("WELL_FILLED", 2.0), ("NARROW", 100.0)):
            patch.setattr(narrow, name, value)
        result = solve_multigrid(problem)
    error = np.abs(result.solution - exact).max()
    assert error <= (EXACT if result.method == "directly" else DEFAULT_TOLERANCE)
    if "multigrid" not in result.method:
        assert error <= result.error_estimate + 1e-12
    assert_untouched(result.solution, values, region)


# --- forms of the problem ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("level", [1.0, 257.0, 1 / 255])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("colour", [True, False], ids=["colour", "grey"])
@pytest.mark.parametrize("shape", ["strokes_of_2_pixels", "unknown_frame"])
def test_dtypes_channels_and_units(shape, colour, dtype, level):
    case = Case(SHAPES[shape](*SMALL), colour=colour)
    problem = case.problem(dtype=dtype, level=level)
    result = solve_multigrid(problem)
    assert result.solution.dtype == dtype
    assert result.solution.shape == case.values.shape
    assert case.error(result, level=level) <= DEFAULT_TOLERANCE


@pytest.mark.parametrize("shape", ["strokes_of_1_pixel", "at_edges_and_corners", "mixture"])
@pytest.mark.usefixtures("always")
def test_a_right_hand_side_and_the_membrane(shape):
    case = Case(EVERY[shape](*LARGE))
    problem = PoissonProblem(case.region, case.values, rhs=oracles.pair_sums(*case.field))
    assert case.error(solve_multigrid(problem)) <= DEFAULT_TOLERANCE
    zero = oracles.guidance(oracles.zero, case.values, case.values)
    case.exact = oracles.solve(case.region, case.values, *zero)
    assert case.error(solve_multigrid(PoissonProblem(case.region, case.values))) <= DEFAULT_TOLERANCE


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize(("tool", "rule"), [(clone, oracles.imported), (mix, oracles.mixed)])
@pytest.mark.parametrize("shape", [*THIN, "mixture", "net", "at_edges_and_corners"])
def test_pictures_are_rounded_right(shape, tool, rule, dtype):
    scale = {np.uint8: 1, np.uint16: 257}[dtype]
    destination, source = (
        crop(name, 90, 101).astype(dtype) * dtype(scale) for name in ("coffee.png", "chelsea.png")
    )
    region = EVERY[shape](90, 101)
    image = tool(destination, source, region)
    field = oracles.guidance(rule, destination, source)
    exact = oracles.solve(region, destination.astype(np.float64), *field)
    if dtype == np.uint8:
        assert_rounded_right(image, destination, exact, region)
    else:  # of 65,535 in float32 a fraction of a half may be lost
        assert_untouched(image, destination, region)
        assert np.abs(image - np.clip(exact, 0, 65535))[region].max() <= 0.51


@pytest.mark.parametrize("shape", [*THIN, "net", "at_edges_and_corners"])
def test_known_pixels_alone_make_the_same_equations(shape, monkeypatch):
    """A picture of integers tells what is known beside the region; whatever else it is, it tells band by band."""
    destination, source = (crop(name, 90, 101) for name in ("coffee.png", "chelsea.png"))
    region = EVERY[shape](90, 101)
    image = clone(destination, source, region)
    monkeypatch.setattr(Window, "rim", lambda window: None)
    assert np.array_equal(clone(destination, source, region), image)


@pytest.mark.parametrize("space", ["rgb", "linear", "lab"])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
@pytest.mark.parametrize("name", ["clone", "mix", "fill"])
def test_scattered_pixels_are_painted_like_rows(name, dtype, space, monkeypatch):
    tool = getattr(cloning, name)
    scale = dtype(1 if dtype == np.uint8 else 1 / 255)
    destination, source = (crop(file, 90, 101) * scale for file in ("coffee.png", "chelsea.png"))
    region = EVERY["at_edges_and_corners"](90, 101)
    pictures = (destination,) if name == "fill" else (destination, source)
    edit = tool(*pictures, region, space=space)
    assert "multigrid" not in edit.report.method
    monkeypatch.setattr(window, "TOGETHER", 7)
    assert np.array_equal(tool(*pictures, region, space=space).image, edit.image)

    def in_rows(canvas, place, correction):
        direct = narrow.NarrowSolution(None, place, correction, 0.0, 0)
        return canvas.paint(direct.add_to, lambda operation: [operation(0, canvas.shape[0])])

    monkeypatch.setattr(Window, "paint_at", in_rows)
    again = tool(*pictures, region, space=space)
    assert np.array_equal(again.image, edit.image)
    assert again.report.clipped == edit.report.clipped
    assert again.report.overshoot == edit.report.overshoot


@pytest.mark.usefixtures("always")
def test_where_no_pixel_is_known_nothing_is_narrow():
    for size in ((1, 1), (1, 40), (40, 1)):
        result = solve_multigrid(Case(np.ones(size, bool)).problem())
        assert result.floating
        assert result.method == "multigrid F"


@pytest.mark.parametrize("shape", ["strokes_of_2_pixels", "mixture"])
@pytest.mark.usefixtures("always")
def test_the_same_bits_for_any_threads_and_length_of_a_call(shape, monkeypatch):
    problem = Case(EVERY[shape](*LARGE)).problem()
    one = solve_multigrid(problem, threads=1)
    monkeypatch.setattr(narrow, "CALL", 100)
    monkeypatch.setattr(narrow, "BAND", 1)
    for threads in (1, 2, 3):
        again = solve_multigrid(problem, threads=threads)
        assert again.solution.tobytes() == one.solution.tobytes()
        assert again.error_estimate == one.error_estimate


def test_sor_stays_sor():
    result = solve_sor(Case(SHAPES["strokes_of_1_pixel"](*SMALL)).problem())
    assert result.method.startswith("sor")
    assert result.iterations > 0


# --- what is said of it -----------------------------------------------------------------------------------------------


def test_progress_is_told_once():
    told = []
    result = solve_multigrid(
        Case(SHAPES["islands"](*SMALL)).problem(), progress=lambda *step: told.append(step)
    )
    assert told == [(0, result.error_estimate)]


@pytest.mark.parametrize("shape", [*THIN, "mixture", "wide_net"])
@pytest.mark.usefixtures("always")
def test_the_certificate_holds(shape):
    case = Case(EVERY[shape](*LARGE))
    result = solve_multigrid(case.problem(), certify=True)
    assert case.error(result) <= result.error_bound + EXACT
    assert result.error_bound <= DEFAULT_TOLERANCE


def test_a_tolerance_beyond_float64_is_not_claimed():
    result = solve_multigrid(Case(SHAPES["islands"](*SMALL)).problem(), tolerance=1e-18)
    assert not result.converged
    assert result.error_estimate > 1e-18


@pytest.mark.parametrize("threads", [0, -1])
def test_no_thread_is_refused(threads):
    with pytest.raises(ValueError, match="threads"):
        solve_multigrid(Case(SHAPES["islands"](*SMALL)).problem(), threads=threads)


SOLVE = """
import hashlib, sys
import numpy as np
from poisson_cli import clone
random = np.random.default_rng(3)
source, destination = random.integers(0, 256, (2, 24, 60, 3), np.uint8)
row, col = np.mgrid[:24, :60]
masks = (row % 8 < 2) | (col % 20 < 1), (row == col) | (row == col + 1), (row % 6 == 0) & (col % 7 == 1)
images = [clone(destination, source, mask) for mask in masks]
images.append(clone(destination / 255, source / 255, masks[0]))
print(*(hashlib.sha256(image.tobytes()).hexdigest() for image in images))
"""


def test_compiled_kernels_and_plain_python_give_the_same_bits():
    answers = set()
    for how in ("native", "numba", "python"):
        ran = subprocess.run(
            [sys.executable, "-c", SOLVE],
            capture_output=True,
            text=True,
            env={**os.environ, "POISSON_KERNELS": how},
            cwd=Path(__file__).parent.parent,
            check=True,
        )
        answers.add(ran.stdout)
    assert len(answers) == 1
