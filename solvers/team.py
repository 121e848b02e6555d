"""Several threads on one operation, with the same bits for any number of them.

Kernels release the GIL, so plain threads serve.  An operation is cut into parts, contiguous ranges of segments, runs or
rows; each part computes from values that no other part changes at the same time.  There are two ways to cut:

- bands, one for each thread, where parts that border on each other must be reconciled afterwards: few borders;
- pieces of a size of their own, where parts have nothing to do with each other: a thread that is held up, by another
  program say, leaves what it does not get to for the others.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from itertools import pairwise
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from solvers.problem import OptionError

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

# Values (unknowns times channels) below which an operation is too short to be worth handing out: about 50 us.
WORTH_SHARING = 200_000

# Values in a piece: a few ms of work, beside which handing it out is nothing.
PIECE = 2_000_000

# Values from which a single thread, too, works in several calls: some 20 ms.  Signals are heard between them.
LONG_CALL = 10_000_000

Band = tuple[int, int]


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Team:
    """A number of threads that lives as long as its context.

    Parameters
    ----------
    threads : int or None
        None: as many as there are cores if `values`, the size of the problem, makes that pay, else 1.

    Raises
    ------
    OptionError
        If there is to be no thread.
    """

    def __init__(self, threads: int | None, values: int) -> None:
        if threads is not None and threads < 1:
            raise OptionError(f"threads is {threads}, but must be at least 1")
        if threads is None:
            threads = available_cores() if values >= 4 * WORTH_SHARING else 1
        self.threads = threads
        self._pool: ThreadPoolExecutor | None = None
        if threads > 1:
            from concurrent import futures  # takes 5 ms, which most solves need not spend

            self._pool = futures.ThreadPoolExecutor(threads - 1)

    def __enter__(self) -> Team:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is not None:
            self._pool.shutdown()

    def shares(self, values: int) -> bool:
        """Whether so much work is to be cut into pieces."""
        return values >= (WORTH_SHARING if self.threads > 1 else LONG_CALL)

    def bands(self, sizes: NDArray[np.int64], first: int = 0, values: int = 0) -> list[Band]:
        """Ranges that split items of these sizes into one part for each thread; `first` is added to both ends.

        Where they hold very many `values` there are several parts for each thread, so that none takes long.
        """
        parts = self.threads * max(1, -(-values // (LONG_CALL * self.threads)))
        if parts == 1 or len(sizes) < 2 * parts:
            return [(first, first + len(sizes))]
        return [(first + low, first + high) for low, high in _cut(sizes, parts)]

    def pieces(self, stretches: NDArray[Any], column: int, values: int) -> list[NDArray[Any]]:
        """Runs or segments in slices of about equally many places, for `run`.

        Parameters
        ----------
        stretches : (n, 3 or 4) int array
            Stretches of places.
        column : int
            Where a stretch's first place stands; its end is in the next column.
        values : int
            What there is to do, for all of them.
        """
        count = min(self._pieces(values), len(stretches))
        if count <= 1:
            return [stretches]
        sizes = stretches[:, column + 1].astype(np.int64) - stretches[:, column]
        return [stretches[low:high] for low, high in _cut(sizes, count)]

    def rows(self, height: int, values: int) -> list[Band]:
        """Ranges of the rows of an image, each beginning with an even one, for `run`; `values` are all it has."""
        pairs = (height + 1) // 2
        count = min(self._pieces(values), pairs)
        edges = [2 * (pairs * k // count) for k in range(count)]
        return list(pairwise([*edges, height]))

    def _pieces(self, values: int) -> int:
        """Into how many pieces to cut so much work: the same for every thread, if there are several."""
        if self.threads == 1:
            return max(1, -(-values // LONG_CALL))
        return self.threads * -(-values // (PIECE * self.threads)) if values >= WORTH_SHARING else 1

    def run(self, operation: Callable[..., Any], parts: Sequence[tuple[Any, ...]]) -> list[Any]:
        """``operation(*part)`` for every part, side by side; returns when all are done, in the parts' order.

        Threads take one part after the other.  Where one fails no further one is begun.
        """
        if self._pool is None or len(parts) == 1:
            return [operation(*part) for part in parts]
        results: list[Any] = [None] * len(parts)
        left = list(range(len(parts)))[::-1]
        lock = threading.Lock()

        def work() -> None:
            while True:
                with lock:
                    if not left:
                        return
                    k = left.pop()
                try:
                    results[k] = operation(*parts[k])
                except BaseException:
                    left.clear()
                    raise

        others = [self._pool.submit(work) for _ in range(min(self.threads, len(parts)) - 1)]
        try:
            work()
        finally:
            left.clear()  # an interrupt may come where no part is under way
        for other in others:
            other.result()
        return results


def _cut(sizes: NDArray[np.int64], parts: int) -> list[Band]:
    """Ranges that split items of these sizes into so many parts of about the same size; none is empty."""
    ends = np.cumsum(sizes)
    cuts = np.searchsorted(ends, ends[-1] * np.arange(1, parts) / parts)
    edges = [0, *(int(cut) for cut in cuts), len(sizes)]
    return [(low, high) for low, high in pairwise(edges) if high > low]
