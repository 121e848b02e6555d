"""When a solver stops, what it says about its error, and what it tells while it goes."""

import numpy as np
import pytest

from solvers import DEFAULT_TOLERANCE, solve_multigrid, solve_sor, sor
from solvers.tolerance import next_rate
from tests.regions import LARGE, NEAR_SINGULAR, SHAPES
from tests.test_solvers_accuracy import Case
from tests.test_solvers_convergence import problem_with_known_answer

FLOOR = 1e-4  # levels: true errors below are of float32's making, of which an estimate knows nothing

# Regions that contract so fast that any honest estimate is far above the error by the second cycle.
INSTANT = ("one_pixel", "strokes_of_1_pixel", "checkerboard")


@pytest.mark.parametrize("shape", [shape for shape in SHAPES if shape not in INSTANT])
def test_every_estimate_from_the_second_cycle_on_is_of_the_size_of_the_error(shape):
    problem, answer = problem_with_known_answer(SHAPES[shape](*LARGE))
    last = solve_multigrid(problem, direct=False).iterations
    for cycles in range(2, last + 1):
        result = solve_multigrid(problem, tolerance=1e-12, max_iterations=cycles, direct=False)
        error = np.abs(result.solution - answer).max()
        if error > FLOOR:
            assert 0.7 <= result.error_estimate / error <= (8 if shape in NEAR_SINGULAR else 5), cycles


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_default_tolerance_holds_for_errors_of_every_wavelength(shape, solve):
    problem, answer = problem_with_known_answer(SHAPES[shape](*LARGE))
    result = solve(problem)
    assert result.converged
    assert np.abs(result.solution - answer).max() <= DEFAULT_TOLERANCE


@pytest.mark.parametrize(
    ("rates", "expected"),
    [
        ([], 0.0),
        ([0.1], 0.1),
        ([0.3, 0.1], 0.3),  # one fast step proves nothing
        ([0.1, 0.1], 0.1),
        ([0.1, 0.15], 0.225),  # on the rise, it rises on
        ([0.01, 0.1], 0.2),  # but not without limit
        ([0.3, 0.45], 0.5),
        ([0.5, 0.6], 0.6),  # and a slow one is what it is
        ([0.9, 0.2, 0.2], 0.2),
        ([0.0, 0.1], 0.1),
    ],
    ids=str,
)
def test_the_rate_to_expect(rates, expected):
    assert next_rate(rates) == pytest.approx(expected)


# --- the relaxation factor of SOR -------------------------------------------------------------------


@pytest.mark.parametrize("shape", SHAPES)
def test_omega_is_nearly_the_best_one_for_the_region(shape):
    """Within 1.3 times the sweeps of the best of a search on both sides of it."""
    problem, _ = problem_with_known_answer(SHAPES[shape](65, 72))
    own = solve_sor(problem)
    gap = 2 - float(own.method.rpartition("=")[2])
    best = own.iterations
    for share in (0.4, 0.6, 0.75, 0.88, 1.15, 1.35, 1.7):
        if gap * share < 2:
            other = solve_sor(problem, omega=2 - gap * share, max_iterations=own.iterations)
            best = min(best, other.iterations) if other.converged else best
    assert own.iterations <= 1.3 * best


def test_a_long_solve_by_sor_recommends_multigrid():
    problem, _ = problem_with_known_answer(SHAPES["all_but_one_pixel"](450, 450))
    result = solve_sor(problem)
    assert result.advice is not None
    assert "multigrid would be about" in result.advice
    assert solve_multigrid(problem).advice is None


def test_a_short_one_does_not():
    assert solve_sor(problem_with_known_answer(SHAPES["disk"](64, 64))[0]).advice is None
    assert solve_sor(problem_with_known_answer(SHAPES["islands"](450, 450))[0]).advice is None


# --- progress ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
def test_progress_is_told_after_every_step(solve):
    told: list[tuple[int, float]] = []
    result = solve(
        Case(SHAPES["disk"](64, 64)).problem(), progress=lambda *iteration_error: told.append(iteration_error)
    )
    assert len(told) == len(result.history)
    assert told[-1][0] == result.iterations
    assert [error for _, error in told[:-1]] == list(result.history[:-1])


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
def test_an_exception_in_progress_ends_the_solve(solve):
    def stop(iteration: int, error: float) -> None:
        raise KeyboardInterrupt

    problem = Case(SHAPES["disk"](64, 64)).problem()
    with pytest.raises(KeyboardInterrupt):
        solve(problem, progress=stop)
    assert solve(problem).converged  # and leaves nothing behind that disturbs the next one


# --- SOR in several calls ---------------------------------------------------------------------------


@pytest.mark.parametrize("shape", ["disk", "noise", "strokes_of_1_pixel", "everything"])
def test_sor_gives_the_same_bits_for_any_number_of_threads_and_length_of_a_call(shape, monkeypatch):
    """A half sweep reads the other colour only, so it may be cut anywhere."""
    problem = Case(SHAPES[shape](*LARGE)).problem()
    one = solve_sor(problem, threads=1)
    assert solve_sor(problem, threads=3).solution.tobytes() == one.solution.tobytes()
    monkeypatch.setattr(sor, "CALL", 5000)
    for threads in (1, 2):
        assert solve_sor(problem, threads=threads).solution.tobytes() == one.solution.tobytes()
