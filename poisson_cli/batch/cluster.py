"""Workers on a Dask cluster: the same tasks, the same results.

The cluster needs this package on every worker, and files under the same paths on all machines. A task travels as the
plain data that it is; what comes back is its result, never a picture.

What Dask sees to: a task whose worker is lost is given to another one, so many times as the scheduler's setting
``distributed.scheduler.allowed-failures`` says. What is seen to here: only so many tasks are submitted at a time as
keep the workers busy, because a scheduler that holds a million of them is slow; a task that is begun again, even
though it had been finished when its worker was lost, does no harm; and a task that takes its workers along fails alone.
"""

from __future__ import annotations

import dataclasses
import logging
import pickle
import time
import uuid
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Any, Final

from poisson_cli import interrupts
from poisson_cli.batch.task import Result, Task, perform
from poisson_cli.batch.worker import alone, deaf
from poisson_cli.errors import BUG, InputError, PoissonError

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["LOCAL", "run"]

LOCAL: Final = "local"
"""Instead of an address: start a cluster on this machine."""

_AHEAD: Final = 2
"""Tasks submitted for each that can run, so that no worker waits for the next one to be sent."""

_COUNTED: Final = 1.0
"""Seconds for which the number of workers is taken to be the same: to ask takes as long as to submit several tasks."""

_EVERYTHING: Final = "all"
"""The topic under which a scheduler tells which workers it has lost."""

_NAP: Final = 0.02
"""Seconds between two looks for results."""

_TIMEOUT: Final = 30.0
"""Seconds to wait for the scheduler, and for the first worker."""


def run(
    tasks: Sequence[Task],
    scheduler: str,
    *,
    at_a_time: int | None = None,
    keep_going: bool = True,
    begins: Callable[[Task], None] = lambda task: None,
) -> Iterator[Result]:
    """Do jobs on a cluster.

    Parameters
    ----------
    tasks
        What to do; their paths must mean the same on every worker.
    scheduler
        Address, or `LOCAL`.
    at_a_time
        Jobs submitted at most; of a cluster on this machine, processes. None: as many as keep all workers busy.
    keep_going
        Submit further jobs after one has failed.
    begins
        Called with each job that is submitted.

    Yields
    ------
    Result
        As they come.

    Raises
    ------
    InputError
        If Dask is not installed, or the scheduler cannot be reached or has no workers.
    """
    try:
        import distributed
    except ImportError as error:
        raise InputError("a cluster needs Dask: pip install 'poisson-cli[cluster]'") from error
    # What happens to workers is told in the report; its own lines would break the progress line.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with interrupts.hushed(), ExitStack() as stack:
        client = stack.enter_context(_connected(scheduler, at_a_time, stack))
        limit = at_a_time if scheduler != LOCAL else None
        submission = _Submission(distributed, client, tasks, limit, begins)
        stack.callback(submission.cancel)
        yield from submission.results(keep_going)


def _connected(scheduler: str, processes: int | None, stack: ExitStack) -> Client:
    """A connection to a scheduler that has workers."""
    import dask
    import distributed

    try:
        if scheduler == LOCAL:
            from poisson_cli.batch.running import cores

            # A process that is half awake would complain about a Ctrl-C.
            with dask.config.set({"distributed.scheduler.allowed-failures": 0}), deaf(), alone():
                cluster = stack.enter_context(
                    distributed.LocalCluster(
                        n_workers=processes or cores(),
                        threads_per_worker=1,
                        dashboard_address=None,
                        # Its HTTP server comes all the same, at a port that a second batch would find taken.
                        scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
                        silence_logs=logging.CRITICAL,
                        preload="poisson_cli.batch.undisturbed",
                    )
                )
            client = distributed.Client(cluster, timeout=_TIMEOUT, set_as_default=False)
        else:
            client = distributed.Client(scheduler, timeout=_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{scheduler}: this scheduler cannot be reached ({reason})") from error
    try:
        client.wait_for_workers(1, timeout=_TIMEOUT)
    except TimeoutError as error:
        client.close()
        raise InputError(f"{scheduler}: this scheduler has no workers; start some") from error
    return client


class _Submission:
    """The tasks that wait here, and those that the scheduler has."""

    def __init__(
        self,
        distributed: Any,
        client: Client,
        tasks: Sequence[Task],
        limit: int | None,
        begins: Callable[[Task], None],
    ) -> None:
        self._distributed, self._client, self._begins = distributed, client, begins
        self._waiting = deque(tasks)
        self._suspects: deque[Task] = deque()
        self._begun: Counter[int] = Counter()  # how often each job was, before it was sent for the last time
        self._limit = limit
        self._threads, self._count_again = 1, 0.0
        self._has_lost_workers = False
        client.subscribe_topic(_EVERYTHING, self._hear)
        self._batch = uuid.uuid4().hex
        self._submitted: dict[Any, Task] = {}
        self._completed = distributed.as_completed(loop=client.loop, with_results=True, raise_errors=False)

    def results(self, keep_going: bool) -> Iterator[Result]:
        """Submit tasks and take in results until there are no more."""
        while True:
            self._submit()
            if not self._submitted:
                return
            while not self._completed.has_ready():
                interrupts.check()  # it may have come in a destructor of Dask's, of which there are many
                time.sleep(_NAP)
            pairs = self._completed.next_batch(block=False)
            lost = self._times_lost([future for future, _ in pairs])
            for future, value in pairs:
                result = self._result(future, value, 1 + lost.get(future.key, 0))
                del self._submitted[future]
                if result is None:
                    continue
                if result.status == "failed" and not keep_going:
                    self._waiting.clear()
                    self._suspects.clear()
                yield result

    def cancel(self) -> None:
        """Take back what has not begun; what has is finished, whole, on its worker."""
        with suppress(OSError, TimeoutError):
            self._client.unsubscribe_topic(_EVERYTHING)
            if self._submitted:
                self._client.cancel(list(self._submitted), reason="the batch has ended")

    def _submit(self) -> None:
        if self._waiting:
            limit = self._limit or _AHEAD * self._count_threads()
            while self._waiting and len(self._submitted) < limit:
                self._send(self._waiting.popleft())
        elif self._suspects and not self._submitted:
            self._send(self._suspects.popleft())

    def _count_threads(self) -> int:
        """How many tasks can run at a time: asked again and again, because workers come and go."""
        now = time.monotonic()
        if now >= self._count_again:
            self._threads = max(1, sum(self._client.nthreads().values()))
            self._count_again = now + _COUNTED
        return self._threads

    def _hear(self, event: tuple[float, Any]) -> None:
        """Take note of what the scheduler tells everybody, on a thread of the client's."""
        _, told = event
        if isinstance(told, dict) and told.get("action") == "remove-worker":
            self._has_lost_workers = True

    def _send(self, task: Task) -> None:
        # What is begun again, because a worker was lost, meets outputs of its own: it may replace them, and anybody
        # else's only if they were not there before.
        if not self._begun[task.number] and not task.is_begun():
            task = task.replacing()
        key = f"poisson-{self._batch}-{task.number}-{self._begun[task.number]}"
        future = self._client.submit(_perform, pickle.dumps(task), key=key, pure=False)
        self._submitted[future] = task
        self._completed.add(future)
        self._begins(task)

    def _result(self, future: Any, value: Any, attempts: int) -> Result | None:
        """What became of a task; None if it is to be tried again.

        Parameters
        ----------
        future
            The task, as Dask has it.
        value
            What `_perform` returned; or a `CancelledError`; or the type, the value and the traceback of what it raised.
        attempts
            How often it was begun since it was submitted.
        """
        task = self._submitted[future]
        before = self._begun[task.number]
        if isinstance(value, Result):
            return dataclasses.replace(value, attempts=before + attempts)
        error = value if isinstance(value, CancelledError) else value[1]
        if isinstance(error, CancelledError):
            raise PoissonError("the scheduler is gone, or has cancelled the batch; run it again") from error
        if not isinstance(error, self._distributed.KilledWorker):
            raise PoissonError(
                f"the cluster cannot do jobs ({type(error).__name__}: {error}); it needs this version of poisson-cli "
                "on the scheduler and on every worker"
            ) from error
        # Dask blames every task that the lost worker had, those that had not begun as well. So all of them are tried
        # again, each with nothing beside it, which shows who is to blame.
        times = before + error.allowed_failures + 1
        if not before:
            self._begun[task.number] = times
            self._suspects.append(task)
            return None
        return Result.of(
            task,
            "failed",
            exit_code=BUG,
            error=f"its worker was lost, {times} times; perhaps there was not enough memory",
            attempts=times,
        )

    def _times_lost(self, futures: Sequence[Any]) -> dict[str, int]:
        """How many workers were lost with each task: only the scheduler knows."""
        if not self._has_lost_workers:
            return {}
        lost: dict[str, int] = self._client.run_on_scheduler(
            _suspicions, keys=[future.key for future in futures]
        )
        return lost


def _perform(task: bytes) -> Result:
    """Do a job on a worker. The task is packed, so that no part of Dask looks into it for what it knows."""
    return perform(pickle.loads(task))


def _suspicions(keys: Sequence[str], dask_scheduler: Any = None) -> dict[str, int]:
    """What the scheduler counts for tasks that were running when their worker was lost."""
    found = ((key, dask_scheduler.tasks.get(key)) for key in keys)
    return {key: task.suspicious for key, task in found if task is not None}
