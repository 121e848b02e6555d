"""A command starts at once only if it loads little: what a plain `clone` may load, and what the help may."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

# Whatever takes milliseconds to import.  A clone needs numpy, its decoder, and what links compiled kernels.
NEEDED = {"click", "numpy", "PIL", "imageio", "llvmlite", "ctypes"}
HEAVY = {
    *NEEDED, "numba", "scipy", "skimage", "tifffile", "imagecodecs", "cv2", "matplotlib", "asyncio", "multiprocessing",
    "unittest", "sqlite3", "http", "ssl", "xml",
}  # fmt: skip

LOADED = """
import json, sys
from poisson_cli.main import run
code = run(sys.argv[1:])
print("\\n" + json.dumps([code, sorted({name.partition(".")[0] for name in sys.modules})]))
"""


def loaded(*words: str) -> set[str]:
    """Top-level modules that a command line has loaded when it is done."""
    ran = subprocess.run(
        [sys.executable, "-c", LOADED, *words],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    code, modules = json.loads(ran.stdout.splitlines()[-1])
    assert code == 0, ran.stderr
    return set(modules)


@pytest.fixture
def warm(poisson):
    assert poisson("warmup", "-q").code == 0


def test_a_clone_loads_nothing_heavy_that_it_does_not_need(folder, warm):
    modules = loaded("clone", "source.png", "destination.png", "-m", "mask.png", "-o", "out.png")
    assert modules & HEAVY <= NEEDED
    assert {"numpy", "llvmlite", "click"} <= modules


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["clone", "--help"]])
def test_the_help_loads_nothing_heavy(words):
    assert loaded(*words) & HEAVY <= {"click"}


def test_warmup_says_where_and_how_large(poisson, warm):
    ran = poisson("warmup")
    assert ran.code == 0
    place, size = ran.out.rstrip().rsplit(": ", 1)
    assert Path(place).is_file()
    assert size.endswith(" KiB")
    assert ran.err == ""
    assert poisson("warmup", "-q").out == ""


def test_the_first_run_says_once_that_it_compiles(monkeypatch, capsys):
    from poisson_cli import compiling
    from solvers.kernels.policy import library

    monkeypatch.setattr(library, "listener", None)
    monkeypatch.setattr(library, "helpers", False)
    compiling.announce(quiet=True)
    assert library.listener is None
    compiling.announce(quiet=False)
    library.listener(None)
    library.listener(7.26)
    assert capsys.readouterr().err.splitlines() == [
        "poisson: compiling the solver for this machine; this is done once",
        "poisson: compiled in 7.3 s",
    ]
