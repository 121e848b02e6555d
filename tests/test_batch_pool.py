"""The workers of a batch, with work of our own instead of jobs: deaths, retries, memory, order."""

import functools
import multiprocessing
import os
import signal
import struct
import threading
import time
from pathlib import Path

import PIL.Image
import pytest

from poisson_cli.batch import memory, pool
from poisson_cli.batch.task import Result, Task
from poisson_cli.errors import PoissonError
from poisson_cli.images import Picture, prepare, write
from poisson_cli.images.depth import convert
from poisson_cli.images.formats import by_extension
from poisson_cli.images.size import peek
from poisson_cli.job import Job
from poisson_cli.settings import (
    Combine,
    Ellipse,
    Grow,
    MaskFile,
    Output,
    Polygon,
    Rectangle,
    Selection,
    Solver,
)
from tests.batch_jobs import wait_until
from tests.small_pictures import encoded, smooth


def tasks(folder: Path, number: int) -> list[Task]:
    return [
        Task(k, k, "fill", (Job("fill", folder / "in.png", Output(folder / f"{k}.png")),))
        for k in range(1, number + 1)
    ]


def run(work, folder: Path, number: int = 6, *, limit: int = 1 << 40, **choices) -> list[Result]:
    return list(pool.run(tasks(folder, number), limit=limit, perform=work, **{"workers": 2, **choices}))


# What workers do; importable, because a new process has to find it.


def note(task: Task, attempts: int) -> Result:
    """Say when it was done, and by whom."""
    start = time.monotonic()
    time.sleep(0.03)
    path = task.outputs[0]
    path.write_text(f"{start} {time.monotonic()} {os.getpid()}")
    return Result.of(task, "done", attempts=attempts)


def meet(task: Task, attempts: int) -> Result:
    """Wait until another process is at work as well."""
    path = task.outputs[0]
    path.write_text(str(os.getpid()))
    wait_until(lambda: len({one.read_text() for one in path.parent.glob("*.png")} - {""}) == 2, "alone")
    return Result.of(task, "done", attempts=attempts)


def die_once(task: Task, attempts: int, *, on: int = 3) -> Result:
    """Leave rubbish, and half of the outputs, and die."""
    if task.number == on and attempts == 1:
        path = task.outputs[0]
        path.with_name(f".poisson-{os.getpid()}-abc.tmp").write_text("half")
        path.with_name(".poisson-1-abc.tmp").write_text("somebody else's")
        path.write_text("begun")
        os.kill(os.getpid(), signal.SIGKILL)
    status = "done" if attempts == 1 or task.jobs[0].output.overwrite else "failed"
    return Result.of(task, status, attempts=attempts)


def die(task: Task, attempts: int, *, on: int = 2, code: int = 7) -> Result:
    if task.number == on:
        os._exit(code)
    return Result.of(task, "done", attempts=attempts)


def deaf_on_third(task: Task, attempts: int) -> Result:
    """Take for ever, and do not end when asked to."""
    if task.number == 3:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        time.sleep(1000)
    return Result.of(task, "done", attempts=attempts)


def done_when_asked_to_end(task: Task, attempts: int) -> Result:
    """Take too long, be done just when it is too late, and end only then."""
    if task.number == 3:
        asked = threading.Event()
        signal.signal(signal.SIGTERM, lambda *_: asked.set())
        while not asked.is_set():
            time.sleep(0.01)
        threading.Timer(0.2, os._exit, [143]).start()
    elif task.number == 4:
        time.sleep(0.5)
    return Result.of(task, "done", attempts=attempts)


def fail(task: Task, attempts: int) -> Result:
    return Result.of(task, "failed" if task.number == 2 else "done")


class CannotBeLoaded:
    """Pickles, but cannot be unpickled: what a worker that cannot begin looks like."""

    def __reduce__(self):
        return os._exit, (9,)


def spans(folder: Path) -> list[tuple[float, float]]:
    return sorted(tuple(map(float, path.read_text().split()[:2])) for path in folder.glob("*.png"))


def at_once(folder: Path) -> int:
    """The most that ran at the same time."""
    moments = sorted((t, step) for start, end in spans(folder) for t, step in ((start, 1), (end, -1)))
    running = [0]
    for _, step in moments:
        running.append(running[-1] + step)
    return max(running)


def test_each_worker_does_many(tmp_path):
    results = run(meet, tmp_path, 12)
    assert sorted(result.job for result in results) == list(range(1, 13))
    assert {result.status for result in results} == {"done"}


def test_no_more_workers_than_jobs_fit_into_memory(tmp_path):
    assert len(run(note, tmp_path, 6, workers=3, limit=memory.WORKER * 3 // 2)) == 6
    assert at_once(tmp_path) == 1


def test_a_large_job_waits_for_room_and_is_not_overtaken(tmp_path):
    (tmp_path / "in.png").write_bytes(encoded(smooth(1500, 1500, 1)[:, :, 0]))
    jobs = tasks(tmp_path, 5)
    small = [
        Task(k, k, "fill", (Job("fill", tmp_path / "no.png", Output(tmp_path / f"{k}.png")),))
        for k in (1, 2, 4, 5)
    ]
    order = [small[0], small[1], jobs[2], small[2], small[3]]
    large = memory.estimator()(jobs[2])
    assert large > 2 * memory.WORKER  # so that the others have room for two
    begun = []
    results = list(
        pool.run(order, workers=2, limit=large, perform=note, begins=lambda task: begun.append(task.number))
    )
    assert begun == [1, 2, 3, 4, 5]
    assert len(results) == 5
    start, end = map(float, (tmp_path / "3.png").read_text().split()[:2])
    others = [tuple(map(float, (tmp_path / f"{k}.png").read_text().split()[:2])) for k in (1, 2, 4, 5)]
    assert all(other_end <= start or end <= other_start for other_start, other_end in others)


def test_a_death_costs_one_job_another_attempt(tmp_path):
    results = {result.job: result for result in run(die_once, tmp_path)}
    assert {job: (result.status, result.attempts) for job, result in results.items()} == {
        job: ("done", 2 if job == 3 else 1) for job in range(1, 7)
    }
    assert {path.name for path in tmp_path.iterdir()} == {"3.png", ".poisson-1-abc.tmp"}


def test_what_was_there_before_is_not_replaced_by_another_attempt(tmp_path):
    (tmp_path / "3.png").write_text("mine")
    results = {result.job: result.status for result in run(die_once, tmp_path)}
    assert results == {job: "failed" if job == 3 else "done" for job in range(1, 7)}


@pytest.mark.parametrize(
    ("code", "exit_code", "text"),
    [(7, 7, "ended with exit code 7, 2 times"), (0, 1, "ended with exit code 0, 2 times")],
)
def test_two_deaths_are_a_failure(tmp_path, code, exit_code, text):
    results = {result.job: result for result in run(functools.partial(die, code=code), tmp_path)}
    failed = results.pop(2)
    assert (failed.status, failed.exit_code, failed.attempts) == ("failed", exit_code, 2)
    assert text in failed.error
    assert {result.status for result in results.values()} == {"done"}
    assert len(results) == 5


def test_after_a_failure_no_more_begin_if_so_chosen(tmp_path):
    assert [result.job for result in run(fail, tmp_path, keep_going=False, workers=1)] == [1, 2]
    assert len(run(fail, tmp_path, workers=1)) == 6


def test_what_takes_too_long_fails_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(pool, "_PATIENCE", 0.2)
    results = {result.job: result for result in run(deaf_on_third, tmp_path, timeout=0.5)}
    late = results.pop(3)
    assert (late.status, late.exit_code, late.attempts, late.seconds) == ("failed", 143, 1, 0.5)
    assert late.error.startswith("took longer than 0.5 s and was ended")
    assert {result.status for result in results.values()} == {"done"}
    assert len(results) == 5


def test_what_is_done_in_the_last_moment_is_done_and_harms_no_other(tmp_path):
    results = run(done_when_asked_to_end, tmp_path, timeout=1.5, workers=1)
    assert [(result.job, result.status) for result in results] == [(job, "done") for job in range(1, 7)]


def test_the_next_small_job_is_there_before_it_is_asked_for(tmp_path):
    """While nobody listens a worker does what it has: the second job, and the third one that waits in its pipe."""
    begun = []
    results = pool.run(
        tasks(tmp_path, 6),
        workers=1,
        limit=1 << 40,
        perform=note,
        begins=lambda task: begun.append(task.number),
    )
    assert next(results).job == 1
    assert begun == [1, 2]
    wait_until((tmp_path / "3.png").exists, "the third job is not done")
    time.sleep(0.2)
    assert not (tmp_path / "4.png").exists()
    assert [result.job for result in results] == [2, 3, 4, 5, 6]
    assert begun == [1, 2, 3, 4, 5, 6]


def test_no_job_waits_behind_a_large_one(tmp_path, monkeypatch):
    monkeypatch.setattr(pool, "_SMALL", memory.WORKER - 1)
    results = pool.run(tasks(tmp_path, 6), workers=1, limit=1 << 40, perform=note)
    assert next(results).job == 1
    wait_until((tmp_path / "2.png").exists, "the second job is not done")
    time.sleep(0.2)
    assert not (tmp_path / "3.png").exists()
    assert [result.job for result in results] == [2, 3, 4, 5, 6]


def test_a_job_that_waits_behind_a_deadly_one_is_none_the_worse(tmp_path):
    """With one worker each job but the first has waited in the pipe of the one before."""
    begun = []
    results = {
        result.job: result
        for result in run(
            functools.partial(die, on=3), tmp_path, workers=1, begins=lambda task: begun.append(task.number)
        )
    }
    assert {job: (result.status, result.attempts) for job, result in results.items()} == {
        job: ("failed", 2) if job == 3 else ("done", 1) for job in range(1, 7)
    }
    assert begun == [1, 2, 3, 4, 5, 6, 3]


def test_workers_that_cannot_begin_are_an_error_and_no_endless_loop(tmp_path):
    with pytest.raises(PoissonError, match="3 worker processes in a row .* before they could begin"):
        run(CannotBeLoaded(), tmp_path)


# --- estimates --------------------------------------------------------------------------------------------------------


def test_an_estimate_grows_with_the_pictures_and_never_fails(tmp_path):
    for side in (100, 200):
        (tmp_path / f"{side}.png").write_bytes(encoded(smooth(side, side, 3)))
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\nnothing")
    os.mkfifo(tmp_path / "pipe.png")
    estimate = memory.estimator()

    def of(name: str, source: str | None = None) -> int:
        job = Job("clone", tmp_path / name, Output(tmp_path / "o.png"), source=source and tmp_path / source)
        return estimate(Task(1, 1, "clone", (job,)))

    nothing = of("no.png")
    assert nothing == of("broken.png") == of("pipe.png") == memory.WORKER
    assert nothing < of("100.png") < of("100.png", "200.png") < of("200.png", "200.png")


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("big", [False, True])
def test_every_tiff_says_how_large_it_is(tmp_path, order, big):
    """Of both orders of bytes, with places of 4 and of 8 bytes, and its directory at the end."""
    magic = b"II" if order == "<" else b"MM"
    entries = [(256, 40), (257, 30)]
    if big:
        head = magic + struct.pack(f"{order}HHHQ", 43, 8, 0, 100)
        directory = struct.pack(f"{order}Q", 2) + b"".join(
            struct.pack(f"{order}HHQQ", tag, 16, 1, value) for tag, value in entries
        )
    else:
        head = magic + struct.pack(f"{order}HI", 42, 100)
        directory = struct.pack(f"{order}H", 2) + b"".join(
            struct.pack(f"{order}HHII", tag, 4, 1, value) for tag, value in entries
        )
    (tmp_path / "a.tif").write_bytes(head.ljust(100, b"\0") + directory + bytes(8))
    assert peek(tmp_path / "a.tif") == (30, 40, "float")


SHAPES = {
    "rectangle": ([Combine(Rectangle(5, 7, 30, 40))], 30 * 40),
    "outside as well": ([Combine(Rectangle(-50, -50, 1000, 1000))], 100 * 100),
    "ellipse": ([Combine(Ellipse(Rectangle(5, 7, 30, 40)))], 30 * 40),
    "polygon": ([Combine(Polygon(((5, 7), (35.5, 7), (20, 46.5))))], 31 * 40),
    "two": ([Combine(Rectangle(0, 0, 2, 2)), Combine(Rectangle(48, 38, 2, 2))], 50 * 40),
    "grown": ([Combine(Rectangle(5, 7, 30, 40)), Grow(3), Grow(-3)], 36 * 46),
    "cut": ([Combine(Rectangle(5, 7, 30, 40)), Combine(Rectangle(0, 0, 90, 90), "subtract")], 30 * 40),
    "of a file": ([Combine(Rectangle(5, 7, 30, 40)), Combine(MaskFile("mask.png"))], 100 * 100),
}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_say_how_much_is_solved_for(tmp_path, name):
    steps, pixels = SHAPES[name]
    (tmp_path / "in.png").write_bytes(encoded(smooth(100, 100, 3)))
    job = Job("fill", tmp_path / "in.png", Output(tmp_path / "o.png"), selection=Selection(tuple(steps)))
    estimate = memory.estimator()

    def beyond_the_picture(job: Job) -> int:
        return estimate(Task(1, 1, "fill", (job,))) - memory.WORKER - 100 * 100 * memory.PER_PIXEL["16"]

    assert beyond_the_picture(job) == pixels * memory.PER_UNKNOWN
    inverted = job._replace(selection=Selection(tuple(steps), invert=True))
    assert beyond_the_picture(inverted) == 100 * 100 * memory.PER_UNKNOWN
    proved = job._replace(solver=Solver(certify=True))
    assert beyond_the_picture(proved) == 3 * pixels * memory.PER_UNKNOWN


@pytest.mark.parametrize(
    "name", ["a.png", "a.jpg", "a.tif", "a.bmp", "a.webp", "a.ppm", "a.pfm", "a.hdr", "a.exr"]
)
def test_every_format_says_how_large_it_is(tmp_path, monkeypatch, name):
    """Floats as well, which need most: no decoder of Pillow's knows them. Pillow's own limit is none."""
    monkeypatch.setattr(PIL.Image, "MAX_IMAGE_PIXELS", 10)
    depth = by_extension(Path(name)).depths[-1]
    pixels = convert(smooth(30, 40, 3), depth).values
    write(prepare(tmp_path / name), Picture("a", pixels))
    assert peek(tmp_path / name) == (30, 40, depth)
    whole = (tmp_path / name).read_bytes()
    for end in (0, 5, 20, len(whole) // 2):
        (tmp_path / name).write_bytes(whole[:end])
        assert peek(tmp_path / name) in (None, (30, 40, depth))


def test_there_is_some_memory():
    assert memory.available() > 0
    assert [memory.said(size) for size in (1, 5 << 20, 3 << 29)] == ["1 MiB", "5 MiB", "1.5 GiB"]


def test_workers_begun_ahead_do_the_jobs(tmp_path, monkeypatch):
    """There is no picture to fill: each says so."""
    with pool.Ahead(2, quiet=True) as ahead:
        monkeypatch.setattr(pool, "_Worker", None)  # no further one
        results = list(pool.run(tasks(tmp_path, 5), workers=2, limit=1 << 40, ahead=ahead))
    assert sorted(result.job for result in results) == [1, 2, 3, 4, 5]
    assert {result.exit_code for result in results} == {3}
    assert multiprocessing.active_children() == []


def test_workers_that_nobody_takes_are_ended():
    with pool.Ahead(2, quiet=True):
        assert len(multiprocessing.active_children()) == 2
    assert multiprocessing.active_children() == []
