"""The same bits for any number of threads, on every shape, with every level shared out."""

import numpy as np
import pytest

from solvers import Guidance, PoissonProblem, cycles, solve_multigrid
from tests.regions import SHAPES

SIZES = ((90, 75), (33, 160))


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("cycle", cycles.CYCLES)
@pytest.mark.parametrize("shape", SHAPES)
def test_bands_of_any_number_give_the_same_bits(shape, cycle, size, monkeypatch):
    """Large problems are cut into bands; here small ones are, so that seams lie everywhere."""
    region = SHAPES[shape](*size)
    rng = np.random.default_rng(7)
    values = rng.integers(0, 256, (*size, 2)).astype(np.float32)
    problem = PoissonProblem(region, values, Guidance.of(values[::-1].copy()))
    alone = solve_multigrid(problem, cycle=cycle, threads=1, direct=False)
    monkeypatch.setattr(cycles, "WORTH_SHARING", 1)
    for threads in (2, 3, 7):
        shared = solve_multigrid(problem, cycle=cycle, threads=threads, direct=False)
        assert shared.solution.tobytes() == alone.solution.tobytes()
        assert shared.history == alone.history
    monkeypatch.setattr(
        cycles, "LONG_VISIT", 1
    )  # step by step, as a single thread does where calls would be long
    assert solve_multigrid(problem, cycle=cycle, threads=1, direct=False).history == alone.history


def test_levels_really_are_shared_out(monkeypatch):
    monkeypatch.setattr(cycles, "WORTH_SHARING", 1)
    asked = []
    real = cycles.Team.run

    def counting(team, operation, parts):
        asked.append(len(parts))
        return real(team, operation, parts)

    monkeypatch.setattr(cycles.Team, "run", counting)
    region = SHAPES["disk"](160, 160)
    solve_multigrid(PoissonProblem(region, np.zeros((160, 160), np.float32)), threads=3)
    assert max(asked) == 3
