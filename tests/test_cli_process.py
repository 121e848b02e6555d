"""`poisson` as a process of its own: start-up, signals, pipes."""

import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import pytest

import poisson_cli

REPOSITORY = Path(__file__).resolve().parent.parent
POISSON = [sys.executable, "-m", "poisson_cli"]


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets child processes find the package wherever they run."""
    paths = [str(REPOSITORY), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, paths)))


def poisson(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*POISSON, *words], capture_output=True, text=True)


HEAVY = {"numpy", "numba", "imageio", "PIL", "solvers", "poisson_cli.editing", "poisson_cli.images"}


@pytest.mark.parametrize(
    "words",
    [
        ["--help"],
        ["--version"],
        ["clone", "--help"],
        ["mix", "-h"],
        ["fill", "--help"],
        ["flatten", "--help"],
        ["tile", "--help"],
        ["demo", "--help"],
        ["fill"],
    ],
    ids=" ".join,
)
def test_words_about_itself_load_nothing_heavy(words):
    script = (
        "import sys\n"
        "from poisson_cli.main import run\n"
        f"code = run({words!r})\n"
        f"print('LOADED', *sorted({HEAVY!r} & set(sys.modules)))\n"
        "sys.exit(code)"
    )
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert ran.stdout.splitlines()[-1] == "LOADED"
    assert ran.returncode == (2 if words == ["fill"] else 0)


def test_the_package_alone_loads_nothing_heavy():
    script = f"import sys, poisson_cli; poisson_cli.InputError; sys.exit(bool({HEAVY!r} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0


def test_help_lists_every_command_by_its_file():
    ran = poisson("--help")
    assert ran.returncode == 0
    files = (REPOSITORY / "poisson_cli" / "commands").glob("[!_]*.py")
    listed = ran.stdout.partition("Commands:\n")[2].splitlines()
    assert [line.split()[0] for line in listed] == sorted(file.stem for file in files)
    assert all(len(line.split()) > 3 for line in listed)


def test_version():
    assert poisson("--version").stdout == f"poisson, version {poisson_cli.__version__}\n"


@pytest.mark.parametrize("command", ["clone", "flatten", "tonemap"])
def test_help_has_an_example_and_the_defaults(command):
    text = poisson(command, "--help").stdout
    assert f"\n    poisson {command} " in text
    flat = " ".join(text.split())
    for default in ("rgb", "multigrid", "F", "0.0002", *(["128"] if command != "tonemap" else [])):
        assert f"[default: {default}]" in flat


def test_exit_codes_reach_the_shell(folder):
    assert poisson("fill", "grey.png", "--rect", "1,1,9,9", "-o", "out.png").returncode == 0
    assert poisson("fill", "grey.png", "-o", "out.png").returncode == 2
    assert poisson("fill", "no.png", "--rect", "1,1,9,9", "-o", "new.png").returncode == 3
    assert poisson("fill", "grey.png", "--rect", "1,1,9,9", "-o", "out.png").returncode == 4


def writing_to(pipe: str, process: subprocess.Popen[str]) -> BinaryIO:
    """The writing end of a pipe, as soon as a process has come as far as to read from the other end."""
    while process.poll() is None:
        try:
            return open(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK), "wb")
        except (
            OSError
        ) as error:  # nobody reads yet; to wait in open() would be to wait for ever if nobody ever does
            assert error.errno == errno.ENXIO
            time.sleep(0.01)
    raise AssertionError(f"ended early: {process.communicate()}")


@pytest.fixture
def heard_signals() -> Iterator[None]:
    """Child processes hear signals even if this process was started in the background, deaf to them."""
    numbers = (signal.SIGINT, signal.SIGHUP)
    usual = [signal.signal(number, signal.default_int_handler) for number in numbers]
    yield
    for number, handler in zip(numbers, usual, strict=True):
        signal.signal(number, handler)


@pytest.mark.parametrize(
    ("number", "code", "text"),
    [
        (signal.SIGINT, 130, "poisson: error: interrupted\n"),
        (signal.SIGTERM, 143, "poisson: error: terminated\n"),
        (signal.SIGHUP, 129, ""),
    ],
)
def test_a_signal_ends_it_with_its_own_code(folder, number, code, text, heard_signals):
    os.mkfifo("pipe")
    words = [*POISSON, "fill", "pipe", "--rect", "1,1,9,9", "-o", "out.png"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process, writing_to("pipe", process):
        err = None
        while err is None:
            process.send_signal(number)
            try:
                _, err = process.communicate(timeout=5)
            except subprocess.TimeoutExpired:  # it came just before the process fell asleep: say it again
                continue
    assert (process.returncode, err) == (code, text)
    assert not Path("out.png").exists()


def test_a_picture_can_come_through_a_pipe(folder):
    os.mkfifo("pipe")
    words = [*POISSON, "fill", "pipe", "--rect", "1,1,9,9", "-o", "out.png"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        with writing_to("pipe", process) as pipe:
            pipe.write(Path("grey.png").read_bytes())
        process.communicate()
    assert process.returncode == 0
    assert Path("out.png").exists()


@pytest.fixture(params=["buffered", "unbuffered"])
def buffering(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python meets a closed pipe when it prints, or not before it ends."""
    monkeypatch.setenv("PYTHONUNBUFFERED", "1" if request.param == "unbuffered" else "")


def with_closed_stdout(*words: str) -> subprocess.CompletedProcess[str]:
    """Runs a command whose stdout nobody reads any more."""
    read, write = os.pipe()
    os.close(read)
    try:
        return subprocess.run([*POISSON, *words], stdout=write, stderr=subprocess.PIPE, text=True)
    finally:
        os.close(write)


def test_nobody_reading_the_help_is_quiet(buffering):
    ran = with_closed_stdout("--help")
    assert (ran.returncode, ran.stderr) == (141, "")


def test_nobody_reading_the_report_is_no_failure(folder, buffering):
    ran = with_closed_stdout("fill", "grey.png", "--rect", "1,1,9,9", "-o", "out.png", "--json", "-q")
    assert (ran.returncode, ran.stderr) == (0, "")
    assert Path("out.png").exists()


def test_the_shell_completes_words(monkeypatch):
    monkeypatch.setenv("_POISSON_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "poisson cl")
    monkeypatch.setenv("COMP_CWORD", "1")
    assert poisson().stdout == "plain,clone\n"
    monkeypatch.setenv("COMP_WORDS", "poisson clone pict")
    monkeypatch.setenv("COMP_CWORD", "2")
    assert poisson().stdout == "file,pict\n"
