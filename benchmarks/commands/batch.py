"""`python -m benchmarks batch`: many small jobs, as one batch and as a loop of commands.

Clones of about 5,000 pixels on 256 x 256 PNGs, which are painted here. A loop of single commands is timed on some of
them, and reckoned up; the batch does all of them with one worker, and with two; and all that some times in turn. The
outputs are compared, and the memory of the workers is looked at early and late. The processors' time is that of all
processes together: where others are at work as well it says more than the clock.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
from PIL import Image

from benchmarks import machine
from benchmarks.table import duration, render, three

SIDE = 256
UNKNOWNS = 5_000
PICTURES = 16
EARLY = 0.1  # share of the jobs after which memory is looked at for the first time

POISSON = [
    sys.executable,
    "-c",
    "import sys; sys.argv[0] = 'poisson'; from poisson_cli.__main__ import main; main()",
]
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": os.pathsep.join(
        filter(None, (str(Path(__file__).resolve().parents[2]), os.environ.get("PYTHONPATH")))
    ),
}


def run(arguments: Namespace) -> list[str]:
    print(machine.describe(), end="\n\n", flush=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        jobs = make_jobs(folder, arguments.jobs)
        subprocess.run([*POISSON, "warmup", "-q"], env=ENVIRONMENT, check=True)
        return _compare(folder, jobs, arguments.loop, arguments.rounds, arguments.markdown)


def make_jobs(folder: Path, number: int) -> list[dict[str, object]]:
    """Paint the pictures, and write the manifest; what it holds is returned."""
    (folder / "in").mkdir()
    for k in range(PICTURES):
        Image.fromarray(_picture(k)).save(folder / f"in/{k}.png")
    row, col = np.mgrid[:SIDE, :SIDE]
    disk = (row - SIDE // 2) ** 2 + (col - SIDE // 2) ** 2 <= UNKNOWNS / np.pi
    Image.fromarray(disk.astype(np.uint8) * 255).save(folder / "in/mask.png")
    jobs: list[dict[str, object]] = [
        {
            "tool": "clone",
            "source": f"in/{k % PICTURES}.png",
            "destination": f"in/{(k // PICTURES + k + 1) % PICTURES}.png",
            "mask": "in/mask.png",
            "at": [k % 9 - 4, k % 7 - 3],
            "output": f"out/{k:05}.png",
        }
        for k in range(number)
    ]
    (folder / "jobs.jsonl").write_text("".join(f"{json.dumps(job)}\n" for job in jobs))
    return jobs


def _picture(k: int) -> np.ndarray:
    row, col = np.mgrid[:SIDE, :SIDE]
    noise = np.random.default_rng(k).normal(0, 5, (SIDE, SIDE, 3))
    waves = 128 + 60 * np.sin(col / (20 + k % 7) + k) + 40 * np.cos(row / (15 + k % 5))
    return np.clip(waves[..., None] + noise, 0, 255).astype(np.uint8)


def _compare(
    folder: Path, jobs: list[dict[str, object]], looped: int, rounds: int, markdown: bool
) -> list[str]:
    wrong: list[str] = []
    times: dict[int, list[float]] = {0: [], 1: [], 2: []}  # 0: the loop
    busy: dict[int, list[float]] = {0: [], 1: [], 2: []}
    outputs: dict[str, bytes] = {}
    for _ in range(rounds):
        for workers in times:
            before = _processors()
            if workers:
                seconds, memory = _batch(folder, len(jobs), workers)
            else:
                seconds = _loop(folder, jobs[:looped]) / looped * len(jobs)
            times[workers].append(seconds)
            busy[workers].append((_processors() - before) / (1 if workers else looped / len(jobs)))
            found = _outputs(folder)
            if any(outputs.setdefault(name, data) != data for name, data in found.items()):
                wrong.append("one worker, two workers and single commands give different files")
            if workers and len(found) != len(jobs):
                wrong.append(f"{len(found)} outputs of {len(jobs)} jobs")
    names = {
        0: f"loop of commands, {looped} measured",
        1: "poisson batch --jobs 1",
        2: "poisson batch --jobs 2",
    }
    loop, one, two = map(median, times.values())
    against = {0: ["1", ""], 1: [three(loop / one), "1"], 2: [three(loop / two), three(one / two)]}
    rows = [
        [name, _spread(times[workers]), *against[workers], duration(median(busy[workers]))]
        for workers, name in names.items()
    ]
    print(f"Medians of {rounds} interleaved rounds, from the fastest to the slowest one.\n")
    columns = [f"{len(jobs):,} jobs", "time", "x loop", "x one worker", "processors' time"]
    print(render(columns, rows, markdown=markdown))
    early, late = (" + ".join(f"{size / 2**20:.1f}" for size in sizes) for sizes in memory)
    print(f"\nmemory of batch and workers, MiB: {early} after {EARLY:.0%} of the jobs, {late} after all")
    return wrong


def _spread(seconds: list[float]) -> str:
    return f"{duration(median(seconds))} ({three(min(seconds))} to {three(max(seconds))})"


def _loop(folder: Path, jobs: list[dict[str, object]]) -> float:
    """Seconds of one command after the other."""
    _empty(folder / "out")
    start = perf_counter()
    for job in jobs:
        x, y = job["at"]  # type: ignore[misc]
        words = [
            "clone",
            job["source"],
            job["destination"],
            "-m",
            job["mask"],
            f"--at={x},{y}",
            "-o",
            job["output"],
        ]
        subprocess.run([*POISSON, *words, "-q"], cwd=folder, env=ENVIRONMENT, check=True)  # type: ignore[list-item]
    return perf_counter() - start


def _batch(folder: Path, number: int, workers: int) -> tuple[float, tuple[list[int], list[int]]]:
    """Seconds of a batch, and the memory of its processes, early and at the end."""
    _empty(folder / "out")
    words = [*POISSON, "batch", "jobs.jsonl", "--jobs", str(workers), "--report", "-", "-q"]
    early: list[int] = []
    late: list[int] = []
    start = perf_counter()
    with subprocess.Popen(words, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for count, _ in enumerate(process.stdout, start=1):
            if count == max(1, round(EARLY * number)):
                early = list(_resident(process.pid))
            elif count == number - 1:
                late = list(_resident(process.pid))
    seconds = perf_counter() - start
    if process.returncode:
        raise RuntimeError(f"the batch ended with {process.returncode}")
    return seconds, (early, late)


def _processors() -> float:
    """Seconds of all processes that have ended, with those that they have started."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _resident(pid: int) -> Iterator[int]:
    """Resident bytes of a process and of its children that matter, where the system tells (Linux)."""
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        for one in (str(pid), *children):
            status = Path(f"/proc/{one}/status").read_text()
            _, _, resident = status.partition("VmRSS:")  # one that is ending has none any more
            size = 1024 * int(resident.split()[0]) if resident else 0
            if size > 32 << 20:  # what minds the others is small
                yield size
    except OSError:
        return


def _outputs(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "out").iterdir()}


def _empty(folder: Path) -> None:
    """Remove what the last run has written, so that the next one does not pay for it: the disk forgets it now."""
    folder.mkdir(exist_ok=True)
    for path in folder.iterdir():
        path.unlink()
    os.sync()
