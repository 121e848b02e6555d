"""Standard streams: their name on the command line, what is fit to be printed, and when nobody reads any more."""

from __future__ import annotations

import os
import stat
import sys
from typing import TYPE_CHECKING, Final, TextIO

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["STANDARD", "complete", "is_standard_output", "missing", "printable", "silence"]

STANDARD: Final = "-"
"""Path that stands for the standard input or output; a file of that name is given by its whole path."""


def is_standard_output(path: Path) -> bool:
    """Whether a path stands for the standard output: ``-``, or a name of it such as ``/dev/stdout``.

    Opened by such a name, a file is written from its beginning, over what others have written there.
    """
    if str(path) == STANDARD:
        return True
    if not str(path).startswith(("/dev/", "/proc/")):
        return False
    folder = os.path.realpath(path.parent)
    if folder not in ("/dev", "/dev/fd") and not (folder.startswith("/proc/") and folder.endswith("/fd")):
        return False
    try:
        there = path.stat()
        return not stat.S_ISCHR(there.st_mode) and os.path.samestat(there, os.fstat(1))
    except OSError:  # there is no such name, or no standard output
        return False


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
