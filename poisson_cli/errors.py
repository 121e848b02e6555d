"""The exceptions of this package and the exit code that each of them becomes.

Nothing else decides an exit code:

====  ==========================================================================
code  meaning
====  ==========================================================================
0     done; the only code that comes with a new output file
1     a bug, or an exception that nobody foresaw
2     usage: the command line itself is wrong (click's ``UsageError``)
3     `InputError`: an input cannot be read, or makes no sense
4     `OutputError`: the output cannot be written
5     `NotConverged`: the iterations ran out before the tolerance was reached
129   the terminal hung up (SIGHUP)
130   interrupted from the keyboard (SIGINT)
141   whoever read our output stopped listening (SIGPIPE)
143   asked to stop (SIGTERM)
====  ==========================================================================

A batch adds one meaning to 1: some of its jobs failed; the results of the others are kept. It has 2 for a list that
makes no sense, too.
"""

from __future__ import annotations

from typing import ClassVar, Final

__all__ = [
    "BROKEN_PIPE",
    "BUG",
    "DONE",
    "HUNG_UP",
    "INTERRUPTED",
    "SOME_FAILED",
    "TERMINATED",
    "USAGE",
    "HungUp",
    "InputError",
    "NotConverged",
    "OutputError",
    "PoissonError",
    "Terminated",
    "code_of",
    "verdict",
]

DONE: Final = 0
BUG: Final = 1
SOME_FAILED: Final = 1
USAGE: Final = 2
HUNG_UP: Final = 129
INTERRUPTED: Final = 130
BROKEN_PIPE: Final = 141
TERMINATED: Final = 143


class PoissonError(Exception):
    """Something the user can mend; the message says what to do."""

    exit_code: ClassVar[int] = BUG


class InputError(PoissonError, ValueError):
    """An input cannot be read, or the inputs make no sense together."""

    exit_code = 3


class OutputError(PoissonError):
    """The output cannot be written; whatever was there before is still there."""

    exit_code = 4


class NotConverged(PoissonError):
    """The solver stopped before the estimated error fell below the tolerance."""

    exit_code = 5


class Terminated(BaseException):
    """SIGTERM arrived. Like `KeyboardInterrupt`, it passes every ``except Exception`` and runs every ``finally``."""


class HungUp(BaseException):
    """SIGHUP arrived: the terminal is gone."""


def code_of(error: BaseException) -> int:
    """The exit code of whatever ends a run, signals included."""
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    if isinstance(error, Terminated):
        return TERMINATED
    if isinstance(error, HungUp):
        return HUNG_UP
    return verdict(error)[0] if isinstance(error, Exception) else BUG


def verdict(error: Exception) -> tuple[int, str]:
    """What becomes of an exception that ends a command, or a job of a batch.

    Returns
    -------
    code : int
        The exit code.
    message : str
        What is said of it, in one line whatever line breaks the exception has.
    """
    if isinstance(error, PoissonError):
        code, message = error.exit_code, str(error)
    elif isinstance(error, MemoryError):
        code, message = BUG, "not enough memory for pictures of this size"
    else:
        code, message = BUG, f"unexpected {type(error).__name__}: {error}; this is a bug"
    return code, " ".join(message.split())
