"""A worker: a process that does one job after the other for a batch, with the compiled solver loaded once.

Nothing heavy is imported at the top, because a new process imports this module before it can say anything.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from types import FrameType, ModuleType
from typing import TYPE_CHECKING, Any, Final

from poisson_cli import errors, interrupts

if TYPE_CHECKING:
    from poisson_cli.batch.task import Result, Task

__all__ = ["READY", "Perform", "alone", "deaf", "serve"]

Perform = Callable[["Task", int], "Result"]
"""Does a job, begun so many times; must be importable by name, as a new process has to find it."""

READY: Final = "ready"
"""The first message of a worker."""

_KEPT: Final = 64 << 20
"""Bytes that a worker may hold on to between jobs."""

_PATIENCE: Final = 3.0
"""Seconds that a worker has to tidy up when the batch is gone."""


@contextlib.contextmanager
def deaf() -> Iterator[None]:
    """Hear of no signal before the end, and let a process that is started meanwhile hear of none before `serve`.

    Half a start would leave a process that complains about it; a process that is half awake would complain as well.
    """
    if os.name == "posix":
        from multiprocessing import resource_tracker

        resource_tracker.ensure_running()  # comes with the first process, and would let signals in when it does
    with interrupts.held():
        yield


@contextlib.contextmanager
def alone() -> Iterator[None]:
    """Let processes that are started meanwhile not import the program that starts them.

    By default they do, to find what may be defined there. A worker looks for nothing there: so a script needs no
    ``if __name__ == "__main__":``, may come from standard input, and costs its imports once.
    """
    program = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = program


def serve(pipe: Connection, perform: Perform | None, quiet: bool) -> None:
    """Be a worker until nobody has anything to do any more.

    Parameters
    ----------
    pipe
        Brings (task, attempts), takes results.
    perform
        What is done with a task; None for `poisson_cli.batch.task.perform`.
    quiet
        Compile the solver, if it has to be, in silence.
    """
    code = errors.BUG  # if something else ends this
    try:
        # A Ctrl-C at the terminal, or its end, reaches every process there; what becomes of it the batch has to say.
        for name in ("SIGINT", "SIGHUP"):
            if hasattr(signal, name):
                signal.signal(getattr(signal, name), signal.SIG_IGN)
        signal.signal(signal.SIGTERM, _stop)
        interrupts.let_in()
        threading.Thread(target=_end_with_the_batch, name="end with the batch", daemon=True).start()
        # Read when numpy is loaded; jobs are what runs in parallel.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        _keep_memory()
        do = _the_usual(quiet) if perform is None else perform
        pipe.send(READY)
        while True:
            task, attempts = pipe.recv()
            with _to_be_tidied_up():
                result = do(task, attempts)
            pipe.send(result)
    except (EOFError, ConnectionError):
        code = errors.DONE
    except errors.Terminated:
        code = errors.TERMINATED
    finally:
        try:
            os._exit(code)  # at once: nothing is left to tidy up
        finally:
            os._exit(code)  # even if a signal, of which only the first is heard, comes just now


def _keep_memory() -> None:
    """Have the C library keep memory that a job frees, up to `_KEPT` bytes, for the next one.

    It would give it back and ask for it again, several times a job, and each page that comes is one of zeros: without
    that a job on small pictures takes a tenth less.
    """
    import ctypes

    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError, TypeError):
        return  # a system without GNU's C library has its own ways
    trim_threshold, mmap_threshold = -1, -3  # as <malloc.h> has them
    mallopt(mmap_threshold, _KEPT // 2)
    mallopt(trim_threshold, _KEPT)


def _the_usual(quiet: bool) -> Perform:
    """Load all that jobs need, the compiled solver as well, before the first of them."""
    from poisson_cli import answering, compiling
    from poisson_cli.batch.task import perform
    from poisson_cli.images.writing import settle_later
    from solvers.kernels.policy import library

    answering.be_patient()
    settle_later()
    compiling.announce(quiet=quiet)
    with _to_be_tidied_up():
        library.addresses("usual")
    return perform


_at_work = threading.Event()
"""Set while something would be left half done if the process just ended."""


@contextlib.contextmanager
def _to_be_tidied_up() -> Iterator[None]:
    _at_work.set()
    try:
        yield
    finally:
        _at_work.clear()


def _stop(_signal: int, _frame: FrameType | None) -> Any:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)  # once is enough: what tidies up is not to be interrupted
    if not _at_work.is_set():
        # An exception would be complained about if it came in a place where none is expected, such as an import.
        os._exit(errors.TERMINATED)
    raise errors.Terminated


def _end_with_the_batch() -> None:
    """Wait until the batch is gone, however it went, and end this process as well, its current job unfinished."""
    import multiprocessing

    batch = multiprocessing.parent_process()
    assert batch is not None
    batch.join()
    os.kill(os.getpid(), signal.SIGTERM)  # heard by the main thread, which tidies up
    time.sleep(_PATIENCE)
    os._exit(errors.TERMINATED)
