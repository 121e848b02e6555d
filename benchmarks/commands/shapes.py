"""`python -m benchmarks shapes`: cost by the shape of the region, and how honest the error estimate is."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import dataclass

import numpy as np

from benchmarks import accuracy, case, exact, machine, peers, shapes
from benchmarks.case import Case
from benchmarks.peers import Peer, Prepared, Scope, ours
from benchmarks.table import render, three
from benchmarks.timing import Timing, interleave

FLOOR = 1e-4  # levels: true errors below this are float32's, of which an estimate knows nothing
HONEST = 0.7, 5.0  # estimate / true error, above the floor


@dataclass(frozen=True)
class Honesty:
    """Errors in levels, on the case's own pictures."""

    true_error: float  # at the default tolerance
    tolerance: float
    cycles: int
    ratios: tuple[
        float, ...
    ]  # estimate / true error after the second cycle and every later one above the floor


def run(arguments: Namespace) -> list[str]:
    clone, solve = (_ours(scope) for scope in (Scope.CLONE, Scope.SOLVE))
    cases = {
        name: case.of_region(shapes.with_unknowns(shape, arguments.unknowns))
        for name, shape in shapes.INTERIOR.items()
    }
    prepared = {(name, p): p.prepare(c, np.inf) for name, c in cases.items() for p in (clone, solve)}
    timings, wrong = _time(cases, prepared, arguments)

    disk = {p: _cost(cases["disk"], timings["disk", p]) for p in (clone, solve)}
    rows = []
    for name, c in cases.items():
        honesty = measure(c)
        cost = {p: _cost(c, timings[name, p]) for p in (clone, solve)}
        if honesty.true_error > honesty.tolerance:
            wrong.append(f"{name}: error {honesty.true_error:.1e} levels, tolerance {honesty.tolerance}")
        if honesty.ratios and not HONEST[0] <= min(honesty.ratios) <= max(honesty.ratios) <= HONEST[1]:
            wrong.append(
                f"{name}: estimate / true error from {min(honesty.ratios):.2f} to {max(honesty.ratios):.2f}"
            )
        share = c.unknowns / np.prod([side.stop - side.start for side in exact.crop_of(c.region)])
        rows.append(
            [
                name,
                f"{c.unknowns:,}",
                f"{share:.0%}",
                str(honesty.cycles),
                three(cost[solve]),
                three(cost[solve] / disk[solve]),
                three(cost[clone]),
                three(cost[clone] / disk[clone]),
                three(honesty.true_error / honesty.tolerance),
                f"{min(honesty.ratios):.2f} to {max(honesty.ratios):.2f}" if honesty.ratios else "-",
            ]
        )
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

    problem, _ = ours.ready(c)
    region = problem.region

    def true_error(solution: object) -> float:
        return float(np.abs(np.asarray(solution)[region] - c.exact).max())

    final = solve_multigrid(problem, threads=1)
    ratios = []
    for cycles in range(2, final.iterations + 1):
        result = solve_multigrid(problem, max_iterations=cycles, threads=1)
        if (true := true_error(result.solution)) > FLOOR:
            ratios.append(result.error_estimate / true)
    return Honesty(true_error(final.solution), final.tolerance, final.iterations, tuple(ratios))


def _ours(scope: Scope) -> Peer:
    return next(p for p in peers.every() if p.reference and p.scope is scope)


def _time(
    cases: dict[str, Case], prepared: dict[tuple[str, Peer], Prepared], arguments: Namespace
) -> tuple[dict[tuple[str, Peer], Timing], list[str]]:
    """Times of every shape and scope, interleaved; and what was wrong with any answer."""
    wrong: list[str] = []
    labels = {f"{name}, {peer.scope.value}": (name, peer) for name, peer in prepared}
    seen: set[str] = set()

    def check(label: str, result: object) -> None:
        if label in seen:
            return
        seen.add(label)
        name, peer = labels[label]
        c, one = cases[name], prepared[labels[label]]
        answer = one.answer(result)
        if one.unrounded is not None:
            answer = accuracy.Answer(answer.picture, one.unrounded())
        pasted = accuracy.of(c, accuracy.Answer(c.source))
        wrong.extend(f"{name}: {line}" for line in peers.broken(peer, accuracy.of(c, answer), pasted))

    timings = interleave(
        {label: prepared[key].run for label, key in labels.items()},
        rounds=arguments.rounds,
        seconds=arguments.seconds,
        check=check,
    )
    return {labels[label]: timing for label, timing in timings.items()}, wrong


def _cost(c: Case, timing: Timing) -> float:
    """Nanoseconds per unknown and channel."""
    return timing.median * 1e9 / c.exact.size
