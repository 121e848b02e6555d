"""A batch on Dask: a scheduler and workers as processes of their own, on this machine's loopback."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.batch_jobs import (
    by_single_commands,
    endless,
    environment,
    jobs,
    outputs,
    reader,
    report,
    start,
    wait_until,
    write,
)

NUMBER = 30


def spawn(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    """One of Dask's own programs."""
    with open(folder / f"{words[0]}.log", "ab") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]],
            cwd=folder,
            env=environment(),
            stdout=log,
            stderr=log,
        )


class Cluster:
    """A scheduler, and workers that nobody starts again when they are lost."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.file = folder / "scheduler.json"
        self.scheduler = spawn(
            folder, "scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(self.file),
            "--no-dashboard", "--dashboard-address", "127.0.0.1:0",
        )  # fmt: skip
        self.workers: list[subprocess.Popen[bytes]] = []
        wait_until(lambda: self.file.exists() and self.file.read_text().endswith("}"), "no scheduler")
        self.address = json.loads(self.file.read_text())["address"]

    def work(self) -> None:
        self.workers.append(
            spawn(
                self.folder, "worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard",
                "--dashboard-address", "127.0.0.1:0", "--local-directory", str(self.folder),
            )
        )  # fmt: skip

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    (tmp_path / "dask").mkdir()
    made = Cluster(tmp_path / "dask")
    try:
        yield made
    finally:
        made.close()


def test_a_lost_worker_loses_nothing(folder, cluster):
    """One worker is killed while it reads a picture that comes through a pipe; the other one does what it had."""
    lines = jobs(NUMBER)
    lines[NUMBER // 2]["source"] = "pipe.png"
    path = write(folder, lines)
    cluster.work()
    cluster.work()
    with endless(folder / "pipe.png") as pipe:
        process = start("batch", path.name, "--scheduler", cluster.address, "--report", "-", cwd=folder)
        pid = reader(folder / "pipe.png")
        (first,) = (worker for worker in cluster.workers if worker.pid == pid)
        first.kill()
        first.wait()
        reader(folder / "pipe.png")  # the other one
        os.write(pipe, (folder / "source.png").read_bytes())
    out, err = process.communicate()
    assert process.returncode == 0, err
    found, summary = report(out)
    assert [line["job"] for line in found] == list(range(1, NUMBER + 1))  # each of them once
    assert (summary["done"], summary["jobs"]) == (NUMBER, NUMBER)
    assert found[NUMBER // 2]["attempts"] == 2
    made = outputs(folder)
    for name in made:
        (folder / "out" / name).unlink()
    assert made == by_single_commands(jobs(NUMBER))


def test_on_this_machine_with_bad_jobs(folder):
    lines = jobs(8)
    lines[3]["source"] = "nowhere.png"
    lines[5]["source"] = "pipe.png"
    path = write(folder, lines)
    (folder / "out" / "007.png").write_bytes(b"mine")
    killed: list[int] = []
    with endless(folder / "pipe.png"):
        process = start("batch", path.name, "--scheduler", "local", "-j", "2", "--report", "-", cwd=folder)
        for _ in range(2):
            killed.append(reader(folder / "pipe.png", but=killed))
            os.kill(killed[-1], signal.SIGKILL)
        out, err = process.communicate()
    assert process.returncode == 1, err
    found, summary = report(out)
    failed = {line["job"]: line for line in found if line["status"] == "failed"}
    assert {job: line["exit_code"] for job, line in failed.items()} == {4: 3, 6: 1, 8: 4}
    assert "its worker was lost, 2 times" in failed[6]["error"]
    assert failed[6]["attempts"] == 2
    assert failed[4]["error"].endswith("nowhere.png: no such file")
    assert (summary["done"], summary["failed"]) == (5, 3)
    made = outputs(folder)
    assert made.pop("007.png") == b"mine"
    for name in made:
        (folder / "out" / name).unlink()
    assert made == by_single_commands([line for k, line in enumerate(lines) if k not in (3, 5, 7)])


def test_a_batch_that_is_stopped_leaves_the_cluster_in_order(folder, cluster):
    lines = jobs(NUMBER)
    lines[4]["source"] = "pipe.png"
    path = write(folder, lines)
    cluster.work()
    with endless(folder / "pipe.png") as pipe:
        process = start("batch", path.name, "--scheduler", cluster.address, "-q", cwd=folder)
        reader(folder / "pipe.png")
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate()
        os.write(pipe, (folder / "source.png").read_bytes())
    assert (process.returncode, err) == (143, "poisson: error: terminated\n")
    (folder / "pipe.png").unlink()
    path = write(folder, jobs(NUMBER))
    again = start(
        "batch", path.name, "--scheduler", cluster.address, "--skip-existing", "--report", "-", cwd=folder
    )
    out, err = again.communicate()
    assert again.returncode == 0, err
    _, summary = report(out)
    assert summary["done"] + summary["skipped"] == NUMBER
    made = outputs(folder)
    for name in made:
        (folder / "out" / name).unlink()
    assert made == by_single_commands(jobs(NUMBER))


def test_two_clusters_on_one_machine_have_nothing_to_say_about_each_other(folder):
    """Dask would warn that the port of its dashboard is taken, though there is no dashboard."""
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):  # if it is taken already, so much the better
            stack.enter_context(socket.create_server(("", 8787)))
        path = write(folder, jobs(2))
        process = start("batch", path.name, "--scheduler", "local", "-j", "1", "-q", cwd=folder)
        assert process.communicate() == ("", "")
        assert process.returncode == 0


def test_a_stop_at_the_terminal_is_for_the_batch_alone(folder):
    """It reaches every process there, and none of the workers has anything to say about it."""
    path = write(folder, jobs(10 * NUMBER))  # so many that they are not done before the signal comes
    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = start(
            "batch", path.name, "--scheduler", "local", "-j", "2", "--report", "-", cwd=folder, group=True
        )
    finally:
        signal.signal(signal.SIGINT, usual)
    process.stdout.readline()
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate()
    said, error = err.splitlines()
    assert (process.returncode, error) == (130, "poisson: error: interrupted")
    assert said.startswith("batch: ")
    assert json.loads(out.splitlines()[-1])["summary"]["exit_code"] == 130


def test_no_scheduler_there(folder, monkeypatch):
    monkeypatch.setattr("poisson_cli.batch.cluster._TIMEOUT", 0.5)
    from poisson_cli.main import run

    path = write(folder, jobs(2))
    assert run(["batch", str(path), "--scheduler", "tcp://127.0.0.1:9", "-q"]) == 3


def test_without_dask_there_is_an_error_that_says_what_to_install(folder, poisson, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    ran = poisson("batch", write(folder, jobs(2)).name, "--scheduler", "local", "-q")
    assert (ran.code, ran.err) == (
        3,
        "poisson: error: a cluster needs Dask: pip install 'poisson-cli[cluster]'\n",
    )
