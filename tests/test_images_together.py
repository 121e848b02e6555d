"""Several outputs: all of them are written, or every file is as it was."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from poisson_cli.errors import OutputError
from poisson_cli.images import Picture, prepare, refuse_doubles, write_together
from poisson_cli.images import together as together_module
from tests.small_pictures import load

PICTURES = [Picture(f"{value}", np.full((3, 4), value, np.uint8)) for value in (10, 20, 30)]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def outputs(folder: Path, *, overwrite: bool) -> list:
    return [(prepare(folder / f"{picture.name}.png", overwrite=overwrite), picture) for picture in PICTURES]


@pytest.mark.parametrize("old", [[], ["10"], ["10", "20", "30"]])
def test_all_are_written(tmp_path, old):
    for name in old:
        (tmp_path / f"{name}.png").write_bytes(b"old")
    write_together(outputs(tmp_path, overwrite=True))
    assert set(contents(tmp_path)) == {"10.png", "20.png", "30.png"}
    for picture in PICTURES:
        np.testing.assert_array_equal(load(tmp_path / f"{picture.name}.png"), picture.pixels)


@pytest.mark.parametrize("links", [True, False], ids=["with hard links", "without"])
@pytest.mark.parametrize("old", [[], ["10"], ["20"], ["10", "20", "30"]])
@pytest.mark.parametrize("last", [1, 2])
@pytest.mark.parametrize("error", [OutputError("full"), KeyboardInterrupt()], ids=["error", "signal"])
def test_one_that_fails_undoes_the_others(tmp_path, monkeypatch, old, last, links, error):
    for name in old:
        (tmp_path / f"{name}.png").write_bytes(b"old " + name.encode())
    before = contents(tmp_path)
    planned = outputs(tmp_path, overwrite=True)
    real = together_module.write

    def write(target, picture, before_commit):
        if target is planned[last][0]:
            raise error
        real(target, picture, before_commit)

    def no_links(*_, **__):
        raise OSError(errno.EPERM, "not here")

    monkeypatch.setattr(together_module, "write", write)
    if not links:
        monkeypatch.setattr(os, "link", no_links)
    with pytest.raises(type(error)):
        write_together(planned)
    assert contents(tmp_path) == before


def test_a_file_that_appears_meanwhile_is_left_alone_and_the_others_undone(tmp_path):
    planned = outputs(tmp_path, overwrite=False)
    (tmp_path / "20.png").write_bytes(b"someone else's")
    with pytest.raises(OutputError, match=r"20\.png: appeared while we were at work"):
        write_together(planned)
    assert contents(tmp_path) == {"20.png": b"someone else's"}


def test_one_file_cannot_be_two_outputs(tmp_path):
    (tmp_path / "b.png").symlink_to("a.png")
    targets = [prepare(tmp_path / name, overwrite=False) for name in ("a.png", "c.png", "b.png")]
    refuse_doubles(targets[:2])
    with pytest.raises(OutputError, match=r"b\.png: two outputs would go into this file"):
        refuse_doubles(targets)


def test_nothing_to_write_is_no_error():
    write_together([])
