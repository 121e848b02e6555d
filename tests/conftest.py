"""Fixtures for tests of the command line: a folder with small pictures, and a way to run `poisson` there."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from tests import small_pictures


class Ran(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, holding the pictures of `small_pictures`."""
    small_pictures.save_all(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def poisson(capsys: pytest.CaptureFixture[str]) -> Callable[..., Ran]:
    """Runs a command line in this process: ``poisson("fill", "a.png", ...)``."""
    from poisson_cli.main import run

    def poisson(*words: object) -> Ran:
        capsys.readouterr()
        code = run([str(word) for word in words])
        return Ran(code, *capsys.readouterr())

    return poisson
