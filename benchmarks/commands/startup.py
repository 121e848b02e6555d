"""`python -m benchmarks startup`: whole processes, from the shell's point of view.

The paper's size, a disk of 60,000 pixels on 512 x 512 PNGs, cloned by `poisson clone` with kernels loaded from the
cache, with kernels that numba caches itself, and by a script of five lines with OpenCV; beside what importing costs.
Then the first run, with an empty cache, and twenty of them at once.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter

import numpy as np
from PIL import Image

from benchmarks import machine
from benchmarks.table import duration, render, three
from benchmarks.timing import Timing

SIDE = 512
UNKNOWNS = 60_000
AT_ONCE = 20

OPENCV = """
import cv2
source, destination, mask = (cv2.imread(name) for name in ("source.png", "destination.png", "mask.png"))
result = cv2.seamlessClone(source, destination, mask, (256, 256), cv2.NORMAL_CLONE)
cv2.imwrite("opencv.png", result)
"""

POISSON = "import sys; from poisson_cli.__main__ import main; sys.argv[0] = 'poisson'; main()"
CLONE = ["clone", "source.png", "destination.png", "-m", "mask.png", "--overwrite", "-o"]

Command = tuple[list[str], Mapping[str, str]]  # words, and variables of its own


def run(arguments: Namespace) -> list[str]:
    print(machine.describe(), end="\n\n", flush=True)
    with tempfile.TemporaryDirectory() as name:
        bench = _Bench(Path(name))
        bench.paint()
        wrong = bench.first_run()
        bench.warm()
        wrong += bench.rows(arguments.rounds, arguments.markdown)
        wrong += bench.at_once()
    return wrong


class _Bench:
    """Processes in one folder, with caches of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        ours = str(Path(__file__).resolve().parents[2])
        inherited = {
            k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE" and not _threads(k)
        }
        path = os.pathsep.join(filter(None, (ours, os.environ.get("PYTHONPATH"))))
        self.environment = {
            **inherited,
            "PYTHONPATH": path,
            "PYTHONPYCACHEPREFIX": str(folder / "pycache"),
            "POISSON_CACHE_DIR": str(folder / "cache"),
            "NUMBA_CACHE_DIR": str(folder / "numba"),
        }

    def start(self, command: Command) -> subprocess.Popen[str]:
        words, variables = command
        return subprocess.Popen(
            words,
            cwd=self.folder,
            env={**self.environment, **variables},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def time(self, command: Command) -> tuple[float, str]:
        """Seconds, and what it said on stderr."""
        start = perf_counter()
        process = self.start(command)
        _, said = process.communicate()
        seconds = perf_counter() - start
        if process.returncode:
            raise RuntimeError(f"{' '.join(command[0])}: exit code {process.returncode}: {said}")
        return seconds, said

    def paint(self) -> None:
        """Two pictures with texture, and the disk."""
        row, col = np.mgrid[:SIDE, :SIDE]
        for seed, name in enumerate(("source", "destination")):
            noise = np.random.default_rng(seed).normal(0, 6, (SIDE, SIDE, 3))
            waves = [
                128 + 60 * np.sin(col / (30 + 10 * c) + seed) + 50 * np.cos(row / (25 + 7 * c))
                for c in range(3)
            ]
            pixels = np.clip(np.stack(waves, -1) + noise, 0, 255).astype(np.uint8)
            Image.fromarray(pixels).save(self.folder / f"{name}.png")
        disk = (row - SIDE // 2) ** 2 + (col - SIDE // 2) ** 2 <= UNKNOWNS / np.pi
        Image.fromarray(disk.astype(np.uint8) * 255).save(self.folder / "mask.png")

    def first_run(self) -> list[str]:
        """No kernels: first without Python's own bytecode either, then with it, as an installation by pip leaves it."""
        bare, _ = self.time(_poisson(*CLONE, "bare.png"))
        shutil.rmtree(self.folder / "cache")
        seconds, said = self.time(_poisson(*CLONE, "first.png"))
        print(
            f"first run, empty cache: {duration(seconds)} ({duration(bare)} without bytecode, from a checkout)"
        )
        print("it says\n")
        print("\n".join(f"    {line}" for line in said.splitlines()), end="\n\n", flush=True)
        return [] if "compil" in said else ["the first run does not say that it compiles"]

    def warm(self) -> None:
        self.time(_numba(*CLONE, "numba.png"))

    def rows(self, rounds: int, markdown: bool) -> list[str]:
        """The table: medians of interleaved processes."""
        python = sys.executable
        commands: dict[str, Command] = {
            "python -c pass": ([python, "-c", "pass"], {}),
            "import click": ([python, "-c", "import click"], {}),
            "poisson --version": _poisson("--version"),
            "poisson --help": _poisson("--help"),
            "completion": _poisson(_POISSON_COMPLETE="bash_complete", COMP_WORDS="poisson c", COMP_CWORD="1"),
            "import click, numpy, imageio.v3": ([python, "-c", "import click, numpy, imageio.v3"], {}),
            "poisson clone": _poisson(*CLONE, "out.png"),
            "poisson clone, plain numba": _numba(*CLONE, "numba.png"),
        }
        if importlib.util.find_spec("cv2"):
            commands["OpenCV, five lines"] = ([python, "-c", OPENCV], {})
        timings = {name: Timing() for name in commands}
        names = list(commands)
        for visit in range(rounds):
            turn = visit % len(names)
            for name in names[turn:] + names[:turn]:
                timings[name].seconds.append(self.time(commands[name])[0])
        click, imports = timings["import click"].median, timings["import click, numpy, imageio.v3"].median
        rows = [
            [
                name,
                duration(t.median),
                duration(t.fastest),
                three(t.median / click),
                three(t.median / imports),
            ]
            for name, t in timings.items()
        ]
        print(
            render(["whole process", "median", "min", "x click", "x imports"], rows, markdown=markdown),
            flush=True,
        )
        print("\n" + "\n".join(_ratios({name: t.median for name, t in timings.items()})), flush=True)
        ours, plain = ((self.folder / name).read_bytes() for name in ("out.png", "numba.png"))
        return [] if ours == plain else ["loaded kernels and plain numba give different pictures"]

    def at_once(self) -> list[str]:
        """Many first runs side by side."""
        cache = self.folder / "crowded"
        start = perf_counter()
        crowd = [
            self.start(_poisson(*CLONE, f"crowd{k}.png", POISSON_CACHE_DIR=str(cache)))
            for k in range(AT_ONCE)
        ]
        said = [process.communicate()[1] for process in crowd]
        seconds = perf_counter() - start
        codes = {process.returncode for process in crowd}
        pictures = {path.read_bytes() for path in self.folder.glob("crowd*.png")}
        compiled = sum("compil" in text for text in said)
        print(f"\n{AT_ONCE} first runs at once: {duration(seconds)}, {compiled} of them compiled")
        wrong = []
        if codes != {0}:
            wrong.append(f"of {AT_ONCE} processes at once some failed: {codes}")
        if pictures != {(self.folder / "out.png").read_bytes()}:
            wrong.append("processes at once give different pictures")
        return wrong


def _ratios(medians: Mapping[str, float]) -> list[str]:
    """What is asked of start-up, and what was found."""
    wanted = (
        ("poisson clone", "import click, numpy, imageio.v3", 1.6),
        ("poisson clone", "poisson clone, plain numba", 1 / 3),
        ("poisson clone", "OpenCV, five lines", 1.0),
        ("poisson --help", "import click", 1.3),
        ("poisson --version", "import click", 1.3),
        ("completion", "import click", 1.3),
    )
    return [
        f"{ours} takes {three(medians[ours] / medians[other])} of {other} ({three(most)} at most is wanted)"
        for ours, other, most in wanted
        if other in medians
    ]


def _poisson(*words: str, **variables: str) -> Command:
    return [sys.executable, "-c", POISSON, *words], variables


def _numba(*words: str) -> Command:
    return _poisson(*words, POISSON_KERNELS="numba")


def _threads(variable: str) -> bool:
    """What `benchmarks.__main__` sets for others: a shell has none of these."""
    return variable.endswith(("_NUM_THREADS", "_MAXIMUM_THREADS"))
