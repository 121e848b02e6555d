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

A batch adds one meaning to 1: some of its jobs failed; the results of the others are kept.
"""

from __future__ import annotations

from typing import ClassVar, Final

__all__ = [
    "BROKEN_PIPE",
    "BUG",
    "DONE",
    "HUNG_UP",
    "INTERRUPTED",
    "TERMINATED",
    "USAGE",
    "InputError",
    "NotConverged",
    "OutputError",
    "PoissonError",
]

DONE: Final = 0
BUG: Final = 1
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
