"""`poisson batch`: what comes out, what is said about it, and what one bad job does to the others."""

import json
import os
import pty
import random
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

from poisson_cli import batch
from poisson_cli.batch.mistakes import Mistakes
from poisson_cli.images import writing
from tests.batch_jobs import (
    POISSON,
    by_single_commands,
    children,
    endless,
    environment,
    is_alive,
    jobs,
    outputs,
    reader,
    report,
    start,
    wait_until,
    write,
)

NUMBER = 12


@pytest.fixture
def manifest(folder):
    return write(folder, jobs(NUMBER))


@pytest.fixture
def expected(manifest):
    return by_single_commands(jobs(NUMBER))


@pytest.mark.parametrize("stop_after", [3, NUMBER])
def test_names_are_forced_to_the_disk_when_all_is_done(manifest, folder, monkeypatch, stop_after):
    """By the batch: its workers leave that to it."""
    settled = []

    def settle(path: Path) -> None:
        settled.append((path, len(outputs(folder))))

    monkeypatch.setattr(writing, "settle", settle)
    results = batch.run(jobs(NUMBER), folder=folder, workers=2)
    for _ in zip(range(stop_after), results, strict=False):
        assert settled == []
    results.close()
    assert [path for path, _ in settled] == [(folder / jobs(1)[0]["output"]).parent]
    assert settled[0][1] >= stop_after


@pytest.mark.parametrize("workers", [1, 3])
def test_the_files_are_those_of_single_commands(manifest, expected, poisson, folder, workers):
    ran = poisson("batch", manifest.name, "--jobs", workers, "--report", "-", "-q")
    assert (ran.code, ran.err) == (0, "")
    assert outputs(folder) == expected
    lines, summary = report(ran.out)
    assert [line["job"] for line in lines] == [line["line"] for line in lines] == list(range(1, NUMBER + 1))
    assert [line["output"] for line in lines] == [job["output"] for job in jobs(NUMBER)]
    for line in lines:
        assert (line["tool"], line["status"], line["exit_code"], line["error"]) == ("clone", "done", 0, None)
        assert (line["attempts"], line["beside"]) == (1, [])
        assert line["unknowns"] > 100
        assert 0 < line["error_estimate"] <= 2e-4
        assert line["seconds"] > 0
    seconds = summary.pop("seconds")
    assert seconds > 0
    assert summary == {
        "jobs": NUMBER,
        "done": NUMBER,
        "failed": 0,
        "skipped": 0,
        "not_run": 0,
        "exit_code": 0,
    }


def test_shards_share_the_jobs(manifest, expected, poisson, folder):
    made = {}
    for share in (1, 2, 3):
        assert poisson("batch", manifest.name, "--shard", f"{share}/3", "-j", 1).code == 0
        now = outputs(folder)
        assert len(now) - len(made) == NUMBER // 3
        made = now
    assert made == expected


def test_paths_are_relative_to_the_manifest(manifest, expected, poisson, folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    assert poisson("batch", manifest, "-j", 1).code == 0
    assert outputs(folder) == expected


def test_standard_input(manifest, expected, folder):
    ran = subprocess.run(
        [*POISSON, "batch", "-", "-j", "2", "-q"],
        cwd=folder,
        input=manifest.read_bytes(),
        capture_output=True,
        env=environment(),
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, b"", b"")
    assert outputs(folder) == expected


def test_bad_jobs_stop_nobody(folder, poisson):
    lines = jobs(NUMBER)
    (folder / "broken.png").write_bytes((folder / "source.png").read_bytes()[:300])
    lines[2]["source"] = "broken.png"
    lines[3]["source"] = "nowhere.png"
    lines[5]["at"] = [1000, 1000]
    (folder / "folder.png").mkdir()
    lines[7]["output"] = "folder.png"
    lines[8]["max_iterations"] = 1
    lines[8]["tolerance"] = 1e-9
    path = write(folder, lines)
    (folder / "out" / "009.png").write_bytes(b"mine")
    ran = poisson("batch", path.name, "--report", "report.jsonl", "-j", 2)
    assert ran.code == 1
    found, summary = report((folder / "report.jsonl").read_text())
    failed = {
        line["job"] - 1: (line["exit_code"], line["error"]) for line in found if line["status"] == "failed"
    }
    assert {k: code for k, (code, _) in failed.items()} == {2: 3, 3: 3, 5: 3, 7: 4, 8: 5, 9: 4}
    assert (summary["done"], summary["failed"], summary["exit_code"]) == (NUMBER - 6, 6, 1)
    for k, (code, error) in failed.items():  # as the single command says it
        job = lines[k]
        options = [word for name in ("max_iterations", "tolerance") if name in job
                   for word in (f"--{name.replace('_', '-')}", job[name])]  # fmt: skip
        x, y = job["at"]
        single = poisson("clone", job["source"], job["destination"], "-m", job["mask"], f"--at={x},{y}", *options,
                         "-o", job["output"], "-q")  # fmt: skip
        assert (single.code, single.err) == (code, f"poisson: error: {error}\n")
        assert f"poisson: jobs.jsonl:{k + 1}: {error}\n" in ran.err
    assert f"batch: {NUMBER - 6} done, 6 failed in " in ran.err.splitlines()[-1]
    assert outputs(folder).keys() == {f"{k:03}.png" for k in range(NUMBER) if k not in failed} | {"009.png"}


def test_a_job_that_takes_its_worker_along_is_tried_again_and_then_fails(folder):
    """A picture comes through a pipe, and whoever reads from that is killed."""
    lines = jobs(NUMBER)
    lines[3]["source"] = "pipe"
    path = write(folder, lines)
    killed: list[int] = []
    with endless(folder / "pipe"):
        process = start("batch", path.name, "-j", 2, "--report", "-", cwd=folder)
        for _ in range(2):
            killed.append(reader(folder / "pipe", but=killed))
            os.kill(killed[-1], signal.SIGKILL)
        out, err = process.communicate()
    assert process.returncode == 1, err
    found, summary = report(out)
    assert (summary["done"], summary["failed"]) == (NUMBER - 1, 1)
    (failed,) = (line for line in found if line["status"] == "failed")
    assert (failed["job"], failed["exit_code"], failed["attempts"]) == (4, 137, 2)
    assert "was killed by SIGKILL, 2 times" in failed["error"]
    rest = [line for k, line in enumerate(lines) if k != 3]
    made = outputs(folder)
    for path in (folder / "out").iterdir():
        path.unlink()
    assert made == by_single_commands(rest)


def test_fail_fast_begins_no_more(folder, poisson):
    lines = jobs(NUMBER)
    lines[2]["source"] = "nowhere.png"
    path = write(folder, lines)
    ran = poisson("batch", path.name, "--fail-fast", "-j", 1, "--report", "-")
    _, summary = report(ran.out)
    assert ran.code == summary["exit_code"] == 1
    assert (summary["done"], summary["failed"], summary["not_run"]) == (2, 1, NUMBER - 3)
    assert "2 done, 1 failed, 9 not run" in ran.err


def test_fail_fast_begins_no_more_after_one_that_is_too_large(manifest, poisson):
    ran = poisson("batch", manifest.name, "--fail-fast", "--memory", "64M", "--report", "-")
    _, summary = report(ran.out)
    assert (ran.code, summary["failed"], summary["not_run"]) == (1, 1, NUMBER - 1)


def test_skip_existing_does_the_rest(manifest, expected, poisson, folder):
    for name in ("000.png", "007.png"):
        (folder / "out" / name).write_bytes(b"there")
    ran = poisson("batch", manifest.name, "--skip-existing", "--report", "-", "-j", 1)
    lines, summary = report(ran.out)
    assert ran.code == 0
    assert [line["job"] for line in lines if line["status"] == "skipped"] == [1, 8]
    assert (summary["done"], summary["skipped"]) == (NUMBER - 2, 2)
    there = {"000.png": b"there", "007.png": b"there"}
    assert outputs(folder) == {**expected, **there}
    again = poisson("batch", manifest.name, "--skip-existing")
    assert (again.code, again.out) == (0, "")
    assert again.err.startswith(f"batch: 0 done, {NUMBER} skipped in ")
    assert poisson("batch", manifest.name, "--overwrite", "-j", 1).code == 0
    assert outputs(folder) == expected


def test_a_job_with_some_of_its_outputs_is_done_again(folder, poisson):
    line = {"tool": "tile", "images": ["grey.png", "destination.png"], "output": ["out/a.png", "out/b.png"]}
    path = write(folder, [line])
    assert poisson("batch", path.name).code == 0
    expected = outputs(folder)
    (folder / "out" / "b.png").unlink()
    (folder / "out" / "a.png").write_bytes(b"half a job")
    assert poisson("batch", path.name, "--skip-existing").code == 0
    assert outputs(folder) == expected


def test_reports_of_several_runs(manifest, poisson, folder):
    file = folder / "report.jsonl"
    assert poisson("batch", manifest.name, "--report", file, "-j", 1).code == 0
    first = file.read_text()
    refused = poisson("batch", manifest.name, "--report", file)
    assert refused.code == 4
    assert "report.jsonl: exists already; add --overwrite" in refused.err
    assert file.read_text() == first
    file.write_text(first[:-10])  # as if it had been killed just then
    assert poisson("batch", manifest.name, "--report", file, "--skip-existing").code == 0
    texts = file.read_text().splitlines()
    assert (
        texts[:NUMBER] == first.splitlines()[:NUMBER]
    )  # the half line is gone, or nobody could read the rest
    _, summary = report("\n".join(texts[NUMBER:]))
    assert summary["skipped"] == NUMBER
    assert poisson("batch", manifest.name, "--report", file, "--overwrite", "-j", 1).code == 0
    assert len(file.read_text().splitlines()) == NUMBER + 1


@pytest.mark.parametrize(
    ("there", "left"),
    [
        ('{"job": 1}\n{"j', '{"job": 1}\n'),
        ('{"summary": {"jobs"', ""),
        ('{"job": 1}\n{"job": 2}', '{"job": 1}\n{"job": 2}\n'),  # whole, but for its end
        ("somebody's notes", "somebody's notes\n"),
        ("x" * 10_000 + "\n" + '{"job": 2, "error": "' + "y" * 10_000, "x" * 10_000 + "\n"),
        ("", ""),
    ],
)
def test_a_report_goes_on_behind_whole_lines(manifest, poisson, folder, there, left):
    (folder / "out").joinpath("000.png").write_bytes(b"there")
    manifest.write_text(json.dumps(jobs(1)[0]))
    file = folder / "report.jsonl"
    file.write_text(there)
    assert poisson("batch", manifest.name, "--report", file, "--skip-existing").code == 0
    text = file.read_text()
    assert text.startswith(left)
    assert [line[:7] for line in text[len(left) :].splitlines()] == ['{"job":', '{"summa']


def test_a_report_that_cannot_be_written_ends_the_batch(manifest, expected, poisson, folder):
    ran = poisson("batch", manifest.name, "-j", 1, "--report", "/dev/full", "--skip-existing")
    *_, said, error = ran.err.splitlines()
    assert (ran.code, error) == (
        4,
        "poisson: error: the report cannot be written (No space left on device)",
    )
    assert said.startswith("batch: 1 done, 11 not run in ")
    assert poisson("batch", manifest.name, "-j", 1, "--skip-existing").code == 0
    assert outputs(folder) == expected


def test_a_report_is_not_written_into_the_manifest(manifest, poisson):
    before = manifest.read_bytes()
    ran = poisson("batch", manifest.name, "--report", f"./{manifest.name}", "--overwrite")
    assert ran.code == 2
    assert "--report would write into MANIFEST" in ran.err
    assert manifest.read_bytes() == before


def test_folders_of_outputs(manifest, expected, poisson, folder):
    lines = [{**line, "output": f"{'ab'[k % 2]}/deep/{k:03}.png"} for k, line in enumerate(jobs(NUMBER))]
    write(folder, lines)
    ran = poisson("batch", manifest.name, "-j", 1)
    assert (ran.code, ran.err.splitlines()) == (
        2,
        [
            f"poisson: error: jobs.jsonl:{line}: there is no folder {name}/deep for 6 outputs; make it first, or let "
            "--make-folders do it"
            for line, name in ((1, "a"), (2, "b"))
        ],
    )
    assert poisson("batch", manifest.name, "--make-folders", "--dry-run").code == 0
    assert not (folder / "a").exists()
    assert poisson("batch", manifest.name, "--make-folders", "-j", 1).code == 0
    assert {path.name: path.read_bytes() for path in folder.glob("[ab]/deep/*")} == expected
    (folder / "file").write_bytes(b"")
    write(folder, [{**jobs(1)[0], "output": "file/a.png"}])
    ran = poisson("batch", manifest.name, "--make-folders", "-j", 1)
    assert ran.code == 4
    assert "file: cannot be made" in ran.err


def test_a_job_that_takes_too_long_fails(folder):
    """It reads from a pipe into which nobody writes."""
    lines = jobs(NUMBER)
    lines[3]["source"] = "pipe"
    path = write(folder, lines)
    os.mkfifo(folder / "pipe")
    process = start("batch", path.name, "-j", 1, "--timeout", "2", "--report", "-", "-q", cwd=folder)
    out, err = process.communicate()
    assert process.returncode == 1, err
    found, summary = report(out)
    assert (summary["done"], summary["failed"]) == (NUMBER - 1, 1)
    assert (found[3]["status"], found[3]["exit_code"], found[3]["attempts"]) == ("failed", 143, 1)
    assert found[3]["error"].startswith("took longer than 2 s and was ended")
    assert outputs(folder).keys() == {f"{k:03}.png" for k in range(NUMBER) if k != 3}


def test_dry_run_prints_command_lines_and_does_nothing(manifest, poisson, folder):
    (folder / "out" / "001.png").write_bytes(b"there")
    ran = poisson("batch", manifest.name, "--dry-run", "--skip-existing", "--report", "report.jsonl")
    assert ran.code == 0
    lines = ran.out.splitlines()
    assert len(lines) == NUMBER
    assert lines[0] == (
        "poisson clone --threads=1 --mask=mask.png --at=0,0 --output=out/000.png -- source.png destination.png"
    )
    assert lines[1].startswith("# there already: poisson clone ")
    assert outputs(folder).keys() == {"001.png"}
    assert not (folder / "report.jsonl").exists()


def test_mistakes_are_all_named_and_nothing_runs(folder, poisson):
    lines = jobs(3)
    lines[0]["at"] = "here"
    lines[2]["maks"] = "mask.png"
    ran = poisson("batch", write(folder, lines).name, "--report", "report.jsonl")
    assert ran.code == 2
    first, second = ran.err.splitlines()
    assert first.startswith("poisson: error: jobs.jsonl:1: Invalid value for '--at': 'here' is not X,Y")
    assert second == 'poisson: error: jobs.jsonl:3: clone has no "maks"; did you mean "mask"?'
    assert outputs(folder) == {}
    assert not (folder / "report.jsonl").exists()


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["--skip-existing", "--overwrite"], 2, "--skip-existing and --overwrite contradict each other"),
        (["--scheduler", "local", "--memory", "1G"], 2, "--memory is for this machine"),
        (["--scheduler", "local", "--timeout", "9"], 2, "--timeout is for this machine"),
        (["--timeout", "0"], 2, "'0' is not a number greater than 0"),
        (["--default", "cycle"], 2, "write it as NAME=VALUE"),
        (["--default", "cycle=X"], 2, "jobs.jsonl:1: Invalid value for '--cycle'"),
        (["--shard", "3/2"], 2, "'3/2' is no share: the first of 2 is 1/2"),
        (["--shard", "half"], 2, "'half' is not I/N"),
        (["--memory", "lots"], 2, "'lots' is no amount of memory"),
        (["--jobs", "0"], 2, "'0' is not a whole number"),
        (["--report", "no/where.jsonl"], 4, "no/where.jsonl: cannot be written"),
    ],
)
def test_choices_that_make_no_sense(manifest, poisson, words, code, text):
    ran = poisson("batch", manifest.name, *words)
    assert ran.code == code
    assert text in ran.err


def test_no_manifest(folder, poisson):
    ran = poisson("batch", "no.jsonl")
    assert (ran.code, ran.err) == (
        3,
        "poisson: error: no.jsonl: cannot be read (No such file or directory)\n",
    )


def test_what_does_not_fit_into_memory_fails_alone(manifest, poisson):
    ran = poisson("batch", manifest.name, "--memory", "64M", "--report", "-")
    lines, summary = report(ran.out)
    assert (ran.code, summary["failed"]) == (1, NUMBER)
    assert {line["exit_code"] for line in lines} == {1}
    assert "MiB lets it run" in lines[0]["error"]


def test_defaults_on_the_command_line(manifest, poisson, folder):
    ran = poisson("batch", manifest.name, "--default", "at=3,4", "--default", "tolerance=.5", "--dry-run")
    assert "--tolerance=.5 " in ran.out
    assert "3,4" not in ran.out.splitlines()[0]  # every line says it itself


# --- stopped ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "code", "said"),
    [(signal.SIGTERM, 143, "terminated"), (signal.SIGINT, 130, "interrupted"), (signal.SIGKILL, -9, None)],
)
def test_stopped_and_begun_again_it_ends_as_if_nothing_had_been(folder, poisson, number, code, said):
    """At a few moments, known by what has been reported; `signal` reaches the batch alone, not its workers."""
    usual = signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # heard by children, wherever this is started
    lines = jobs(40)
    lines[35]["source"] = "slow.png"  # so that it cannot be done before the signal comes
    path = write(folder, lines)
    slow = shutil.copyfile(folder / "source.png", folder / "slow.png")
    expected = by_single_commands(lines)
    moments = random.Random(int(number))
    try:
        for seen in (0, moments.randint(1, 10), moments.randint(11, 25)):
            slow.unlink()
            with endless(slow):
                process = start("batch", path.name, "-j", 2, "--report", "-", cwd=folder)
                for _ in range(seen):
                    process.stdout.readline()
                wait_until(lambda: len(children(process.pid)) >= 2, "no workers")  # noqa: B023
                workers = children(process.pid)
                process.send_signal(number)
                out, err = process.communicate()
            slow.unlink()
            shutil.copyfile(folder / "source.png", slow)
            assert process.returncode == code, err
            wait_until(lambda: not any(map(is_alive, workers)), "workers are left")  # noqa: B023
            made = outputs(folder)
            assert made.items() <= expected.items()
            assert seen <= len(made) < len(lines)
            if said is not None:
                assert err.splitlines()[-1] == f"poisson: error: {said}"
                if seen or out:  # else it was stopped before the report began, while lines were checked
                    assert json.loads(out.splitlines()[-1])["summary"]["exit_code"] == code
            assert poisson("batch", path.name, "--skip-existing", "-j", 2).code == 0
            assert outputs(folder) == expected
            for name in expected:
                (folder / "out" / name).unlink()
    finally:
        signal.signal(signal.SIGINT, usual)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL])
def test_a_signal_to_all_its_processes_leaves_nothing_behind(folder, number):
    """As a terminal, a container and a cluster's scheduler send it."""
    # Heard by children, wherever this is started.
    usual = {
        signal.SIGINT: signal.signal(signal.SIGINT, signal.default_int_handler),
        signal.SIGHUP: signal.signal(signal.SIGHUP, signal.SIG_DFL),
    }
    lines = jobs(200)
    lines[100]["source"] = "pipe.png"  # so that it cannot be done before the signal comes
    path = write(folder, lines)
    with endless(folder / "pipe.png"):
        try:
            process = start("batch", path.name, "-j", 2, "--report", "-", cwd=folder, group=True)
        finally:
            for one, handler in usual.items():
                signal.signal(one, handler)
        process.stdout.readline()
        workers = children(process.pid)
        os.killpg(process.pid, number)
        _, err = process.communicate()
    wait_until(lambda: not any(map(is_alive, workers)), "workers are left")
    codes = {signal.SIGTERM: 143, signal.SIGINT: 130, signal.SIGHUP: 129, signal.SIGKILL: -9}
    assert process.returncode == codes[number]
    assert "Traceback" not in err
    assert outputs(folder).keys() <= {f"{k:03}.png" for k in range(200)}


@pytest.mark.parametrize("heard", [True, False])
def test_a_terminal_that_is_closed(folder, expected, heard):
    """The batch ends; or, if it was told not to hear of that, goes on to its end in silence."""
    lines = jobs(NUMBER)
    if heard:
        lines[-1]["source"] = "pipe.png"  # so that it cannot be done before the terminal is closed
        os.mkfifo(folder / "pipe.png")
    path = write(folder, lines)
    pid, terminal = pty.fork()
    if pid == 0:
        os.chdir(folder)
        signal.signal(signal.SIGHUP, signal.SIG_DFL if heard else signal.SIG_IGN)
        os.execve(
            POISSON[0],
            [*POISSON, "batch", path.name, "-j", "1", "--report", "report.jsonl"],
            {**environment(), "TERM": "xterm"},
        )
    wait_until(lambda: outputs(folder), "no outputs")
    os.close(terminal)
    _, status = os.waitpid(pid, 0)
    _, summary = report((folder / "report.jsonl").read_text())
    assert os.waitstatus_to_exitcode(status) == summary["exit_code"] == (129 if heard else 0)
    assert summary["done"] < NUMBER if heard else outputs(folder) == expected


# --- from Python ------------------------------------------------------------------------------------------------------


def test_from_python(folder):
    write(folder, [])
    lines = jobs(NUMBER)
    expected = by_single_commands(lines)
    results = batch.run([{**line, "at": tuple(line["at"])} for line in lines], workers=2)
    assert {result.output: result.status for result in results} == {line["output"]: "done" for line in lines}
    assert outputs(folder) == expected
    again = list(batch.run(lines, folder=folder, skip_existing=True))
    assert {result.status for result in again} == {"skipped"}
    assert Path(again[0].output) == folder / lines[0]["output"]


SCRIPT = """
from poisson_cli import batch

print("begins", __name__)
jobs = [
    {"tool": "clone", "source": "source.png", "destination": "destination.png", "mask": "mask.png",
     "at": (k % 20, k // 20), "output": f"out/{k:03}.png"}
    for k in range(12)
]
for result in batch.run(jobs, workers=2):
    assert result.status == "done"
"""


@pytest.mark.parametrize("by_name", [True, False])
def test_from_a_script_as_simple_as_can_be(folder, by_name):
    """No worker imports it, so it may do its work wherever it likes, and may have no name."""
    write(folder, [])
    expected = by_single_commands(jobs(NUMBER))
    (folder / "script.py").write_text(SCRIPT)
    ran = subprocess.run(
        [POISSON[0], "script.py" if by_name else "-"],
        cwd=folder,
        env=environment(),
        input=None if by_name else SCRIPT,
        capture_output=True,
        text=True,
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "begins __main__\n", "")
    assert outputs(folder) == expected


def test_from_python_mistakes_come_at_once():
    with pytest.raises(Mistakes) as caught:
        batch.run([{"tool": "fill"}, {"tool": "phil"}])
    assert str(caught.value) == (
        'job:1: "image" is missing; job:2: there is no tool "phil"; there are clone, fill, flatten, focus, heal, mask, '
        "mix, recolor, relight, tile, tonemap"
    )


def test_from_python_closing_stops_the_workers(folder):
    write(folder, [])
    results = batch.run(jobs(NUMBER), workers=2)
    next(results)
    workers = [
        pid for pid in children(os.getpid()) if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()
    ]
    results.close()
    assert not any(map(is_alive, workers))
    assert len(outputs(folder)) < NUMBER
