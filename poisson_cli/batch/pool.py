"""Workers on this machine: processes started by spawn, each with one job at a time.

Why not `concurrent.futures`: when one process of its pool dies, all jobs that wait or run fail with it, and nothing
tells which of them was to blame. Here each worker has a pipe of its own and does one job after the other, so that a
death has one suspect: that job is tried once more, last, when whatever may have crowded it out of memory is done; if
it takes a second worker along it fails. All others go on. And a job that takes too long can be ended, with its worker.

A worker that is at a small job has the next small one in its pipe already, and need not wait until somebody has heard
that it is done. The next one has not begun, as far as anybody is concerned, before the result of the first is there.
"""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import selectors
import signal
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.context import SpawnContext
from typing import TYPE_CHECKING, Final

from poisson_cli.batch import memory
from poisson_cli.batch.task import Result, Task
from poisson_cli.batch.worker import READY, Perform, alone, deaf, serve
from poisson_cli.errors import BUG, TERMINATED, PoissonError

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

__all__ = ["ATTEMPTS", "Ahead", "run"]

ATTEMPTS: Final = 2
"""How often a job may be begun."""

_STILLBORN: Final = 3
"""Workers that may die before they have begun anything, one after the other, until something must be wrong."""

_SMALL: Final = memory.WORKER + (32 << 20)
"""Bytes, by the estimate, up to which a job takes so little time that another one may be made to wait for it."""

_PATIENCE: Final = 5.0
"""Seconds for workers to tidy up and end, before they are killed."""


def run(
    tasks: Iterable[Task],
    *,
    workers: int,
    limit: int,
    keep_going: bool = True,
    timeout: float | None = None,
    quiet: bool = True,
    begins: Callable[[Task], None] = lambda task: None,
    perform: Perform | None = None,
    ahead: Ahead | None = None,
) -> Iterator[Result]:
    """Do jobs side by side.

    Parameters
    ----------
    tasks
        What to do; begun in this order.
    workers
        Processes at most.
    limit
        Bytes that all jobs that run may need together, by their estimates.
    keep_going
        Begin further jobs after one has failed. Those that run are finished in any case.
    timeout
        Seconds after which a job has failed, and its worker is ended; None: never.
    quiet
        Compile the solver, if it has to be, in silence.
    begins
        Called with each job that begins.
    perform
        What a worker does with a task; None for `poisson_cli.batch.task.perform`.
    ahead
        Workers that were begun before, for the same `perform` and as `quiet`.

    Yields
    ------
    Result
        As they come.

    Raises
    ------
    PoissonError
        If workers cannot be started.
    """
    begun = [] if ahead is None else ahead.taken()
    pool = _Pool(tasks, begun, workers, limit, keep_going, timeout, quiet, begins, perform)
    try:
        yield from pool.results()
    finally:
        pool.close()


class Ahead:
    """Workers that get ready while it is not yet said what there is to do; a context that ends those nobody took.

    Parameters
    ----------
    workers
        How many.
    quiet
        As `run`.
    """

    def __init__(self, workers: int, *, quiet: bool) -> None:
        self._workers: list[_Worker] = []
        context = multiprocessing.get_context("spawn")
        for _ in range(workers):
            _begin(self._workers, context, None, quiet)

    def __enter__(self) -> Ahead:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self.taken():
            worker.pipe.close()
            worker.process.kill()  # it has done nothing that would have to be tidied up
            worker.process.join(_PATIENCE)

    def taken(self) -> list[_Worker]:
        """The workers, which are somebody else's from now on."""
        workers, self._workers = self._workers, []
        return workers


class _Attempt:
    """A job that waits or runs."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self.times = 1
        self.bytes = 0
        self.is_first = False  # whether no output was there when it began

    def again(self, *, times: int) -> _Attempt:
        """One more attempt; what the last one has written, and nobody else has, it may replace."""
        other = _Attempt(self.task.replacing() if self.is_first else self.task)
        other.times, other.is_first = times, self.is_first
        return other


class _Worker:
    """A worker, as the batch sees it."""

    def __init__(self, context: SpawnContext, perform: Perform | None, quiet: bool) -> None:
        self.pipe: Connection
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(
            target=serve, args=(theirs, perform, quiet), name="poisson worker", daemon=True
        )
        self.process.start()
        theirs.close()  # or this side would never hear that the other is gone
        self.is_ready = False
        self.attempts: deque[_Attempt] = deque()  # at the first one it is, a second one waits in its pipe
        self.deadline = math.inf
        self.is_stopped = False  # because its job took too long

    @property
    def bytes(self) -> int:
        """What its jobs may need; they do not run side by side."""
        return max((attempt.bytes for attempt in self.attempts), default=0)


def _begin(workers: list[_Worker], context: SpawnContext, perform: Perform | None, quiet: bool) -> _Worker:
    """Start a further worker; it is among the others before any signal is heard."""
    with deaf(), alone():
        workers.append(_Worker(context, perform, quiet))
    return workers[-1]


class _Pool:
    """The jobs that wait, and the workers."""

    def __init__(
        self,
        tasks: Iterable[Task],
        begun: list[_Worker],
        workers: int,
        limit: int,
        keep_going: bool,
        timeout: float | None,
        quiet: bool,
        begins: Callable[[Task], None],
        perform: Perform | None,
    ) -> None:
        self._waiting = deque(_Attempt(task) for task in tasks)
        self._most, self._limit = workers, limit
        self._keep_going, self._timeout = keep_going, math.inf if timeout is None else timeout
        self._quiet, self._begins, self._perform = quiet, begins, perform
        self._context = multiprocessing.get_context("spawn")
        self._estimate = memory.estimator()
        self._workers = begun
        self._listening = selectors.DefaultSelector()  # `multiprocessing.connection.wait` makes one each time
        self._stillborn = 0
        for worker in begun:
            self._listen_to(worker)

    def results(self) -> Iterator[Result]:
        """Hand out jobs and take in results until there are no more."""
        results: list[Result] = []
        while True:
            # Whoever gets the results takes his time; the workers need not wait for that.
            if not self._keep_going and any(result.status == "failed" for result in results):
                self._waiting.clear()
            refused = list(self._hand_out())
            yield from results
            yield from refused
            if not any(worker.attempts for worker in self._workers):
                return
            heard = self._listening.select(self._time_left())
            results = [result for key, _ in heard for result in self._hear(key.data)]
            results += self._stop_overdue()

    def close(self) -> None:
        """End all workers: those that wait for a job at once, the others as soon as they have tidied up."""
        for worker in self._workers:
            worker.pipe.close()
            if worker.attempts:
                worker.process.terminate()
        deadline = time.monotonic() + _PATIENCE
        for worker in self._workers:
            worker.process.join(max(0.0, deadline - time.monotonic()))
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join(_PATIENCE)  # a process that waits for a dead disk cannot be killed
            _sweep(worker)
        self._workers.clear()
        self._listening.close()

    def _listen_to(self, worker: _Worker) -> None:
        """From now on, until it is buried."""
        self._listening.register(worker.pipe, selectors.EVENT_READ, worker)

    def _hand_out(self) -> Iterator[Result]:
        """Give a job to every worker that has none, as long as memory allows.

        In their order: if smaller jobs could overtake a large one, it might wait for ever.
        """
        while self._waiting:
            attempt = self._waiting[0]
            attempt.bytes = attempt.bytes or self._estimate(attempt.task)
            if attempt.bytes > self._limit:
                self._waiting.popleft()
                if not self._keep_going:
                    self._waiting.clear()
                yield _too_large(attempt, self._limit)
                continue
            worker = self._worker_for(attempt)
            if worker is None:
                return
            self._waiting.popleft()
            worker.attempts.append(attempt)
            if attempt.times == 1:
                attempt.is_first = not attempt.task.is_begun()
            # A worker that died while it had nothing to do is noticed when it is listened to.
            with contextlib.suppress(OSError):
                worker.pipe.send((attempt.task, attempt.times))
            if len(worker.attempts) == 1:
                self._begin_first(worker)

    def _worker_for(self, attempt: _Attempt) -> _Worker | None:
        """One that has nothing to do, a new one if there may be more, one that will soon be done, or None."""
        used = sum(worker.bytes for worker in self._workers)
        if used + attempt.bytes <= self._limit:
            for worker in self._workers:
                if not worker.attempts:
                    return worker
            if len(self._workers) < self._most:
                worker = _begin(self._workers, self._context, self._perform, self._quiet)
                self._listen_to(worker)
                return worker
        if not self._keep_going or attempt.bytes > _SMALL or attempt.times > 1:
            return None
        for worker in self._workers:
            soon = len(worker.attempts) == 1 and worker.bytes <= _SMALL and not worker.is_stopped
            if soon and used + max(0, attempt.bytes - worker.bytes) <= self._limit:
                return worker
        return None

    def _begin_first(self, worker: _Worker) -> None:
        """Say that a worker begins the first of its jobs, and from when on its time counts."""
        if worker.is_ready:
            worker.deadline = time.monotonic() + self._timeout
        self._begins(worker.attempts[0].task)

    def _hear(self, worker: _Worker) -> Iterator[Result]:
        """Take in what a worker says, or that it says no more."""
        try:
            message = worker.pipe.recv()
        except (EOFError, OSError):
            yield from self._bury(worker)
            return
        if message == READY:
            worker.is_ready = True
            if worker.attempts:
                worker.deadline = time.monotonic() + self._timeout  # what it took to get ready does not count
            self._stillborn = 0
        else:
            assert isinstance(message, Result)
            worker.attempts.popleft()
            worker.deadline = math.inf
            if worker.is_stopped:  # just when its job was done: it is to do no other one
                yield from self._bury(worker, suspect=False)
            elif worker.attempts:
                self._begin_first(worker)
            yield message

    def _time_left(self) -> float | None:
        """Seconds until the first job will have taken too long; None if none ever will."""
        first = min(worker.deadline for worker in self._workers)
        return None if math.isinf(first) else max(0.0, first - time.monotonic())

    def _stop_overdue(self) -> Iterator[Result]:
        """Ask workers to end whose jobs take too long; then see to it; then do without them."""
        now = time.monotonic()
        for worker in [worker for worker in self._workers if now >= worker.deadline]:
            if not worker.is_stopped:
                worker.is_stopped = True
                worker.process.terminate()
                worker.deadline = now + _PATIENCE
            else:
                worker.process.kill()
                yield from self._bury(worker)

    def _bury(self, worker: _Worker, *, suspect: bool = True) -> Iterator[Result]:
        """See to the jobs of a worker that is dead; the first of them may be why."""
        self._workers.remove(worker)
        self._listening.unregister(worker.pipe)
        worker.pipe.close()
        worker.process.join(_PATIENCE)
        code = worker.process.exitcode
        _sweep(worker)
        attempt = worker.attempts.popleft() if suspect and worker.attempts else None
        while worker.attempts:  # for somebody else to do; should one have begun after all, it begins anew
            other = worker.attempts.pop()
            self._waiting.appendleft(other.again(times=other.times))
        if attempt is None:
            return
        if worker.is_stopped:
            yield _too_long(attempt, self._timeout)
        elif not worker.is_ready:
            self._stillborn += 1
            if self._stillborn >= _STILLBORN:
                raise PoissonError(
                    f"{self._stillborn} worker processes in a row {_end(code)} before they could begin; "
                    "run one of the jobs by itself to see why"
                )
            self._waiting.appendleft(attempt)
        elif attempt.times < ATTEMPTS:
            self._waiting.append(attempt.again(times=attempt.times + 1))
        else:
            yield _deadly(attempt, code)


def _too_large(attempt: _Attempt, limit: int) -> Result:
    need = memory.said(attempt.bytes)
    return Result.of(
        attempt.task,
        "failed",
        exit_code=BUG,
        error=f"may need {need} of memory, and all jobs together have {memory.said(limit)}; "
        f"--memory {need.replace(' ', '')} lets it run",
        attempts=0,
    )


def _too_long(attempt: _Attempt, timeout: float) -> Result:
    return Result.of(
        attempt.task,
        "failed",
        exit_code=TERMINATED,
        error=f"took longer than {timeout:g} s and was ended; --timeout says how long a job may take",
        seconds=timeout,
        attempts=attempt.times,
    )


def _deadly(attempt: _Attempt, code: int | None) -> Result:
    """The result of a job that has cost as many workers as it may."""
    return Result.of(
        attempt.task,
        "failed",
        exit_code=BUG if code is None or code == 0 else code if code > 0 else 128 - code,
        error=f"its process {_end(code)}, {attempt.times} times; perhaps there was not enough memory",
        attempts=attempt.times,
    )


def _end(code: int | None) -> str:
    """How a process ended."""
    if code is None:
        return "hung up"
    if code >= 0:
        return f"ended with exit code {code}"
    with contextlib.suppress(ValueError):
        return f"was killed by {signal.Signals(-code).name}"
    return f"was killed by signal {-code}"


def _sweep(worker: _Worker) -> None:
    """Remove what a dead worker was writing; the names tell whose it was (see `poisson_cli.images.writing`)."""
    outputs = [path for attempt in worker.attempts for path in attempt.task.outputs]
    for folder in {path.resolve().parent for path in outputs}:
        with contextlib.suppress(OSError):
            for rest in folder.glob(f".poisson-{worker.process.pid}-*"):
                rest.unlink(missing_ok=True)
