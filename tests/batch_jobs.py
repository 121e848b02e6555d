"""Batches of small jobs, and what their outputs must be: those of single commands."""

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from poisson_cli.main import run as poisson
from tests.small_pictures import save_all

ROOT = Path(__file__).resolve().parent.parent
POISSON = [sys.executable, "-m", "poisson_cli"]


def jobs(number: int) -> list[dict[str, Any]]:
    """Different clones of the small pictures; their outputs go into the folder ``out``."""
    return [
        {
            "tool": "clone",
            "source": "source.png",
            "destination": "destination.png",
            "mask": "mask.png",
            "at": [k % 20, k // 20],
            "output": f"out/{k:03}.png",
        }
        for k in range(number)
    ]


def write(folder: Path, lines: Sequence[Mapping[str, Any]]) -> Path:
    """The manifest, beside the pictures."""
    if not (folder / "out").exists():
        (folder / "out").mkdir()
        save_all(folder)
    path = folder / "jobs.jsonl"
    path.write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    return path


def by_single_commands(lines: Sequence[Mapping[str, Any]]) -> dict[str, bytes]:
    """What single commands write, in the current folder; removed again."""
    made = {}
    for line in lines:
        x, y = line["at"]
        words = [line["tool"], line["source"], line["destination"], "-m", line["mask"], f"--at={x},{y}"]
        assert poisson([*words, "-o", line["output"], "-q"]) == 0
        made[Path(line["output"]).name] = Path(line["output"]).read_bytes()
        Path(line["output"]).unlink()
    return made


def outputs(folder: Path) -> dict[str, bytes]:
    """All that is in the folder ``out``, hidden files as well."""
    return {path.name: path.read_bytes() for path in (folder / "out").iterdir()}


def environment() -> dict[str, str]:
    """Lets processes find the package wherever they run."""
    return {**os.environ, "PYTHONPATH": str(ROOT)}


def start(*words: object, cwd: Path, group: bool = False) -> subprocess.Popen[str]:
    """The program as a process of its own, and if asked for leader of a group of processes."""
    return subprocess.Popen(
        [*POISSON, *map(str, words)],
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(),
        start_new_session=group,
    )


def report(text: str) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """The lines of a report in the order of the jobs, and its summary."""
    *lines, last = (json.loads(line) for line in text.splitlines())
    return sorted(lines, key=lambda line: line["job"]), last["summary"]


def children(pid: int) -> list[int]:
    """Processes that a process has started (Linux)."""
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


@contextlib.contextmanager
def endless(pipe: Path) -> Iterator[int]:
    """Make a named pipe and keep it open for writing, so that whoever reads from it waits; what is yielded writes."""
    os.mkfifo(pipe)
    descriptor = os.open(pipe, os.O_RDWR)  # waits for nobody
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def reader(pipe: Path, *, but: Collection[int] = ()) -> int:
    """Wait for a process that has a named pipe open, beside this one and some others (Linux)."""
    found: list[int] = []

    def look() -> bool:
        for link in Path("/proc").glob("[0-9]*/fd/*"):
            pid = int(link.parts[2])
            try:
                if pid not in (os.getpid(), *but) and os.path.samefile(link, pipe):
                    found.append(pid)
            except OSError:  # it is gone, or another user's
                continue
        return bool(found)

    wait_until(look, "nobody reads")
    return found[0]


def is_alive(pid: int) -> bool:
    """Whether a process runs; one that is dead and not yet buried does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_until(condition: Any, what: str) -> None:
    deadline = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)
