"""Memory asked for ahead of time, from within a kernel.

A processor guesses what is read next where one thing lies behind the other.  Unknowns that are scattered over a picture
do not: each is waited for, longer than what is done with it takes.  But their places are known well before.
"""

from typing import Any


def prefetch(array: Any, index: Any) -> None:
    """A hint that this element of a flat array is going to be read; see `prefetching` for what compiled code does.

    Any index will do: nothing is read, and nothing happens where there is no such memory.
    """
