"""How fast multigrid contracts: a slower one fails here even when its answers are still right.

Each problem is made from its answer, and the error after every cycle is measured against that answer.  The
factor is the geometric mean over the last four cycles that end above the rounding floor: the first ones flatter,
because a random error is mostly rough, and rough errors vanish at once.
"""

import numpy as np
import pytest

from solvers import Guidance, PoissonProblem, solve_multigrid, solve_sor
from tests.regions import LARGE, NEAR_SINGULAR, SHAPES

CYCLES = 6
AVERAGED = 4
FLOOR = 1e-4  # levels; below, the rounding of float32 shows between two refinements
F_BUDGET, F_BUDGET_NEAR_SINGULAR, W_BUDGET = 0.15, 0.25, 0.15


def problem_with_known_answer(region: np.ndarray) -> tuple[PoissonProblem, np.ndarray]:
    """Noise plus a slope, so that the error has every wavelength; the first guess is zero."""
    rng = np.random.default_rng(17)
    row, col = np.mgrid[: region.shape[0], : region.shape[1]] / 161
    answer = rng.normal(0, 40, region.shape) + 90 * row - 50 * col
    if region.all():
        answer -= answer.mean()
    return PoissonProblem(region, np.where(region, 0.0, answer), Guidance.of(answer)), answer


def errors(region: np.ndarray, cycle: str) -> list[float]:
    """The largest error, levels, of the first guess and after each cycle, as long as it lies above the floor."""
    problem, answer = problem_with_known_answer(region)
    measured = [float(np.abs(answer[region]).max())]
    for cycles in range(1, CYCLES + 1):
        result = solve_multigrid(problem, cycle=cycle, tolerance=1e-12, max_iterations=cycles, direct=False)
        assert result.method == f"multigrid {cycle}"  # no stronger cycle came to its help
        error = float(np.abs(result.solution - answer).max())
        if error < FLOOR:
            break
        measured.append(error)
    return measured


def convergence_factor(region: np.ndarray, cycle: str) -> float:
    """Factor by which one cycle makes the largest error smaller; 0 where one cycle is enough."""
    last = errors(region, cycle)[-AVERAGED - 1 :]
    return (last[-1] / last[0]) ** (1 / (len(last) - 1)) if len(last) > 1 else 0.0


@pytest.mark.parametrize("shape", SHAPES)
def test_f_cycles_contract_within_their_budget(shape):
    budget = F_BUDGET_NEAR_SINGULAR if shape in NEAR_SINGULAR else F_BUDGET
    assert convergence_factor(SHAPES[shape](*LARGE), "F") <= budget


@pytest.mark.parametrize("shape", SHAPES)
def test_w_cycles_contract_within_their_budget(shape):
    assert convergence_factor(SHAPES[shape](*LARGE), "W") <= W_BUDGET


@pytest.mark.parametrize("size", [(160, 160), (128, 128), (97, 250), (40, 300), (300, 9)], ids=str)
@pytest.mark.parametrize("shape", ["disk", "pins", "cracks", "spiral", "corner_touching", "left_half"])
def test_the_size_of_the_picture_does_not_slow_f_cycles_down(shape, size):
    """Odd and even, square and long: levels whose sides halve unevenly."""
    assert convergence_factor(SHAPES[shape](*size), "F") <= F_BUDGET


@pytest.mark.parametrize("size", [(160, 160), (64, 250), (300, 9)], ids=str)
@pytest.mark.parametrize("shape", NEAR_SINGULAR)
def test_nor_where_hardly_a_pixel_is_known(shape, size):
    assert convergence_factor(SHAPES[shape](*size), "F") <= F_BUDGET_NEAR_SINGULAR


@pytest.mark.parametrize("shape", SHAPES)
def test_few_f_cycles_reach_the_default_tolerance(shape):
    """From a first guess that is off by a hundred levels; what a user waits for."""
    problem, _ = problem_with_known_answer(SHAPES[shape](*LARGE))
    result = solve_multigrid(problem, direct=False)
    assert result.converged
    assert result.iterations <= (12 if shape in NEAR_SINGULAR else 9)


def test_where_cycles_are_slow_stronger_ones_take_over_and_none_without_need():
    """A stronger cycle's first change is what the weaker ones left: nothing can be said of it yet."""
    problem, answer = problem_with_known_answer(SHAPES["pins"](257, 257))
    result = solve_multigrid(problem, cycle="V", tolerance=1e-4)
    assert result.method == "multigrid V, then F"
    assert np.abs(result.solution - answer).max() <= 1e-4


@pytest.mark.parametrize("side", [40, 80, 160, 320])
def test_the_number_of_cycles_does_not_grow_with_the_region(side):
    problem, _ = problem_with_known_answer(SHAPES["disk"](side, side))
    assert solve_multigrid(problem).iterations <= 8


@pytest.mark.parametrize("shape", ["disk", "all_but_one_pixel"])
def test_a_large_region_gets_past_the_floor_of_float32(shape):
    """At 640,000 pixels float32 alone stops near 5e-3 level: the refinement in float64 has to do its part."""
    region = SHAPES[shape](800, 800)
    problem, answer = problem_with_known_answer(region)
    result = solve_multigrid(problem, tolerance=1e-4)
    assert result.converged
    assert np.abs(result.solution - answer).max() <= 1e-4


@pytest.mark.parametrize("side", [40, 80, 160])
def test_sweeps_of_sor_grow_with_the_side_not_with_the_area(side):
    """What the right omega gives; with omega = 1 the number of sweeps would grow with the area."""
    problem, _ = problem_with_known_answer(SHAPES["disk"](side, side))
    result = solve_sor(problem)
    assert result.converged
    assert result.iterations <= 8 * side + 60
