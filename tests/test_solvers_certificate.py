"""The proven bound against the true error: never below it, whoever proposes, and close to it in earnest."""

import numpy as np
import pytest

from solvers import Guidance, PoissonProblem, solve_multigrid, solve_sor
from solvers.certificate import cover, proven_error
from tests import oracles
from tests.regions import LARGE, NEAR_SINGULAR, SHAPES, SMALL
from tests.test_solvers_accuracy import Case
from tests.test_solvers_convergence import problem_with_known_answer

ORACLE = 1e-9  # levels: how exact the direct solver is, where hardly a pixel is known


@pytest.mark.parametrize("cycles", [1, 2, 4, 100])
@pytest.mark.parametrize("shape", SHAPES)
def test_no_pixel_is_further_off_than_the_bound(shape, cycles):
    case = Case(SHAPES[shape](*LARGE))
    result = solve_multigrid(case.problem(), certify=True, max_iterations=cycles)
    error = case.error(result)
    assert error <= result.error_bound + ORACLE
    if error > 1e-6:
        assert result.error_bound <= 2 * error


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("shape", SHAPES)
def test_odd_and_even_sizes_and_both_solvers(solve, shape):
    for size in (SMALL, (17, 32), (2, 9)):
        region = SHAPES[shape](*size)
        if region.any():
            case = Case(region)
            result = solve(case.problem(), certify=True, tolerance=0.1)
            assert case.error(result) <= result.error_bound + ORACLE


@pytest.mark.parametrize("level", [257.0, 1 / 255], ids=["16 bit", "0..1"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", ["disk", "everything"])
def test_the_bound_is_in_levels_and_covers_the_rounding_to_the_dtype(shape, dtype, level):
    case = Case(SHAPES[shape](64, 71))
    problem = case.problem(dtype=dtype, level=level)
    # The equations are those of the rounded numbers: the oracle must see the same ones.
    field = problem.guidance
    case.exact = oracles.solve(
        case.region,
        problem.values.astype(np.float64),
        field.across.astype(np.float64),
        field.down.astype(np.float64),
    )
    result = solve_multigrid(problem, tolerance=1e-4, certify=True)
    error = np.abs(result.solution - case.exact).max() / level
    assert error <= result.error_bound + ORACLE
    assert result.error_bound <= 2 * error


@pytest.mark.parametrize("shape", ["lasso", "edge_touching", "everything"])
def test_a_right_hand_side_in_place_of_the_guidance(shape):
    case = Case(SHAPES[shape](64, 71))
    problem = PoissonProblem(case.region, case.values, rhs=oracles.pair_sums(*case.field))
    result = solve_multigrid(problem, certify=True, tolerance=0.01)
    assert case.error(result) <= result.error_bound + ORACLE <= 2 * case.error(result)


def lies() -> dict:
    rng = np.random.default_rng(4)
    return {
        "nothing": lambda problem, cycles: np.zeros(problem.region.shape),
        "noise": lambda problem, cycles: rng.normal(size=problem.region.shape),
        "the wrong sign": lambda problem, cycles: -solve_multigrid(problem).solution,
        "half of it": lambda problem, cycles: 0.5 * solve_multigrid(problem).solution,
        "NaN": lambda problem, cycles: np.full(problem.region.shape, np.nan),
        "ones": lambda problem, cycles: np.ones(problem.region.shape),
    }


@pytest.mark.parametrize("lie", lies())
@pytest.mark.parametrize("shape", ["disk", "noise", "corner_touching", "all_but_one_pixel", "everything"])
def test_a_solver_that_lies_proves_nothing_false(shape, lie):
    case = Case(SHAPES[shape](*SMALL))
    problem = case.problem()
    solution = solve_multigrid(problem, tolerance=0.1).solution
    bound = proven_error(problem, solution, solution, lies()[lie])
    assert bound >= np.abs(solution - case.exact).max() - ORACLE


@pytest.mark.parametrize("shape", [shape for shape in SHAPES if shape != "everything"])
def test_what_covers_the_residual_covers_it_in_every_pixel(shape):
    region = SHAPES[shape](*SMALL)
    rest = np.where(region, np.random.default_rng(6).exponential(size=region.shape) ** 3, 0.0)
    z = cover(region, rest, lambda problem, cycles: solve_multigrid(problem, max_iterations=cycles).solution)
    zero = oracles.guidance(oracles.zero, rest, rest)
    matrix, _ = oracles.equations(region, np.zeros(region.shape), *zero)
    assert (z[~region] == 0).all()
    assert (matrix @ z[region] >= rest[region] * (1 - 1e-12)).all()


def test_nobody_asked_nobody_proves():
    assert solve_multigrid(Case(SHAPES["disk"](*SMALL)).problem()).error_bound is None


def test_a_certificate_changes_no_bit_of_the_solution():
    problem = Case(SHAPES["lasso"](*LARGE)).problem(dtype=np.float32)
    plain, certified = solve_multigrid(problem), solve_multigrid(problem, certify=True)
    assert plain.solution.tobytes() == certified.solution.tobytes()
    assert plain.error_estimate == certified.error_estimate


@pytest.mark.parametrize("shape", ["disk", *NEAR_SINGULAR])
def test_large_regions_keep_the_tolerance_and_prove_it(shape):
    """Where hardly a pixel is known, smooth errors are slow and rounding errors of float32 pile up."""
    region = SHAPES[shape](900, 900)
    problem, answer = problem_with_known_answer(region)
    result = solve_multigrid(problem, certify=True)
    error = np.abs(result.solution - answer).max()
    assert (
        error <= 1.1 * result.error_bound
    )  # the answer itself is exact only to the rounding of its guidance
    assert result.error_bound <= result.tolerance
    assert 0.6 <= result.error_estimate / error <= 5 or error < 1e-4


def test_guidance_of_a_single_row():
    values = np.array([[0.0, 5.0, 1.0, 9.0]])
    problem = PoissonProblem(np.array([[False, True, True, False]]), values, Guidance.zero(values.shape))
    result = solve_multigrid(problem, certify=True)
    assert np.abs(result.solution - [[0, 3, 6, 9]]).max() <= result.error_bound < 1e-6
