"""`python -m benchmarks shapes`: cost by the shape of the region, and how honest the error estimate is."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import dataclass

import numpy as np

from benchmarks import case, exact, field, machine, peers, shapes
from benchmarks.case import Case
from benchmarks.peers import Scope
from benchmarks.peers.ours import ready
from benchmarks.table import render, three

FLOOR = 1e-4  # levels: true errors below this are float32's, of which an estimate knows nothing
HONEST = 0.7, 5.0  # estimate / true error, above the floor


@dataclass(frozen=True)
class Honesty:
    """What one solve said of its error, and what was true, in levels."""

    cycles: int  # to the default tolerance
    true_error: float
    tolerance: float
    ratios: tuple[
        float, ...
    ]  # estimate / true error, after the second cycle and all later ones above the floor

    def broken(self) -> list[str]:
        found = []
        if self.true_error > self.tolerance:
            found.append(f"error {self.true_error:.1e} levels, tolerance {self.tolerance}")
        if any(not HONEST[0] <= ratio <= HONEST[1] for ratio in self.ratios):
            found.append(f"estimate / true error {self.range}, allowed {HONEST[0]} to {HONEST[1]}")
        return found

    @property
    def range(self) -> str:
        return f"{min(self.ratios):.2f} to {max(self.ratios):.2f}" if self.ratios else "-"


def run(arguments: Namespace) -> list[str]:
    cases = [
        case.of_region(shapes.with_unknowns(shape, arguments.unknowns), name)
        for name, shape in shapes.INTERIOR.items()
    ]
    results = field.run(
        [(c, peers.reference(scope)) for c in cases for scope in Scope],
        rounds=arguments.rounds,
        seconds=arguments.seconds,
        limit=np.inf,
    )
    wrong = results.wrong
    cost = {(entry.case.name, entry.peer.scope): entry.nanoseconds for entry in results.entries}
    rows = []
    for c in cases:
        honesty = measure(c)
        wrong += [f"{c.name}: {line}" for line in honesty.broken()]
        row = [c.name, f"{c.unknowns:,}", f"{c.unknowns / c.region[exact.crop_of(c.region)].size:.0%}"]
        row.append(str(honesty.cycles))
        for scope in (Scope.SOLVE, Scope.CLONE):
            here, disk = (cost.get((name, scope), np.nan) for name in (c.name, "disk"))
            row += [three(here), three(here / disk)]
        rows.append([*row, three(honesty.true_error / honesty.tolerance), honesty.range])
    print(machine.describe())
    print(
        "\nns: median nanoseconds per unknown and channel, 3 channels, one thread, set-up included; x disk: against"
        "\nthe disk's.  of crop: share of the region's bounding box.  true error: the largest inside, at the default"
        "\ntolerance.  estimate / true: after the second and every later cycle whose true error is above"
        f"\n{FLOOR} level.\n"
    )
    header = ["region", "unknowns", "of crop", "cycles", "solve ns", "x disk", "clone ns", "x disk"]
    print(render([*header, "true error / tolerance", "estimate / true"], rows, markdown=arguments.markdown))
    return wrong


def measure(c: Case) -> Honesty:
    """Solve with two cycles, three, ... to as many as the default tolerance takes, each against the exact one."""
    from solvers import solve_multigrid

    problem, _ = ready(c)
    region = problem.region

    def true_error(solution: object) -> float:
        return float(np.abs(np.asarray(solution)[region] - c.exact).max())

    final = solve_multigrid(problem, threads=1)
    by_cycles = solve_multigrid(problem, threads=1, direct=False)
    ratios = []
    for cycles in range(2, by_cycles.iterations + 1):
        result = solve_multigrid(problem, max_iterations=cycles, threads=1, direct=False)
        if (true := true_error(result.solution)) > FLOOR:
            ratios.append(result.error_estimate / true)
    return Honesty(final.iterations, true_error(final.solution), final.tolerance, tuple(ratios))
