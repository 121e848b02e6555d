"""Standard streams: their name on the command line, what is fit to be printed, and when nobody reads any more."""

from __future__ import annotations

import os
import sys
from typing import Final, TextIO

__all__ = ["STANDARD", "complete", "missing", "printable", "silence"]

STANDARD: Final = "-"
"""Path that stands for the standard input or output; a file of that name is given by its whole path."""


def complete() -> None:
    """Put /dev/null where a standard stream was closed.

    Otherwise the next file that is opened would get its number, and whatever is printed by number would go into it;
    and there would be no stream to print to at all.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            # It gets the lowest number that is free, and that is the stream's, taken in this order.
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115


def missing(stream: TextIO | None) -> bool:
    """Whether a standard stream was closed when the process began."""
    return stream is None or stream.closed or getattr(stream, "name", None) == os.devnull


def printable(text: str) -> str:
    r"""A text in one line that does nothing but be read.

    File names may hold line breaks, the commands of terminals, and bytes that are no characters.

    Parameters
    ----------
    text
        Any text.

    Returns
    -------
    str
        With escapes such as ``\\n`` and ``\\x1b`` for what cannot be printed.

    Examples
    --------
    >>> print(printable("a\x1b[2Jb\udcff.png"))
    a\x1b[2Jb\xff.png
    """
    return "".join(c if c.isprintable() else _escaped(c) for c in text)


def _escaped(character: str) -> str:
    if "\udc80" <= character <= "\udcff":  # a byte of a file name that is no character
        return f"\\x{ord(character) - 0xDC00:02x}"
    return character.encode("unicode_escape").decode("ascii")


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
