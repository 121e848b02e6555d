"""Standard streams that nobody reads any more."""

from __future__ import annotations

import os
from typing import TextIO

__all__ = ["silence"]


def silence(stream: TextIO) -> None:
    """Let all that a stream still holds, and all that it gets from now on, go nowhere.

    After a broken pipe the unread text stays in the stream, and every later flush, the interpreter's last one
    included, would fail again.

    Parameters
    ----------
    stream
        One with a file descriptor, such as ``sys.stdout``.
    """
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
