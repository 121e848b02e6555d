"""Everyone on one case: prepare, time interleaved, check every answer."""

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
    """One peer's row."""

    peer: Peer
    timing: Timing
    accuracy: Accuracy


@dataclass(frozen=True)
class Results:
    entries: list[Entry]
    pasted: Accuracy  # of the source pasted as it is: what no tool may be worse than
    left_out: dict[str, TooSlowError | str]  # peer -> why it did not run
    wrong: list[str]

    def ratio(self, entry: Entry) -> float:
        """Median time over that of our row of the same scope; NaN where ours did not run."""
        ours = (e for e in self.entries if e.peer.reference and e.peer.scope is entry.peer.scope)
        return next((entry.timing.median / e.timing.median for e in ours), math.nan)


def key(peer: Peer) -> str:
    return f"{peer.name} ({peer.scope.value})"


def run(case: Case, peers: Iterable[Peer], *, rounds: int, seconds: float, limit: float) -> Results:
    """Time `peers` on `case`; one whose single run takes longer than `limit` seconds is left out."""
    ready: dict[str, tuple[Peer, Prepared]] = {}
    left_out: dict[str, TooSlowError | str] = {}
    wrong: list[str] = []
    for peer in peers:
        if peer.missing:
            left_out[key(peer)] = f"{peer.missing} is not installed"
            continue
        try:
            ready[key(peer)] = peer, peer.prepare(case, limit)
        except TooSlowError as slow:
            left_out[key(peer)] = slow
        except Exception as error:  # one tool's failure must not take the others' figures with it
            wrong.append(f"{key(peer)}: {type(error).__name__}: {error}")

    first: dict[str, Answer] = {}

    def same(name: str, result: Any) -> None:
        answer = ready[name][1].answer(result)
        if first.setdefault(name, answer) != answer:
            wrong.append(f"{name}: two runs gave different pictures")

    runs = {name: prepared.run for name, (_, prepared) in ready.items()}
    timings = interleave(runs, rounds=rounds, seconds=seconds, check=same)
    pasted = accuracy.of(case, Answer(case.picture(case.source[case.region])))
    entries = []
    for name, (peer, prepared) in ready.items():
        answer = first.pop(name)
        if prepared.unrounded is not None:
            answer = replace(answer, values=prepared.unrounded())
        entries.append(Entry(peer, timings[name], accuracy.of(case, answer)))
        wrong += broken(peer, entries[-1].accuracy, pasted)
    return Results(entries, pasted, left_out, wrong)


def wanted(peers: Iterable[Peer], without: Iterable[str], *scopes: Scope) -> list[Peer]:
    """Those of `peers` in `scopes` whose name holds none of the words in `without`."""
    words = [word.lower() for word in without]
    return [p for p in peers if p.scope in scopes and not any(word in p.name.lower() for word in words)]
