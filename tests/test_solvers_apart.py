"""Parts of a region that lie far apart, each in a window of its own."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from poisson_cli.editing import clone
from solvers import Guidance, PoissonProblem, apart, solve_multigrid
from tests.photographs import crop
from tests.regions import SHAPES


@pytest.fixture
def near_is_far(monkeypatch):
    """A few pixels are a long way, and any saving is worth it."""
    monkeypatch.setattr(apart, "SMALL", 0)
    monkeypatch.setattr(apart, "TILE", 4)
    monkeypatch.setattr(apart, "MUCH_SMALLER", 0.95)


def disks(height: int, width: int, *centres: tuple[int, int], radius: float = 9) -> np.ndarray:
    row, col = np.mgrid[:height, :width]
    return np.any([np.hypot(row - r, col - c) < radius for r, c in centres], axis=0)


CORNERS = (3, 5), (70, 88), (72, 12)


@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 2**32 - 1), st.floats(0.001, 0.2))
def test_every_unknown_is_in_one_box_with_all_its_neighbours(height, width, seed, share):
    region = np.random.default_rng(seed).random((height, width)) < share
    region[0, 0] = True
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(apart, "SMALL", 0)
        patch.setattr(apart, "TILE", 3)
        patch.setattr(apart, "MUCH_SMALLER", 1.0)
        boxes = apart.boxes(region)
    times, known = np.zeros(region.shape, int), ~region
    for box in boxes:
        assert box.top % 2 == 0
        own = box.of(region)
        assert own.any()
        box.of(times)[own] += 1
        for side, at_edge in (
            (own[0], box.top == 0),
            (own[-1], box.bottom == height),
            (own[:, 0], box.left == 0),
            (own[:, -1], box.right == width),
        ):
            assert at_edge or not side.any()
    assert (times[region] == 1).all()
    assert (times[known] == 0).all()


def test_a_small_image_is_one_box():
    region = disks(100, 100, (5, 5), (94, 94))
    assert apart.boxes(region) == [apart.Box(0, 100, 0, 100)]


def test_far_corners_of_a_large_image_are_two_boxes():
    region = disks(2000, 1500, (9, 9), (1990, 1490))
    boxes = apart.boxes(region)
    assert len(boxes) == 2
    assert sum(box.pixels for box in boxes) < 2 * 22 * 22
    region[:, 700] = True
    region[1000] = True
    assert len(apart.boxes(region)) == 1


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("screening", [0.0, 0.02])
@pytest.mark.parametrize("with_", ["guidance", "rhs", "nothing"])
def test_the_solution_is_the_exact_one(with_, screening, dtype, near_is_far):
    region = disks(81, 97, *CORNERS)
    assert len(apart.boxes(region)) == 3
    rng = np.random.default_rng(3)
    values = rng.integers(0, 256, (*region.shape, 2)).astype(dtype)
    v = Guidance.of(rng.normal(0, 30, values.shape).astype(dtype))
    given_ = {"guidance": {"guidance": v}, "rhs": {"rhs": rng.normal(0, 9, values.shape).astype(dtype)}}
    problem = PoissonProblem(region, values, screening=screening, **given_.get(with_, {}))
    result = solve_multigrid(problem, certify=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(apart, "SMALL", 1 << 20)
        whole = solve_multigrid(problem, certify=True)
    assert whole.iterations and result.iterations
    assert np.abs(result.solution - whole.solution).max() <= 4e-4
    assert np.array_equal(result.solution[~region], values[~region])
    assert result.converged
    assert result.unknowns == region.sum()
    if screening == 0:
        assert result.error_bound <= 4e-4
    for threads in (2, 3):
        shared = solve_multigrid(problem, threads=threads)
        assert shared.solution.tobytes() == result.solution.tobytes()


@pytest.mark.parametrize("tool_dtype", [np.uint8, np.uint16, np.float64])
def test_pictures(tool_dtype, near_is_far, monkeypatch):
    region = disks(81, 97, *CORNERS)
    scale = {np.uint8: 1, np.uint16: 257, np.float64: 1 / 255}[tool_dtype]
    f, g = (
        (crop(name, 81, 97).astype(float) * scale).astype(tool_dtype)
        for name in ("coffee.png", "chelsea.png")
    )
    apart_ = clone(f, g, region)
    monkeypatch.setattr(apart, "SMALL", 1 << 20)
    whole = clone(f, g, region)
    difference = np.abs(apart_.image.astype(float) - whole.image.astype(float)).max() / scale
    assert difference <= (1e-3 if tool_dtype is np.float64 else 1)
    assert np.array_equal(apart_.image[~region], f[~region])
    assert apart_.report.unknowns == whole.report.unknowns


def test_some_parts_directly_and_some_by_cycles(near_is_far):
    region = disks(81, 97, *CORNERS) | SHAPES["islands"](81, 97)
    region[40:44] = False
    values = np.random.default_rng(5).uniform(0, 255, region.shape)
    problem = PoissonProblem(region, values)
    result = solve_multigrid(problem, certify=True)
    assert result.converged
    assert result.error_bound <= 4e-4
