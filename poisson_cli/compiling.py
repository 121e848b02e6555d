"""What the command line says when the solver's kernels have to be compiled: once, on the first run."""

from __future__ import annotations

import contextlib
import sys

__all__ = ["announce"]


def announce(*, quiet: bool) -> None:
    """Let the solver say on stderr that it compiles, and use the processor's other cores for it.

    Parameters
    ----------
    quiet
        Compile in silence.
    """
    from solvers.kernels.policy import library

    library.helpers = True
    library.listener = None if quiet else _say


def _say(volume: str, seconds: float | None) -> None:
    what = "for this machine" if volume == "usual" else "for selections or pictures of this kind"
    text = (
        f"compiling the solver {what}; this is done once"
        if seconds is None
        else f"compiled in {seconds:.1f} s"
    )
    with contextlib.suppress(OSError):  # nobody listens
        print(f"poisson: {text}", file=sys.stderr, flush=True)
