"""Work memory that outlives a solve.

A fresh array costs a page fault per 4 KiB when it is first written, which for a region of 60,000 pixels is a fifth of
the whole solve.  Someone who edits many pictures gives the same memory back and takes it again.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from solvers.layout import Float32, aligned_zeros

KEPT = 1 << 24  # float32 values, 64 MiB: what a thread holds on to between solves


class Arena:
    """Hands out zeroed arrays, in later rounds the same memory in the same order."""

    def __init__(self) -> None:
        self._blocks: list[Float32] = []
        self._used = 0

    def zeros(self, size: int) -> Float32:
        """`size` float32 zeros that begin on a cache line."""
        if self._used == len(self._blocks):
            self._blocks.append(aligned_zeros(size))
            fresh = True
        else:
            fresh = self._blocks[self._used].size < size
            if fresh:
                self._blocks[self._used] = aligned_zeros(size)
        block = self._blocks[self._used][:size]
        self._used += 1
        if not fresh:
            block[:] = 0
        return block

    def rewind(self) -> None:
        """Everything handed out may be handed out again."""
        del self._blocks[self._used :]
        self._used = 0
        if sum(block.size for block in self._blocks) > KEPT:
            self._blocks.clear()


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
