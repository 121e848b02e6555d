"""What the command line says when the solver's kernels have to be compiled: once, on the first run."""

from __future__ import annotations

import contextlib
import functools
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solvers.native import Library

__all__ = ["announce", "unkept"]


def announce(*, quiet: bool) -> None:
    """Let the solver say on stderr that it compiles, and use the processor's other cores for it.

    Parameters
    ----------
    quiet
        Compile in silence.

    Raises
    ------
    InputError
        If ``POISSON_KERNELS`` asks for something else than there is.
    """
    from poisson_cli.errors import InputError
    from solvers.kernels.policy import library
    from solvers.native.library import mode

    try:
        mode()
    except ValueError as error:
        raise InputError(str(error)) from error
    library.helpers = True
    library.listener = None if quiet else functools.partial(_say, library)


def unkept(reason: str) -> str:
    """What to say where the compiled solver cannot be kept."""
    return f"for it cannot be kept ({reason}); name another folder in POISSON_CACHE_DIR"


def _say(library: Library, volume: str, seconds: float | None) -> None:
    """Before compiling, and once more with the seconds that it took."""
    what = "for this machine" if volume == "usual" else "for selections or pictures of this kind"
    if seconds is None:
        again = (
            "this is done once"
            if library.unkept is None
            else f"again at the next run, {unkept(library.unkept)}"
        )
        text = f"compiling the solver {what}; {again}"
    elif library.trouble is None:
        text = f"compiled in {seconds:.1f} s"
    else:
        text = f"that failed after {seconds:.1f} s ({library.trouble}); numba does it, and each run begins more slowly"
    with contextlib.suppress(OSError):  # nobody listens
        print(f"poisson: {text}", file=sys.stderr, flush=True)
