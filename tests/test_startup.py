"""A command starts at once only if it loads little: what a plain `clone` may load, and what the help may."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from solvers.native import image

ROOT = Path(__file__).resolve().parent.parent

# Whatever takes milliseconds to import.  A clone of PNG files needs numpy, one decoder, and what calls compiled code.
NEEDED = {"click", "numpy", "PIL", "ctypes", "mmap"}
# Where the system's objects are of a kind that is not known, LLVM links compiled kernels.
NEEDED |= set() if image.possible() else {"llvmlite"}
HEAVY = {
    *NEEDED, "numba", "llvmlite", "imageio", "scipy", "skimage", "tifffile", "imagecodecs", "cv2", "matplotlib",
    "asyncio", "multiprocessing", "concurrent", "unittest", "sqlite3", "http", "ssl", "xml", "email", "subprocess",
    "json", "hashlib", "random", "secrets", "shutil", "tempfile", "zipfile",
}  # fmt: skip

LOADED = """
import sys
from poisson_cli.main import run
code = run(sys.argv[1:])
loaded = sorted(sys.modules)
import json
print("\\n" + json.dumps([code, loaded]))
"""


def python(program: str, *words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-c", program, *words],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )


def loaded(*words: str) -> set[str]:
    """Modules that a command line has loaded when it is done."""
    ran = python(LOADED, *words)
    code, modules = json.loads(ran.stdout.splitlines()[-1])
    assert code == 0, ran.stderr
    return set(modules)


def packages(modules: set[str]) -> set[str]:
    return {name.partition(".")[0] for name in modules}


@pytest.fixture
def warm(poisson):
    assert poisson("warmup", "-q").code == 0


def test_a_clone_loads_nothing_heavy_that_it_does_not_need(folder, warm):
    modules = loaded("clone", "source.png", "destination.png", "-m", "mask.png", "-o", "out.png")
    assert packages(modules) & HEAVY <= NEEDED
    assert {"numpy", "PIL.PngImagePlugin", "click"} <= modules
    assert {name for name in modules if name.startswith("PIL.") and name.endswith("Plugin")} == {
        "PIL.PngImagePlugin"
    }


def test_other_formats_load_more(folder, warm):
    """The list above can fail."""
    modules = loaded("clone", "source.png", "destination.png", "-m", "mask.png", "-o", "out.bmp")
    assert {"imageio", "PIL.BmpImagePlugin"} <= modules


DEPTH = """
import sys
class Watch:
    def find_spec(self, name, *_):
        if name == "numpy":
            frame, depth = sys._getframe(), 0
            while frame := frame.f_back:
                depth += "importlib" not in frame.f_code.co_filename
            print(depth)
sys.meta_path.insert(0, Watch())
from poisson_cli.main import run
sys.exit(run(sys.argv[1:]))
"""


def test_numpy_is_imported_with_next_to_no_stack_below_it(folder, warm):
    """Below click's frames its import takes a third longer; see `poisson_cli.attended`."""
    words = ("clone", "source.png", "destination.png", "-m", "mask.png", "-o", "out.png")
    ran = python(DEPTH, *words)
    assert ran.returncode == 0, ran.stderr
    [depth] = map(int, ran.stdout.split())
    assert depth < 10


VOLUMES = """
import json
import sys
from poisson_cli.main import run
from solvers.kernels.policy import library
for words in json.loads(sys.argv[1]):
    assert run(words) == 0, words
print(json.dumps(list(library._addresses)))
"""


def test_what_most_runs_need_is_in_one_volume(folder, warm):
    """Otherwise a first run compiles twice as long as it has to."""
    two, one, area = ["source.png", "destination.png"], ["destination.png"], ["--rect", "3,3,20,17"]
    tools = [
        ["clone", *two, *area],
        ["clone", *two, *area, "--monochrome", "--focus", "1.5"],
        ["mix", *two, *area],
        ["heal", *one, *area, "--from", "20,5"],
        ["relight", *one, *area],
        ["recolor", *one, *area, "--hue", "40"],
        ["focus", *one, *area, "--amount", "2"],
        ["tile", *one, *area],
        *(["fill", *one, *rectangle] for rectangle in (area, ["--rect", "1,1,46,38"], ["--rect", "0,0,9,9"])),
    ]
    tools.append(["fill", *one, *area, "--bit-depth", "16"])
    jobs = [[*words, "-q", "-o", f"{k}.png"] for k, words in enumerate(tools)]
    ran = python(VOLUMES, json.dumps(jobs))
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout) == ["usual"]


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["clone", "--help"]])
def test_the_help_loads_nothing_heavy(words):
    assert packages(loaded(*words)) & HEAVY <= {"click", "shutil"}  # click asks how wide the terminal is


def test_warmup_says_where_and_how_large(poisson, warm):
    ran = poisson("warmup")
    assert ran.code == 0
    lines = ran.out.splitlines()
    assert len(lines) == 2
    for line in lines:
        place, size = line.rsplit(": ", 1)
        assert Path(place).is_file()
        assert size.endswith(" KiB")
    assert poisson("warmup").err == ""
    assert poisson("warmup", "-q").out == ""


def test_the_first_run_says_once_that_it_compiles(monkeypatch, capsys):
    from poisson_cli import compiling
    from solvers.kernels.policy import library

    monkeypatch.setattr(library, "listener", None)
    monkeypatch.setattr(library, "helpers", False)
    compiling.announce(quiet=True)
    assert library.listener is None
    monkeypatch.setattr(library, "unkept", None)
    monkeypatch.setattr(library, "trouble", None)
    compiling.announce(quiet=False)
    library.listener("usual", None)
    library.listener("usual", 7.26)
    library.listener("further", None)
    library.trouble = "BuildError: no"
    library.listener("further", 1)
    library.unkept = "/there is not writable"
    library.listener("usual", None)
    assert capsys.readouterr().err.splitlines() == [
        "poisson: compiling the solver for this machine; this is done once",
        "poisson: compiled in 7.3 s",
        "poisson: compiling the solver for selections or pictures of this kind; this is done once",
        "poisson: that failed after 1.0 s (BuildError: no); numba does it, and each run begins more slowly",
        "poisson: compiling the solver for this machine; again at the next run, for it cannot be kept "
        "(/there is not writable); name another folder in POISSON_CACHE_DIR",
    ]


@pytest.mark.parametrize(
    "words", [("fill", "destination.png", "--rect", "9,9,9,9", "-o", "out.png"), ("warmup",)]
)
def test_a_way_to_run_kernels_that_is_none_is_refused(poisson, folder, monkeypatch, words):
    monkeypatch.setenv("POISSON_KERNELS", "fast")
    ran = poisson(*words)
    assert (ran.code, ran.out) == (3, "")
    assert ran.err == (
        "poisson: error: POISSON_KERNELS is 'fast', but must be one of native, numba, python\n"
    )


def test_warmup_compiles_nothing_that_it_cannot_keep(poisson, monkeypatch, tmp_path):
    place = tmp_path / "open"
    place.mkdir()
    place.chmod(0o777)
    monkeypatch.setenv("POISSON_CACHE_DIR", str(place))
    ran = poisson("warmup")
    assert (ran.code, ran.out) == (4, "")
    assert ran.err == (
        f"poisson: error: the solver is not compiled, for it cannot be kept ({place} can be written to by others); "
        "name another folder in POISSON_CACHE_DIR\n"
    )
    assert not list(place.iterdir())
