"""`python -m benchmarks convergence`: by how much one cycle shrinks the error, per region shape and cycle.

Some cycles map the error e to E e, whatever the right-hand side.  So the factor is measured as one finds an
eigenvalue: make the present error the exact solution of a new problem, run as many cycles from zero as the solver does
in a row (`ROW`; what lies between them is not what lies before the first), take what is left, blow it up to a hundred
levels, and again.  Rounding never comes near, and no guard against stalling steps in.  The factor of a cycle is the
geometric mean over the last `WINDOW` of `ROWS` such rows, each the worst of three channels that begin with different
random errors.
"""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks import machine, shapes
from benchmarks.exact import minus_laplacian
from benchmarks.table import render

if TYPE_CHECKING:
    from solvers.cycles import Cycle

Array = np.ndarray[Any, Any]

SIDE = 257  # pixels: eight levels
ROW, ROWS, WINDOW = 3, 6, 3
SIZE = 100.0  # levels

LIMITS = {"F": 0.15, "W": 0.15}  # V has none: the solver must notice
NEAR_SINGULAR_LIMITS = {"F": 0.25, "W": 0.15}


def run(arguments: Namespace) -> list[str]:
    print(machine.describe())
    print(
        f"\nConvergence factor per cycle in frames of {SIDE} x {SIDE}, one sweep before and one after."
        "\nCycles: what a solve takes from a random error of 100 levels to the default tolerance, and what cycle it"
        "\nchanged to on the way.\n"
    )
    rows, wrong = [], []
    cycles: tuple[Cycle, ...] = ("V", "F", "W")
    for name, shape in shapes.EVERY.items():
        region = shape(SIDE)
        limits = NEAR_SINGULAR_LIMITS if name in shapes.NEAR_SINGULAR else LIMITS
        factors, solves = [], []
        for cycle in cycles:
            measured = factor(region, cycle)
            if measured > limits.get(cycle, np.inf):
                wrong.append(f"{name}: {cycle} contracts by {measured:.3f}, allowed {limits[cycle]}")
            factors.append(f"{measured:.3f}")
            told, complaint = solve(region, cycle)
            solves.append(told)
            wrong += [f"{name}: {cycle}: {line}" for line in complaint]
        rows.append([name, f"{region.sum():,}", *factors, *solves])
    header = ["region", "unknowns", "V(1,1)", "F(1,1)", "W(1,1)", "V cycles", "F cycles", "W cycles"]
    print(render(header, rows, markdown=arguments.markdown))
    return wrong


def factor(region: Array, cycle: Cycle) -> float:
    """By what one cycle shrinks the error that it shrinks least; 0 for a cycle that solves exactly."""
    from solvers import PoissonProblem, solve_multigrid

    error = start(region)
    factors: list[float] = []
    for _ in range(ROWS):
        problem = PoissonProblem(region, np.zeros_like(error), rhs=minus_laplacian(error))
        solution = solve_multigrid(
            problem, cycle=cycle, tolerance=1e-12, max_iterations=ROW, threads=1, direct=False
        ).solution
        error -= solution
        if region.all():  # a constant is no error there, and blown up it would be all there is
            error -= error.mean((0, 1))
        left = np.abs(error).max((0, 1))
        factors.append(float((left / SIZE).max() ** (1 / ROW)))
        if factors[-1] < 1e-2:  # rounding is all that is left
            return 0.0
        error *= SIZE / np.maximum(left, 1e-300)
    return float(np.exp(np.mean(np.log(factors[-WINDOW:]))))


def solve(region: Array, cycle: Cycle) -> tuple[str, list[str]]:
    """A solve at the default tolerance: how many cycles (and which, once one was given up), what is wrong."""
    from solvers import DEFAULT_TOLERANCE, PoissonProblem, solve_multigrid

    wanted = start(region)
    problem = PoissonProblem(region, np.zeros_like(wanted), rhs=minus_laplacian(wanted))
    result = solve_multigrid(problem, cycle=cycle, threads=1, direct=False)
    largest = np.abs(result.solution - wanted).max()
    wrong = []
    if not result.converged:
        wrong.append(f"not converged after {result.iterations} cycles")
    elif largest > DEFAULT_TOLERANCE:
        wrong.append(f"largest error {largest:.1e} levels, tolerance {DEFAULT_TOLERANCE}")
    _, given_up, then = result.method.partition(", ")
    return f"{result.iterations}{f' ({then})' if given_up else ''}", wrong


def start(region: Array) -> Array:
    """Random errors up to `SIZE` levels, (H, W, 3) float64, zero outside; of mean zero where all is unknown."""
    error = np.random.default_rng(1).normal(size=(*region.shape, 3)) * region[..., None]
    if region.all():
        error -= error.mean((0, 1))
    scaled: Array = error * (SIZE / np.abs(error).max((0, 1)))
    return scaled
