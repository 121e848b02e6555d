"""Folders and files that may not be read or written, with the system itself saying so, to root as well.

Root may do anything because of its capabilities. A process that drops them for its children is held to the modes of
files as everybody is; as nobody else may drop them, nobody else needs to.
"""

import ctypes
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.small_pictures import MASK, SOURCE, load

REPOSITORY = Path(__file__).resolve().parent.parent
PR_CAPBSET_DROP = 24
CAPABILITIES = {"CAP_DAC_OVERRIDE": 1, "CAP_DAC_READ_SEARCH": 2}
OLD = b"precious"


def as_anybody() -> None:
    system = ctypes.CDLL(None)
    for capability in CAPABILITIES.values():
        system.prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)


def fill(source: str, output: str, *more: str) -> tuple[int, str]:
    ran = subprocess.run(
        [sys.executable, "-m", "poisson_cli", "fill", source, "-m", "mask.png", "-o", output, "-q", *more],
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        capture_output=True,
        preexec_fn=as_anybody,
        text=True,
        timeout=60,
    )
    return ran.returncode, ran.stderr


@pytest.fixture
def locked(folder):
    """A folder with a file in it, that may not be written."""
    (folder / "locked").mkdir()
    (folder / "locked" / "old.png").write_bytes(OLD)
    (folder / "locked").chmod(0o555)
    yield folder / "locked"
    (folder / "locked").chmod(0o755)


@pytest.mark.parametrize("name", ["new.png", "old.png"])
def test_a_folder_that_may_not_be_written(locked, name):
    assert fill("source.png", f"locked/{name}", "--overwrite") == (
        4,
        f"poisson: error: locked/{name}: the folder {locked} is not writable\n",
    )
    assert {path.name: path.read_bytes() for path in locked.iterdir()} == {"old.png": OLD}


def test_a_folder_that_may_not_be_entered(locked):
    locked.chmod(0)
    assert fill("source.png", "locked/new.png") == (
        4,
        "poisson: error: locked/new.png: cannot be written (Permission denied)\n",
    )


def test_a_file_that_may_not_be_written_is_not_replaced(folder):
    """Its folder would let it be."""
    (folder / "old.png").write_bytes(OLD)
    (folder / "old.png").chmod(0o444)
    assert fill("source.png", "old.png", "--overwrite") == (
        4,
        "poisson: error: old.png: exists, and is protected against writing; choose another name\n",
    )
    assert (folder / "old.png").read_bytes() == OLD
    assert fill("source.png", "new.png") == (0, "")
    assert (load("new.png")[~MASK] == SOURCE[~MASK]).all()


def test_a_file_that_may_not_be_read(folder):
    (folder / "source.png").chmod(0)
    assert fill("source.png", "new.png") == (
        3,
        "poisson: error: source.png: cannot be read (Permission denied)\n",
    )
    assert not (folder / "new.png").exists()
