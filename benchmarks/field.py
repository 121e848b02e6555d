"""Any tools on any cases: prepare, time all of them interleaved, check every answer."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from benchmarks import accuracy
from benchmarks.accuracy import Accuracy, Answer
from benchmarks.case import Case
from benchmarks.peers import Peer, Prepared, Scope, TooSlowError, broken
from benchmarks.timing import Timing, interleave


@dataclass(frozen=True)
class Entry:
    """One tool on one case."""

    case: Case
    peer: Peer
    timing: Timing
    accuracy: Accuracy

    @property
    def nanoseconds(self) -> float:
        """Median time per unknown and channel."""
        return self.timing.median * 1e9 / self.case.exact.size


@dataclass(frozen=True)
class Results:
    entries: list[Entry]
    left_out: dict[str, TooSlowError | str]  # who, on what -> why
    wrong: list[str]

    def ratio(self, entry: Entry) -> float:
        """Median time over that of our row on the same case and of the same scope; NaN where ours did not run."""
        ours = (e for e in self.entries if e.peer.reference and e.peer.scope is entry.peer.scope)
        return next((entry.timing.median / e.timing.median for e in ours if e.case is entry.case), math.nan)


def run(pairs: Iterable[tuple[Case, Peer]], *, rounds: int, seconds: float, limit: float) -> Results:
    """Time every pair, all interleaved; one whose single run takes longer than `limit` seconds is left out."""
    ready: dict[str, tuple[Case, Peer, Prepared]] = {}
    left_out: dict[str, TooSlowError | str] = {}
    wrong: list[str] = []
    for case, peer in pairs:
        name = f"{case.name}: {peer.name} ({peer.scope.value})"
        if peer.missing:
            left_out[name] = f"{peer.missing} is not installed"
            continue
        try:
            ready[name] = case, peer, peer.prepare(case, limit)
        except TooSlowError as slow:
            left_out[name] = slow
        except Exception as error:  # one tool's failure must not take the others' figures with it
            wrong.append(f"{name}: {type(error).__name__}: {error}")

    first: dict[str, Answer] = {}

    def same(name: str, result: Any) -> None:
        answer = ready[name][2].answer(result)
        if first.setdefault(name, answer) != answer:
            wrong.append(f"{name}: two runs gave different pictures")

    tasks = {name: prepared.run for name, (_, _, prepared) in ready.items()}
    timings = interleave(tasks, rounds=rounds, seconds=seconds, check=same)
    entries = []
    for name, (case, peer, prepared) in ready.items():
        answer = first.pop(name)
        if prepared.unrounded is not None:
            answer = replace(answer, values=prepared.unrounded())
        entry = Entry(case, peer, timings[name], accuracy.of(case, answer))
        wrong += [f"{name}: {line}" for line in broken(peer.promise, entry.accuracy, case.pasted_rms)]
        entries.append(entry)
    return Results(entries, left_out, wrong)


def wanted(peers: Iterable[Peer], without: Iterable[str], *scopes: Scope) -> list[Peer]:
    """Those of `peers` in `scopes` whose name holds none of the words in `without`."""
    words = [word.lower() for word in without]
    return [p for p in peers if p.scope in scopes and not any(word in p.name.lower() for word in words)]
