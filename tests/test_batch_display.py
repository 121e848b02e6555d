"""What a person sees of a batch."""

import io
from pathlib import Path

import pytest

from poisson_cli.batch.display import Display, checking, ending
from poisson_cli.batch.report import Tally
from poisson_cli.batch.task import Result, Task
from poisson_cli.job import Job
from poisson_cli.settings import Output
from tests.batch_jobs import wait_until
from tests.test_progress import Terminal, Watch


def task(number: int) -> Task:
    return Task(number, number, "fill", (Job("fill", Path("a.png"), Output(Path(f"out/{number}.png"))),))


class Batch:
    """A batch that goes as it is told to."""

    def __init__(self, stream: io.StringIO, **choices: bool) -> None:
        self.tally, self.watch = Tally(2000), Watch()
        choices = {"quiet": False, **choices}
        self.display = Display(self.tally, stream, name="jobs.csv", clock=self.watch, **choices)

    def job(self, number: int, seconds: float, **result: object) -> None:
        self.display.begins(task(number))
        self.watch.now += seconds
        made = Result.of(task(number), **{"status": "done", **result})
        self.tally.add(made)
        self.display.ends(made)


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("TERM", "xterm")


def test_a_terminal_shows_one_line(wide):
    terminal = Terminal()
    batch = Batch(terminal)
    for number in range(1, 100):
        batch.job(number, 0.5)
    batch.display.begins(task(100))
    batch.display.begins(task(101))
    batch.watch.now += 1
    batch.display.begins(task(102))
    assert terminal.shown() == "99 of 2,000 done, 2.0 a second, 16 min left; fill out/100.png"
    batch.job(100, 0.5, status="failed", error="a.png: no such file")
    assert "\npoisson" not in terminal.getvalue()
    _, line = terminal.getvalue().split("poisson: jobs.csv:100: a.png: no such file\n")
    assert line.startswith("\r99 of 2,000 done, 1 failed, ")


def test_where_a_report_goes_to_the_same_terminal_no_line_is_written_over():
    terminal = Terminal()
    batch = Batch(terminal, shared=True)
    for number in range(1, 41):
        batch.job(number, 1.0)
    assert terminal.getvalue() == "poisson: 30 of 2,000 done, 1.0 a second, 33 min left\n"


def test_nothing_of_the_line_is_left():
    terminal = Terminal()
    batch = Batch(terminal)
    with batch.display.fresh():
        for number in range(1, 100):
            batch.job(number, 0.5)
        assert terminal.shown()
    assert terminal.shown() == ""


def test_a_long_job_is_seen_to_be_one(monkeypatch):
    """Though nothing begins and nothing ends."""
    monkeypatch.setattr("poisson_cli.batch.display.TICK", 0.01)
    terminal = Terminal()
    batch = Batch(terminal)
    with batch.display.fresh():
        batch.job(1, 0.5)
        batch.display.begins(task(2))
        batch.watch.now += 300
        wait_until(lambda: "fill out/2.png for 5 min" in terminal.shown(), "no word of it")


class Closed(Terminal):
    """A terminal that is gone."""

    def write(self, text: str) -> int:
        raise OSError(5, "Input/output error")


def test_a_terminal_that_is_gone_is_no_matter(monkeypatch):
    silenced = []
    monkeypatch.setattr("poisson_cli.batch.display.silence", silenced.append)
    terminal = Closed()
    batch = Batch(terminal)
    with batch.display.fresh():
        batch.job(1, 0.5, status="failed", error="no")
        batch.job(2, 0.5)
        batch.display.say("something")
    assert set(silenced) == {terminal}


def test_names_do_nothing_to_the_terminal():
    terminal = Terminal()
    batch = Batch(terminal)
    bad = Task(1, 1, "fill", (Job("fill", Path("a.png"), Output(Path("o\x1b[2J.png"))),))
    batch.display.begins(bad)
    batch.watch.now += 1
    batch.display.begins(task(2))
    assert terminal.shown().endswith(r"; fill o\x1b[2J.png")
    batch.job(3, 0.5, status="failed", error="a\x1b[2J.png: no")
    assert r"poisson: jobs.csv:3: a\x1b[2J.png: no" in terminal.getvalue()


def test_elsewhere_there_are_plain_lines_now_and_then():
    stream = io.StringIO()
    batch = Batch(stream)
    for number in range(1, 91):
        batch.job(number, 1.0, **({"status": "failed", "error": "no"} if number == 50 else {}))
    assert stream.getvalue().splitlines() == [
        "poisson: 30 of 2,000 done, 1.0 a second, 33 min left",
        "poisson: jobs.csv:50: no",
        "poisson: 59 of 2,000 done, 1 failed, 1.0 a second, 32 min left",
        "poisson: 89 of 2,000 done, 1 failed, 1.0 a second, 32 min left",
    ]


def test_quiet_is_quiet_but_for_failures():
    terminal = Terminal()
    batch = Batch(terminal, quiet=True)
    for number in range(1, 100):
        batch.job(number, 1.0, **({"status": "failed", "error": "no"} if number == 50 else {}))
    assert terminal.getvalue() == "poisson: jobs.csv:50: no\n"


def test_a_long_list_is_seen_to_be_checked(monkeypatch):
    monkeypatch.setattr("poisson_cli.batch.display.DELAY", 0.0)
    monkeypatch.setattr("poisson_cli.batch.display.INTERVAL", 0.0)
    terminal, elsewhere = Terminal(), io.StringIO()
    for stream in (terminal, elsewhere):
        with checking(stream, quiet=False, name="jobs.csv") as watch:
            for number in range(1, 1500):
                watch(number, 2000)
            if stream is terminal:
                assert terminal.shown() == "checking jobs.csv: 1,499 of 2,000 lines"
    assert (terminal.shown(), elsewhere.getvalue()) == ("", "")


def test_the_end():
    tally = Tally(2000)
    for number in range(1, 1960):
        tally.add(Result.of(task(number), "done"))
    assert ending(tally, 20.0) == "batch: 1,959 done, 41 not run in 20 s, 98.0 a second"
    for number in range(1960, 2001):
        tally.add(Result.of(task(number), "failed"))
    assert ending(tally, 4000.0) == "batch: 1,959 done, 41 failed in 67 min, 30.0 a minute"
    assert (tally.exit_code, tally.left) == (1, 0)
