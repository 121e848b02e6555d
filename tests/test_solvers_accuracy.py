"""Both solvers against a sparse direct solve of eq. (7), on every shape, in every cycle."""

import numpy as np
import pytest

from solvers import DEFAULT_TOLERANCE, Guidance, PoissonProblem, SolveResult, solve_multigrid, solve_sor
from solvers.correction import Correction
from solvers.memory import Arena
from solvers.team import Team
from tests import oracles
from tests.agreement import assert_untouched, largest_error
from tests.photographs import crop
from tests.regions import LARGE, SHAPES, SMALL, THIN, disk, everything, lasso

TIGHT = 1e-6  # levels
ROUNDING = 1e-5  # levels: what float32 makes of values near 255


class Case:
    """A problem made of photographs, with guidance that is no gradient of any picture, and its solution."""

    def __init__(self, region: np.ndarray, *, colour: bool = True) -> None:
        height, width = region.shape
        picture = crop("coffee.png", height, width, top=150) if height <= 200 and width <= 300 else None
        if picture is None:
            rng = np.random.default_rng(2)
            picture = rng.integers(0, 256, (height, width, 3), dtype=np.uint8)
        other = np.roll(picture[::-1, ::-1], (3, 5), axis=(0, 1))
        if not colour:
            picture, other = picture[..., 1], other[..., 1]
        self.region = region
        self.values = picture.astype(np.float64)
        self.field = oracles.guidance(oracles.mixed, picture, other)
        self.exact = oracles.solve(region, self.values, *self.field)

    def problem(self, *, dtype: type = np.float64, level: float = 1.0) -> PoissonProblem:
        """In units of which `level` make one grey level."""
        values, across, down = ((part * level).astype(dtype) for part in (self.values, *self.field))
        return PoissonProblem(self.region, values, Guidance(across, down), level=level)

    def error(self, result: SolveResult, *, level: float = 1.0) -> float:
        """Largest error in any pixel, levels."""
        return largest_error(result.solution, self.exact * level, self.region, level)


def assert_solved(case: Case, problem: PoissonProblem, result: SolveResult, tolerance: float) -> None:
    assert result.converged
    assert result.tolerance == tolerance
    assert result.error_estimate <= tolerance
    assert case.error(result, level=problem.level) <= tolerance
    assert_untouched(result.solution, problem.values, case.region)
    assert result.unknowns == case.region.sum()
    assert result.floating == case.region.all()


# --- every shape ------------------------------------------------------------------------------------


@pytest.mark.parametrize("cycle", ["F", "W"])
@pytest.mark.parametrize("shape", SHAPES)
def test_multigrid_is_within_the_tolerance(shape, cycle):
    case = Case(SHAPES[shape](*LARGE))
    problem = case.problem()
    result = solve_multigrid(problem, cycle=cycle)
    assert_solved(case, problem, result, DEFAULT_TOLERANCE)
    assert cycle in result.method or "multigrid" not in result.method


@pytest.mark.parametrize("shape", SHAPES)
def test_v_cycles_give_the_picture_or_say_that_they_did_not(shape):
    case = Case(SHAPES[shape](*LARGE))
    result = solve_multigrid(case.problem(), cycle="V", direct=False)
    assert result.converged == (result.error_estimate <= DEFAULT_TOLERANCE)
    assert not result.converged or case.error(result) <= DEFAULT_TOLERANCE


@pytest.mark.parametrize("shape", SHAPES)
def test_sor_is_within_the_tolerance(shape):
    case = Case(SHAPES[shape](*LARGE))
    problem = case.problem()
    assert_solved(case, problem, solve_sor(problem), DEFAULT_TOLERANCE)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("shape", SHAPES)
def test_small_pictures_of_odd_and_even_size(solve, shape):
    for height, width in (SMALL, (32, 32), (17, 33), (40, 21)):
        case = Case(SHAPES[shape](height, width))
        problem = case.problem()
        assert_solved(case, problem, solve(problem), DEFAULT_TOLERANCE)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("size", THIN, ids=str)
def test_thin_pictures(solve, size):
    for make in SHAPES.values():
        region = make(*size)
        if region.any():
            case = Case(region)
            problem = case.problem()
            assert_solved(case, problem, solve(problem), DEFAULT_TOLERANCE)


# --- tolerance and estimate -------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1.0, 0.1, 1e-2, 1e-3, 1e-4, TIGHT])
@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("shape", ["disk", "pins", "noise", "all_but_one_pixel", "everything"])
def test_the_tolerance_asked_for_is_kept(shape, solve, tolerance):
    case = Case(SHAPES[shape](64, 71))
    problem = case.problem()
    assert_solved(case, problem, solve(problem, tolerance=tolerance), tolerance)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_estimate_is_of_the_size_of_the_error(shape):
    """Neither an empty promise nor a scare, down to the rounding of float32."""
    case = Case(SHAPES[shape](*LARGE))
    result = solve_multigrid(case.problem(), tolerance=0.01, direct=False)
    error = case.error(result)
    assert error <= 1.25 * result.error_estimate + ROUNDING
    assert result.error_estimate <= 20 * error + 100 * ROUNDING


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
def test_the_history_ends_with_the_estimate(solve):
    """One entry for every cycle; sweeps are too short a step to judge, so SOR looks after several."""
    result = solve(Case(disk(*LARGE)).problem())
    assert 1 < len(result.history) <= result.iterations
    assert len(result.history) == result.iterations or solve is solve_sor
    assert result.history[-1] == result.error_estimate
    assert result.history[-1] < result.history[0]


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("limit", [1, 2, 5])
def test_too_few_iterations_are_reported_not_hidden(solve, limit):
    case = Case(disk(*LARGE))
    result = solve(case.problem(), tolerance=1e-9, max_iterations=limit)
    assert not result.converged
    assert result.iterations == limit
    assert result.error_estimate > 1e-9
    assert case.error(result) > 1e-9


def test_a_larger_omega_than_two_is_refused():
    with pytest.raises(ValueError, match="omega"):
        solve_sor(Case(disk(*SMALL)).problem(), omega=2.5)


@pytest.mark.parametrize("omega", [1.0, 1.5, 1.9])
def test_sor_converges_for_every_omega_it_may_be_given(omega):
    case = Case(lasso(*SMALL))
    problem = case.problem()
    assert_solved(case, problem, solve_sor(problem, omega=omega), DEFAULT_TOLERANCE)


@pytest.mark.parametrize("omega", [1.0, 1.5, 1.9])
@pytest.mark.parametrize("tolerance", [1.0, 1e-3])
def test_a_badly_chosen_omega_slows_sor_down_but_fools_it_not(omega, tolerance):
    """A small step says little about the error where convergence is slow: the estimate has to know, within a half."""
    case = Case(SHAPES["known_frame"](64, 64))
    result = solve_sor(case.problem(), omega=omega, tolerance=tolerance)
    assert case.error(result) <= 1.5 * tolerance or not result.converged


# --- forms of the same problem ----------------------------------------------------------------------


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("shape", ["lasso", "edge_touching", "everything"])
def test_a_right_hand_side_may_stand_for_the_guidance(solve, shape):
    case = Case(SHAPES[shape](*SMALL))
    problem = PoissonProblem(case.region, case.values, rhs=oracles.pair_sums(*case.field))
    assert_solved(case, problem, solve(problem), DEFAULT_TOLERANCE)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("shape", ["lasso", "edge_touching", "pins", "everything"])
def test_no_guidance_is_the_membrane(solve, shape):
    case = Case(SHAPES[shape](*SMALL))
    zero = oracles.guidance(oracles.zero, case.values, case.values)
    case.exact = oracles.solve(case.region, case.values, *zero)
    for guidance in (None, Guidance.zero(case.values.shape)):
        problem = PoissonProblem(case.region, case.values, guidance)
        assert_solved(case, problem, solve(problem), DEFAULT_TOLERANCE)


def test_the_guidance_of_an_image_is_its_gradient_on_pairs():
    image = crop("astronaut.png", 11, 14).astype(np.float64)
    guidance = Guidance.of(image)
    across, down = oracles.guidance_by_loops(oracles.imported, image, image)
    np.testing.assert_array_equal(guidance.across, across)
    np.testing.assert_array_equal(guidance.down, down)


@pytest.mark.parametrize("cycle", ["V", "F", "W"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("colour", [True, False], ids=["colour", "grey"])
def test_dtypes_channels_and_cycles(cycle, dtype, colour):
    case = Case(lasso(60, 75), colour=colour)
    problem = case.problem(dtype=dtype)
    result = solve_multigrid(problem, cycle=cycle)
    assert result.solution.dtype == dtype
    assert_solved(case, problem, result, DEFAULT_TOLERANCE)


@pytest.mark.parametrize("channels", [1, 2, 4, 5])
@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
def test_any_number_of_channels(channels, solve):
    case = Case(lasso(40, 45), colour=False)
    gains = 1 - 0.1 * np.arange(channels)
    values = case.values[..., None] * gains
    problem = PoissonProblem(case.region, values, Guidance(*(part[..., None] * gains for part in case.field)))
    case.exact = case.exact[..., None] * gains
    assert_solved(case, problem, solve(problem), DEFAULT_TOLERANCE)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("level", [257.0, 1 / 255], ids=["16 bit", "0..1"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", ["disk", "everything"])
def test_the_tolerance_is_in_levels_whatever_the_units(solve, level, dtype, shape):
    case = Case(SHAPES[shape](*LARGE))
    problem = case.problem(dtype=dtype, level=level)
    assert_solved(case, problem, solve(problem), DEFAULT_TOLERANCE)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("guess", [-1000.0, 0.0, 1000.0])
def test_the_first_guess_does_not_matter(solve, guess):
    case = Case(lasso(60, 75))
    values = np.where(case.region[..., None], guess, case.values)
    problem = PoissonProblem(case.region, values, Guidance(*case.field))
    assert_solved(case, problem, solve(problem), DEFAULT_TOLERANCE)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
def test_without_a_known_pixel_the_mean_of_the_first_guess_is_kept(solve):
    case = Case(everything(50, 41))
    result = solve(case.problem())
    assert result.floating
    np.testing.assert_allclose(result.solution.mean((0, 1)), case.values.mean((0, 1)), atol=DEFAULT_TOLERANCE)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
def test_a_problem_already_solved_changes_by_nothing_that_shows(solve):
    case = Case(lasso(60, 75))
    problem = PoissonProblem(case.region, case.exact, Guidance(*case.field))
    result = solve(problem)
    assert_solved(case, problem, result, DEFAULT_TOLERANCE)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
def test_a_constant_picture_stays_what_it_is(solve):
    region = lasso(60, 75)
    values = np.where(region, 0.0, 128.0)
    np.testing.assert_allclose(solve(PoissonProblem(region, values)).solution, 128.0, atol=DEFAULT_TOLERANCE)


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("col", [3, 4])
def test_a_single_value_that_float32_does_not_hold_is_seen(channels, col):
    """The right-hand side is then computed anew from stage to stage: what was rounded has another solution."""
    region = np.zeros((9, 10), bool)
    region[1:-1, 1:-1] = True
    values = np.zeros((9, 10, channels))
    for channel in range(channels):
        for value, exact in ((0.5, True), (1 / 3, False)):
            rhs = values.copy()
            rhs[4, col, channel] = value
            problem = PoissonProblem(region, values, rhs=rhs)
            with Team(1, region.size) as team:
                assert Correction.of(problem, Arena(), team).exact is exact


# --- the same bits ----------------------------------------------------------------------------------


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("shape", ["disk", "noise", "spiral", "everything"])
def test_runs_and_thread_counts_give_the_same_bits(solve, shape):
    case = Case(SHAPES[shape](*LARGE))
    once = solve(case.problem(), threads=1)
    for threads in (1, 2, None):
        again = solve(case.problem(), threads=threads)
        assert again.solution.tobytes() == once.solution.tobytes()
        assert again.history == once.history


def test_the_arrays_of_the_problem_stay_as_they_were():
    case = Case(lasso(*SMALL))
    region, values, across, down = (a.copy() for a in (case.region, case.values, *case.field))
    problem = PoissonProblem(region, values, Guidance(across, down))
    for solve in (solve_multigrid, solve_sor):
        solve(problem)
    for array, original in zip(
        (region, values, across, down), (case.region, case.values, *case.field), strict=True
    ):
        np.testing.assert_array_equal(array, original)


def test_arrays_of_any_layout_are_taken():
    """Column-major, reversed and read-only arrays are what numpy users have."""
    case = Case(lasso(40, 45))
    across, down = case.field
    expected = solve_multigrid(case.problem()).solution
    read_only = case.values.copy()
    read_only.flags.writeable = False
    for values in (np.asfortranarray(case.values), case.values[::-1].copy()[::-1], read_only):
        region = np.asfortranarray(case.region)
        problem = PoissonProblem(region, values, Guidance(np.asfortranarray(across), down[::-1].copy()[::-1]))
        np.testing.assert_array_equal(solve_multigrid(problem).solution, expected)
