"""Several threads on one operation, with the same bits for any number of them.

Kernels release the GIL, so plain threads serve.  An operation is cut into bands, contiguous ranges of segments or runs
of about the same size; each band computes from values that no other band changes at the same time.
"""

import os
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

Band = tuple[int, int]


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def check_threads(threads: int | None) -> None:
    """OptionError if there is to be no thread."""
    if threads is not None and threads < 1:
        raise OptionError(f"threads is {threads}, but must be at least 1")


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
        check_threads(threads)
        if threads is None:
            threads = available_cores() if values >= 4 * WORTH_SHARING else 1
        self.threads = threads
        self._pool: ThreadPoolExecutor | None = None
        if threads > 1:
            from concurrent import futures  # takes 5 ms, which most solves need not spend

            self._pool = futures.ThreadPoolExecutor(threads - 1)

    def __enter__(self) -> "Team":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is not None:
            self._pool.shutdown()

    def bands(self, sizes: NDArray[np.int64], first: int = 0) -> list[Band]:
        """Ranges that split items of these sizes into as many parts as there are threads; `first` is added to both."""
        if self.threads == 1 or len(sizes) < 2 * self.threads:
            return [(first, first + len(sizes))]
        ends = np.cumsum(sizes)
        cuts = np.searchsorted(ends, ends[-1] * np.arange(1, self.threads) / self.threads)
        edges = [0, *(int(cut) for cut in cuts), len(sizes)]
        return [(first + a, first + b) for a, b in pairwise(edges) if b > a]

    def run(self, operation: Callable[..., Any], parts: Sequence[tuple[Any, ...]]) -> list[Any]:
        """``operation(*part)`` for every part, side by side; returns when all are done, in the parts' order."""
        if self._pool is None or len(parts) == 1:
            return [operation(*part) for part in parts]
        others = [self._pool.submit(operation, *part) for part in parts[1:]]
        first = operation(*parts[0])
        return [first, *(other.result() for other in others)]
