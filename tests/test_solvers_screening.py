"""Screened problems, (A + s) f = b + s h, against a sparse direct solution written here from the definition."""

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from solvers import Guidance, PoissonProblem, solve_multigrid, solve_sor
from tests.regions import SHAPES


def direct(region, values, guidance, screening):
    """One equation per unknown, pixel by pixel."""
    height, width = region.shape
    number = np.full(region.shape, -1)
    number[region] = np.arange(region.sum())
    flat = values.reshape(height, width, -1).astype(np.float64)
    across = guidance.across.reshape(height, width - 1, -1)
    down = guidance.down.reshape(height - 1, width, -1)
    rows, cols, entries = [], [], []
    b = np.zeros((region.sum(), flat.shape[2]))
    for p, (y, x) in enumerate(np.argwhere(region)):
        diagonal = screening
        b[p] += screening * flat[y, x]
        for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0)):
            r, c = y + dy, x + dx
            if not (0 <= r < height and 0 <= c < width):
                continue
            diagonal += 1
            v = across[y, min(x, c)] if dy == 0 else down[min(y, r), x]
            b[p] += v if dy + dx > 0 else -v
            if region[r, c]:
                rows.append(p), cols.append(number[r, c]), entries.append(-1.0)
            else:
                b[p] += flat[r, c]
        rows.append(p), cols.append(p), entries.append(diagonal)
    matrix = scipy.sparse.csc_matrix((entries, (rows, cols)))
    solution = flat.copy()
    solution[region] = scipy.sparse.linalg.spsolve(matrix, b).reshape(b.shape)
    return solution.reshape(values.shape)


def taken(screening):
    """What float32 holds beside the four neighbours."""
    return float(np.float32(4 + screening)) - 4


def problem_on(region, screening, channels=2, seed=0):
    rng = np.random.default_rng(seed)
    values = rng.integers(0, 256, (*region.shape, channels)).astype(np.float32)
    guidance = Guidance.of(rng.integers(0, 256, values.shape).astype(np.float32))
    return PoissonProblem(region, values, guidance, screening=screening), values, guidance


@pytest.mark.parametrize("screening", [1e-4, 0.01, 1.0, 300.0])
@pytest.mark.parametrize("name", sorted(SHAPES))
def test_multigrid_solves_screened_problems_on_every_shape(name, screening):
    region = SHAPES[name](37, 45)
    problem, values, guidance = problem_on(region, screening)
    result = solve_multigrid(problem, tolerance=1e-3)
    assert result.converged and not result.floating
    assert np.abs(result.solution - direct(region, values, guidance, taken(screening))).max() <= 1e-3
    assert np.array_equal(result.solution[~region], values[~region])


@pytest.mark.parametrize("screening", [0.01, 1.0])
def test_sor_solves_them_too(screening):
    region = SHAPES["disk"](37, 45)
    problem, values, guidance = problem_on(region, screening)
    result = solve_sor(problem, tolerance=1e-3)
    assert np.abs(result.solution - direct(region, values, guidance, taken(screening))).max() <= 1e-3


@pytest.mark.parametrize("screening", [1e-3, 0.1, 10.0])
def test_the_cycle_contracts_as_it_does_without(screening):
    problem, _, _ = problem_on(np.pad(np.ones((90, 110), bool), 1), screening)
    assert solve_multigrid(problem).iterations <= 7


def test_screening_makes_a_problem_without_known_pixels_regular():
    region = np.ones((13, 17), bool)
    problem, values, guidance = problem_on(region, 0.05)
    result = solve_multigrid(problem, tolerance=1e-4)
    assert not result.floating
    assert np.abs(result.solution - direct(region, values, guidance, taken(0.05))).max() <= 1e-4


@pytest.mark.parametrize("shape", ["disk", "all"])
def test_a_certificate_holds_for_screened_problems(shape):
    region = np.ones((20, 30), bool) if shape == "all" else SHAPES["disk"](37, 45)
    problem, values, guidance = problem_on(region, 0.02)
    result = solve_multigrid(problem, certify=True)
    true_error = np.abs(result.solution - direct(region, values, guidance, taken(0.02))).max()
    assert result.error_bound is not None
    assert true_error <= result.error_bound <= 1e-3


@settings(max_examples=40, deadline=None)
@given(
    st.integers(1, 12), st.integers(1, 12), st.floats(1e-5, 1e4), st.integers(0, 2**32 - 1), st.floats(0.1, 1)
)
def test_random_regions(height, width, screening, seed, density):
    rng = np.random.default_rng(seed)
    region = rng.random((height + 2, width + 2)) < density
    region[0, 0] = True
    problem, values, guidance = problem_on(region, screening, seed=seed)
    solution = solve_multigrid(problem, tolerance=1e-3).solution
    assert np.abs(solution - direct(region, values, guidance, taken(screening))).max() <= 1e-3


@pytest.mark.parametrize("screening", [-1e-9, float("nan"), float("inf"), 1e7])
def test_screening_that_makes_no_sense_is_refused(screening):
    with pytest.raises(ValueError, match="screening"):
        PoissonProblem(np.ones((3, 3), bool), np.zeros((3, 3), np.float32), screening=screening)
