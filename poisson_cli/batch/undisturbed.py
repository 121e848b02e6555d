"""What a Dask worker on this machine loads first: a Ctrl-C at the terminal is for the batch, which ends the worker."""

from __future__ import annotations

import signal
from typing import Any

from poisson_cli import interrupts

__all__ = ["dask_setup"]


def dask_setup(worker: Any) -> None:
    """Called by Dask, on the main thread of a worker's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    interrupts.let_in()
