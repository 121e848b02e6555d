"""The real hierarchy, matrix-free and in float32, against dense matrices put together cell by cell."""

import numpy as np
import pytest

from solvers import Guidance, PoissonProblem, build_hierarchy, describe, solve_multigrid
from tests import oracles
from tests.gold_multigrid import OVERCORRECTION, Multigrid, finest, grids, prolongation, restriction
from tests.regions import NEAR_SINGULAR, SHAPES

SIZES = [(24, 24), (23, 30), (9, 40), (33, 17)]
WITH_A_KNOWN_PIXEL = [name for name in SHAPES if name != "everything"]
FLOAT32 = {"rtol": 2e-6, "atol": 1e-6}
ROUNDING, ROUNDING_NEAR_SINGULAR = 1e-3, 1e-2  # what float32 makes of values near 100


# --- the gold itself --------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", SHAPES)
def test_the_finest_gold_matrix_is_eq_7(shape):
    region = SHAPES[shape](13, 18)
    zeros = np.zeros((13, 18))
    matrix, _ = oracles.equations_by_loops(region, zeros, zeros[:, 1:], zeros[1:])
    np.testing.assert_array_equal(finest(region).matrix(), matrix.toarray())


@pytest.mark.parametrize("shape", WITH_A_KNOWN_PIXEL)
def test_gold_operators_are_symmetric_and_positive_definite_on_every_level(shape):
    for grid in grids(SHAPES[shape](23, 30)):
        a = grid.matrix()
        np.testing.assert_array_equal(a, a.T)
        np.linalg.cholesky(a)  # raises unless it is positive definite


def test_gold_transfers_keep_a_sum_and_a_constant():
    fine, coarse = grids(SHAPES["everything"](12, 17))[:2]
    np.testing.assert_array_equal(restriction(fine, coarse).sum(0), 1)
    np.testing.assert_allclose(prolongation(fine, coarse).sum(1), OVERCORRECTION)


# --- ours against it --------------------------------------------------------------------------------


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("shape", WITH_A_KNOWN_PIXEL)
def test_the_operator_of_every_level(shape, size):
    region = SHAPES[shape](*size)
    gold, hierarchy = grids(region), build_hierarchy(region)
    assert hierarchy.n_levels == len(gold)
    for level, grid in enumerate(gold):
        assert hierarchy.shape(level) == grid.active.shape
        assert hierarchy.unknowns[level] == grid.active.sum()
        edge_e, edge_s, diagonal = hierarchy.operator(level)
        np.testing.assert_allclose(edge_e, grid.east, **FLOAT32)
        np.testing.assert_allclose(edge_s, grid.south, **FLOAT32)
        np.testing.assert_allclose(diagonal, grid.diagonal(), **FLOAT32)


@pytest.mark.parametrize("cycle", ["V", "F", "W"])
@pytest.mark.parametrize("size", [(40, 44), (23, 30), (9, 40)], ids=str)
@pytest.mark.parametrize("shape", WITH_A_KNOWN_PIXEL)
def test_a_cycle_moves_every_pixel_where_the_gold_cycle_does(shape, size, cycle):
    """Smoother, transfers, coarse solve and the order of the visits: all at once, and pixel by pixel."""
    region = SHAPES[shape](*size)
    answer = np.random.default_rng(4).uniform(-100, 100, size)
    problem = PoissonProblem(region, np.where(region, 0.0, answer), Guidance.of(answer))
    multigrid = Multigrid(region)
    rounding = ROUNDING_NEAR_SINGULAR if shape in NEAR_SINGULAR else ROUNDING
    b = multigrid.matrices[0] @ answer[region]
    for cycles in (1, 2):
        u = np.zeros(int(region.sum()))
        for k in range(cycles):
            multigrid.cycle(cycle, u, b, last=k == cycles - 1)
        result = solve_multigrid(problem, cycle=cycle, tolerance=1e-12, max_iterations=cycles, direct=False)
        np.testing.assert_allclose(result.solution[region], u, rtol=0, atol=rounding)


def test_describe_says_how_many_unknowns_a_level_has():
    region = SHAPES["disk"](100, 120)
    text = describe(region)
    for grid in grids(region):
        assert f"{int(grid.active.sum()):,d}" in text
        assert f"{grid.active.shape[1]} x {grid.active.shape[0]}" in text
