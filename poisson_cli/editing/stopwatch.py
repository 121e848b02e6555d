"""How long something took that several threads do side by side."""

import threading
from time import perf_counter
from types import TracebackType


class Stopwatch:
    """A context; the time during which at least one thread is inside it counts, once.

    Attributes
    ----------
    seconds : float
        So far.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._inside = 0
        self._since = 0.0
        self._lock = threading.Lock()

    def __enter__(self) -> "Stopwatch":
        with self._lock:
            if self._inside == 0:
                self._since = perf_counter()
            self._inside += 1
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                self.seconds += perf_counter() - self._since
