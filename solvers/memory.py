"""Work memory that outlives a solve.

A fresh array costs a page fault per 4 KiB when it is first written, which for a region of 60,000 pixels is a fifth of
the whole solve.  Someone who edits many pictures gives the same memory back and takes it again.
"""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from solvers.layout import Float32, aligned_zeros

KEPT = 1 << 24  # float32 values, 64 MiB: what a thread holds on to between solves


class Arena:
    """Hands out zeroed arrays; what is taken back is handed out again, at once or in a later round."""

    def __init__(self) -> None:
        self._lent: list[Float32] = []
        self._idle: list[Float32] = []

    def zeros(self, size: int) -> Float32:
        """`size` float32 zeros that begin on a cache line."""
        fitting = [at for at, block in enumerate(self._idle) if block.size >= size]
        if fitting:
            block = self._idle.pop(min(fitting, key=lambda at: self._idle[at].size))
            block[:size] = 0
        else:
            block = aligned_zeros(size)
        self._lent.append(block)
        return block[:size]

    def reclaim(self) -> None:
        """Takes back what nobody looks at any more: scratch of a first step, before the next one asks for memory."""
        # A block is a view, and so is every array made of it; all of them refer to the owner of the memory, and nobody
        # else does.  The block, and the call that counts, make two.
        unused = [sys.getrefcount(block.base) <= 2 for block in self._lent]
        self._idle += [block for block, free in zip(self._lent, unused, strict=True) if free]
        self._lent = [block for block, free in zip(self._lent, unused, strict=True) if not free]
        self._forget_what_is_large()

    def rewind(self) -> None:
        """Everything handed out may be handed out again."""
        self._idle += self._lent
        self._lent = []
        self._forget_what_is_large()

    def _forget_what_is_large(self) -> None:
        """Back to the system with it."""
        if sum(block.size for block in self._idle) > KEPT:
            self._idle.clear()


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
