"""Ours: the whole of `poisson_cli.clone`, and `solvers.solve_multigrid` on a problem that is ready."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from benchmarks import exact
from benchmarks.accuracy import Answer
from benchmarks.case import Case
from benchmarks.peers import Peer, Prepared, Promise, Scope

Array = np.ndarray[Any, Any]

FLOAT_CHECK = 20_000_000  # unknowns up to which the values before rounding are asked for too (in float64)


def prepare_clone(solver: Literal["multigrid", "sor"]) -> Callable[[Case, float], Prepared]:
    def prepare(case: Case, _limit: float) -> Prepared:
        import poisson_cli

        def clone(destination: Array, source: Array) -> Array:
            return poisson_cli.clone(destination, source, case.region, solver=solver, threads=1)

        def unrounded() -> Array:
            """The same call on the same pictures in floating point, full scale 0 to 1."""
            return clone(case.destination / 255, case.source / 255)[case.region] * 255

        clone(case.destination, case.source)  # warm-up: compiles, or loads what was compiled
        return Prepared(
            run=lambda: clone(case.destination, case.source),
            answer=Answer,
            unrounded=unrounded if case.unknowns <= FLOAT_CHECK else None,
        )

    return prepare


def ready(case: Case) -> tuple[Any, Array]:
    """The case as a PoissonProblem on its own crop, first guess and guidance from the source; and its values."""
    from solvers import Guidance, PoissonProblem

    crop = exact.crop_of(case.region)
    region, source = case.region[crop], case.source[crop].astype(np.float32)
    values = np.where(region[..., None], source, case.destination[crop].astype(np.float32))
    return PoissonProblem(region, values, Guidance.of(source)), values


def prepare_solve(case: Case, _limit: float) -> Prepared:
    from solvers import solve_multigrid

    problem, values = ready(case)
    region = case.region[exact.crop_of(case.region)]

    def run() -> Any:
        return solve_multigrid(problem, threads=1)

    run()  # warm-up

    def answer(result: Any) -> Answer:
        inside = result.solution[region]
        disturbed = (result.solution != values).any(axis=2) & ~region
        return Answer(case.picture(inside), inside, int(disturbed.sum()))

    return Prepared(run, answer)


PEERS = (
    Peer("ours, multigrid", Scope.CLONE, Promise.PICTURE, prepare_clone("multigrid"), reference=True),
    Peer("ours, SOR", Scope.CLONE, Promise.PICTURE, prepare_clone("sor")),
    Peer("ours, multigrid", Scope.SOLVE, Promise.PICTURE, prepare_solve, reference=True),
)
