"""The progress line: what it says, when, where, and that nothing is left of it."""

import io
import math
import os
import pty
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from poisson_cli import progress
from poisson_cli.images import Picture, prepare, write
from poisson_cli.settings import Reporting, Solver
from tests.test_cli_process import POISSON, environment, heard_signals

__all__ = ["environment", "heard_signals"]


class Watch:
    """A clock that is set by hand."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True

    def shown(self) -> str:
        """What a terminal shows of it: carriage returns write over what is there."""
        line: list[str] = []
        for part in self.getvalue().split("\r"):
            line[: len(part)] = part
        return "".join(line).rstrip()


@pytest.fixture
def watch() -> Watch:
    return Watch()


@pytest.fixture
def terminal() -> Terminal:
    return Terminal()


@pytest.fixture
def line(terminal: Terminal, watch: Watch) -> progress.Line:
    return progress.Line(terminal, "cycle", 1e-3, watch)


def test_what_takes_no_time_says_nothing(line, terminal, watch):
    line(1, 10.0)
    watch.now += 0.4
    line(2, 1.0)
    line.close()
    assert terminal.getvalue() == ""


def test_it_counts_digits(line, terminal, watch):
    line(1, 10.0)
    watch.now += 1
    line(3, 0.1)
    assert terminal.shown() == "solving: 50%, cycle 3, error about 0.1 levels"
    watch.now += 1
    line(1234, 2e-4)
    assert terminal.shown() == "solving: 100%, cycle 1,234, error about 0.0002 levels"


def test_it_is_written_over_and_wiped_out(line, terminal, watch):
    watch.now += 1
    line(10000, 0.012345)
    watch.now += 1
    line(10, math.inf)
    assert terminal.shown() == "solving:  0%, cycle 10"
    line.close()
    assert terminal.shown() == ""
    assert "\n" not in terminal.getvalue()


def test_nothing_is_said_once_it_is_closed(line, terminal, watch):
    line.close()
    watch.now += 1
    line(1, 1.0)
    assert terminal.getvalue() == ""


def test_it_does_not_flicker(line, terminal, watch):
    for sweep in range(1000):
        watch.now += 0.01
        line(sweep, 1.0)
    assert 50 <= terminal.getvalue().count("\r") <= 110


@pytest.mark.parametrize("first", [math.nan, math.inf, 0.0])
@pytest.mark.parametrize("error", [math.nan, math.inf, 0.0, 1e-300, 1e300])
def test_odd_errors_are_no_trouble(line, terminal, watch, first, error):
    line(1, first)
    watch.now += 1
    line(2, error)
    assert terminal.shown().startswith("solving: ")


def test_it_is_not_wider_than_the_terminal(line, terminal, watch, monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")
    watch.now += 1
    line(1, 1.0)
    assert terminal.shown() == "solving:  0%, cycle"


@pytest.mark.parametrize(
    ("stream", "reporting", "term", "expected"),
    [
        (Terminal(), Reporting(), "xterm", True),
        (Terminal(), Reporting(quiet=True), "xterm", False),
        (Terminal(), Reporting(), "dumb", False),
        (io.StringIO(), Reporting(), "xterm", False),
    ],
    ids=["terminal", "quiet", "dumb", "file"],
)
def test_it_is_for_terminals_only(stream, reporting, term, expected, monkeypatch):
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", term)
    with progress.shown(reporting, Solver()) as shown:
        assert (shown is not None) is expected


# --- a long solve, on a terminal, interrupted -------------------------------------------------------

PATIENCE = 60  # seconds, for compiling
PROMPT = 2.0  # seconds: in fact some hundredths


def save(name: str, pixels: np.ndarray) -> None:
    write(prepare(Path(name), overwrite=False), Picture(name, pixels))


def read_until(terminal: int, word: bytes, process: "subprocess.Popen[bytes]") -> bytes:
    seen, deadline = b"", time.monotonic() + PATIENCE
    while word not in seen:
        assert time.monotonic() < deadline, seen
        assert process.poll() is None, seen
        if select.select([terminal], [], [], 0.1)[0]:
            seen += os.read(terminal, 4096)
    return seen


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("solver", ["multigrid", "sor"])
def test_a_signal_stops_a_long_solve_at_once(tmp_path, monkeypatch, heard_signals, solver, number):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TERM", "xterm")
    rng = np.random.default_rng(1)
    save("noise.bmp", rng.integers(0, 256, (1500, 1500, 3), dtype=np.uint8))
    words = [*POISSON, "fill", "noise.bmp", "--rect", "0,0,1500,1499", "-o", "out.png"]
    words += ["--solver", solver, "--tolerance", "1e-30"]
    terminal, other_end = pty.openpty()
    with subprocess.Popen(words, stderr=other_end) as process:
        os.close(other_end)
        read_until(terminal, b"\rsolving: ", process)
        process.send_signal(number)
        started = time.monotonic()
        process.wait(PATIENCE)
        seconds = time.monotonic() - started
    said = os.read(terminal, 4096).decode()
    os.close(terminal)
    assert process.returncode == 128 + number
    assert said.endswith(f"poisson: error: {'interrupted' if number == signal.SIGINT else 'terminated'}\r\n")
    assert said.partition("poisson: error")[0].endswith(" \r")  # the progress line is wiped out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["noise.bmp"]
    assert seconds < PROMPT
