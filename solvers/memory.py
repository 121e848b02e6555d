"""Work memory that outlives a solve.

A fresh array costs a page fault per 4 KiB when it is first written, which for a region of 60,000 pixels is a fifth of
the whole solve.  Someone who edits many pictures gives the same memory back and takes it again.
"""

import itertools
import math
import sys
import threading
from bisect import bisect_left
from collections.abc import Iterator
from contextlib import contextmanager
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from solvers.layout import Float32, aligned_zeros

KEPT = 1 << 24  # float32 values, 64 MiB: what a thread holds on to between solves


class Arena:
    """Hands out arrays; what is taken back is handed out again, at once or in a later round."""

    def __init__(self) -> None:
        self._lent: list[Float32] = []
        self._idle: list[Float32] = []  # by size,
        self._sizes: list[int] = []  # and what these are

    def zeros(self, size: int) -> Float32:
        """`size` float32 zeros that begin on a cache line; memory that is new is not touched."""
        used = self._idle_block(size)
        if used is None:
            return self._lend(aligned_zeros(size), size)
        used[:size].view(np.uint8).fill(0)  # byte by byte is twice as fast: numpy then leaves it to memset
        return self._lend(used, size)

    def zeros_each(self, *sizes: int) -> list[Float32]:
        """Arrays of zeros that live equally long; the sizes are multiples of `LANES`, so that each begins on a line."""
        whole = self.zeros(sum(sizes))
        ends = itertools.accumulate(sizes)
        return [whole[end - size : end] for size, end in zip(sizes, ends, strict=True)]

    def floats(self, size: int) -> Float32:
        """`size` float32 that begin on a cache line, no matter which."""
        return self._anything(size)

    def integers(self, *shape: int) -> NDArray[np.int32]:
        """An array of int32, no matter which."""
        return self._anything(math.prod(shape)).view(np.int32).reshape(shape)

    def longs(self, *shape: int) -> NDArray[np.int64]:
        """An array of int64, no matter which."""
        return self._anything(2 * math.prod(shape)).view(np.int64).reshape(shape)

    def doubles(self, *shape: int) -> NDArray[np.float64]:
        """An array of float64, no matter which."""
        return self._anything(2 * math.prod(shape)).view(np.float64).reshape(shape)

    def _anything(self, size: int) -> Float32:
        used = self._idle_block(size)
        return self._lend(aligned_zeros(size) if used is None else used, size)

    def _idle_block(self, size: int) -> Float32 | None:
        """The smallest one that is large enough."""
        at = bisect_left(self._sizes, size)
        if at == len(self._sizes):
            return None
        del self._sizes[at]
        return self._idle.pop(at)

    def _lend(self, block: Float32, size: int) -> Float32:
        self._lent.append(block)
        return block[:size]

    def reclaim(self) -> None:
        """Takes back what nobody looks at any more: scratch of a first step, before the next one asks for memory."""
        # A block is a view, and so is every array made of it; all of them refer to the owner of the memory, and nobody
        # else does.  The block, and the call that counts, make two.
        unused = [sys.getrefcount(block.base) <= 2 for block in self._lent]
        self._take_back([block for block, free in zip(self._lent, unused, strict=True) if free])
        self._lent = [block for block, free in zip(self._lent, unused, strict=True) if not free]

    def rewind(self) -> None:
        """Everything handed out may be handed out again."""
        self._take_back(self._lent)
        self._lent = []

    def _take_back(self, blocks: list[Float32]) -> None:
        """Blocks that may be handed out again; if there is very much of them, all goes back to the system."""
        self._idle = sorted([*self._idle, *blocks], key=attrgetter("size"))
        self._sizes = [block.size for block in self._idle]
        if sum(self._sizes) > KEPT:
            self._idle, self._sizes = [], []


class _PerThread(threading.local):
    def __init__(self) -> None:
        self.idle: Arena | None = None


_per_thread = _PerThread()


@contextmanager
def borrowed_arena() -> Iterator[Arena]:
    """The arena of this thread; what it handed out is no longer yours when the context ends."""
    arena, _per_thread.idle = _per_thread.idle or Arena(), None  # a solve within a solve gets another one
    try:
        yield arena
    finally:
        arena.rewind()
        _per_thread.idle = arena
