"""`PoissonProblem` is the only gate to the kernels: whatever makes no sense stops there, with a reason."""

import numpy as np
import pytest

from solvers import Guidance, PoissonProblem, solve_multigrid, solve_sor


def region(height: int = 6, width: int = 8) -> np.ndarray:
    inside = np.zeros((height, width), bool)
    inside[2:4, 2:5] = True
    return inside


def values(height: int = 6, width: int = 8, channels: int = 3) -> np.ndarray:
    return np.random.default_rng(0).uniform(0, 255, (height, width, channels))


def test_a_good_problem_is_accepted():
    problem = PoissonProblem(region(), values(), Guidance.zero((6, 8, 3)))
    assert problem.level == 1.0
    PoissonProblem(region(), values()[..., 0])
    PoissonProblem(region(), values().astype(np.float32), rhs=values())


@pytest.mark.parametrize(
    ("wrong_region", "wrong_values"),
    [
        (region(6, 9), values()),
        (region()[None], values()),
        (region()[0], values()[0]),
        (region(), values()[None]),
        (region(), values()[:, :-1]),
        (region(), values()[..., :0]),
        (region(0, 0), values(0, 0)),
    ],
    ids=["sizes differ", "region 3-d", "1-d", "values 4-d", "values narrower", "no channel", "empty"],
)
def test_shapes_that_do_not_fit(wrong_region, wrong_values):
    with pytest.raises(ValueError):
        PoissonProblem(wrong_region, wrong_values)


def test_both_sizes_are_named():
    with pytest.raises(ValueError, match=r"(?s)6.*9.*6.*8|6.*8.*6.*9"):
        PoissonProblem(region(6, 9), values())


def test_a_region_without_an_unknown():
    with pytest.raises(ValueError, match="unknown"):
        PoissonProblem(np.zeros((6, 8), bool), values())


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", [(0, 0, 0), (2, 2, 1)], ids=["known", "unknown"])
def test_values_that_are_no_numbers(bad, where):
    wrong = values()
    wrong[where] = bad
    with pytest.raises(ValueError, match="finite"):
        PoissonProblem(region(), wrong)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_guidance_that_is_no_number(bad):
    guidance = Guidance.of(values())
    across = guidance.across.copy()
    across[2, 2, 0] = bad
    with pytest.raises(ValueError, match="finite"):
        PoissonProblem(region(), values(), Guidance(across, guidance.down))


def test_a_right_hand_side_that_is_no_number():
    rhs = values()
    rhs[2, 2, 0] = np.nan
    with pytest.raises(ValueError, match="finite"):
        PoissonProblem(region(), values(), rhs=rhs)


@pytest.mark.parametrize("wrong", [(6, 9, 3), (5, 8, 3), (6, 8), (6, 8, 1), (6, 8, 4)], ids=str)
def test_guidance_and_right_hand_side_of_another_shape(wrong):
    with pytest.raises(ValueError):
        PoissonProblem(region(), values(), Guidance.zero(wrong))
    with pytest.raises(ValueError):
        PoissonProblem(region(), values(), rhs=np.zeros(wrong))


def test_guidance_and_right_hand_side_together():
    with pytest.raises(ValueError):
        PoissonProblem(region(), values(), Guidance.zero((6, 8, 3)), rhs=np.zeros((6, 8, 3)))


@pytest.mark.parametrize("level", [0.0, -1.0, np.nan, np.inf])
def test_a_level_that_is_no_size(level):
    with pytest.raises(ValueError, match="level"):
        PoissonProblem(region(), values(), level=level)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, np.inf])
def test_a_tolerance_that_cannot_be_met(solve, tolerance):
    with pytest.raises(ValueError, match="tolerance"):
        solve(PoissonProblem(region(), values()), tolerance=tolerance)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("limit", [0, -3])
def test_no_iteration_allowed(solve, limit):
    with pytest.raises(ValueError, match="max_iterations"):
        solve(PoissonProblem(region(), values()), max_iterations=limit)


@pytest.mark.parametrize("solve", [solve_multigrid, solve_sor])
@pytest.mark.parametrize("threads", [0, -1])
def test_no_thread_allowed(solve, threads):
    with pytest.raises(ValueError, match="threads"):
        solve(PoissonProblem(region(), values()), threads=threads)


def test_an_unknown_cycle_is_named():
    with pytest.raises(ValueError, match="X"):
        solve_multigrid(PoissonProblem(region(), values()), cycle="X")  # type: ignore[arg-type]
