"""The gallery: every tool at work on photographs, made by real command lines.

A scene (`scenes`) names the photographs and selections to prepare, the commands to run and the naive ways (`naive`) to
compare them with. This module prepares, runs and shows them, and knows nothing of any tool: a new scene is one more
entry there.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.demo import photographs
from poisson_cli.demo.page import Exhibit, write_page
from poisson_cli.demo.scene import PREVIEW, RESULT, SHEET, Panel, Scene
from poisson_cli.demo.scenes import SCENES
from poisson_cli.demo.shapes import draw_mask
from poisson_cli.demo.sheet import Cell, draw_sheet
from poisson_cli.errors import InputError, NotConverged, OutputError, PoissonError
from poisson_cli.images import Picture, prepare, read, write
from poisson_cli.images.writing import save

__all__ = ["run"]

_INDEX: Final = "index.html"

_KINDS: Final[tuple[type[PoissonError], ...]] = (InputError, OutputError, NotConverged)
"""The errors that have an exit code of their own."""


def run(directory: Path, overwrite: bool) -> None:
    """Make the gallery, saying on stdout what is done.

    Parameters
    ----------
    directory
        Where to; it is made if it is not there.
    overwrite
        Whether the folder may have something in it already. Files of an earlier gallery are replaced, any others are
        left alone.

    Raises
    ------
    InputError
        If scikit-image, which brings the photographs, or OpenCV, which finds edges, is not installed.
    OutputError
        If the gallery cannot be written.
    PoissonError
        If one of the commands fails, with its exit code.
    """
    files = photographs.folder()
    if importlib.util.find_spec("cv2") is None:
        raise InputError(
            "the demo finds edges with OpenCV, which is not installed: pip install 'poisson-cli[demo]'"
        )
    try:
        if directory.is_dir() and not overwrite and any(directory.iterdir()):
            raise OutputError(
                f"{directory}: there is something in this folder; add --overwrite to replace an earlier gallery, "
                "or choose another name"
            )
        directory.mkdir(parents=True, exist_ok=True)
        exhibits = [_make(scene, directory / scene.name, files) for scene in SCENES]
        save(write_page(exhibits).encode(), (directory / _INDEX).resolve(), overwrite=True)
    except BrokenPipeError:  # stdout, not the folder
        raise
    except OSError as error:
        raise OutputError(f"{directory}: cannot be written ({error.strerror or error})") from error
    print(f"Done. Open {directory / _INDEX} in a browser.")


def _make(scene: Scene, folder: Path, files: Path) -> Exhibit:
    """Prepare a scene in its folder, run its commands and draw its sheet."""
    print(f"{scene.title} ({scene.figure or scene.source})", flush=True)
    folder.mkdir(exist_ok=True)
    for name, photograph in scene.pictures.items():
        _write(folder / name, photographs.load(photograph, files))
    masks = {}
    for name, selection in scene.selections.items():
        height, width = read(folder / selection.on).shape
        masks[name] = draw_mask(selection.shapes, height, width)
        _write(folder / name, np.where(masks[name], np.uint8(255), np.uint8(0)))
    lines = tuple(command.line(folder) for command in scene.commands)
    for command, line in zip(scene.commands, lines, strict=True):
        _run(command.argv(folder), line)
    for name, naive in scene.naive.items():
        _write(folder / name, naive.draw(scene.commands[-1], lambda file: read(folder / file).pixels, masks))
    cells = [_cell(panel, folder, masks) for panel in scene.panels]
    sheet = draw_sheet(scene.title, scene.source, cells, scene.columns)
    _write(folder / SHEET, sheet)
    outputs = (output for command in scene.commands for output in command.outputs)
    return Exhibit(
        scene=scene,
        lines=lines,
        files=(*scene.pictures, *scene.selections, *outputs, *scene.naive),
        sheet_size=(sheet.shape[1], sheet.shape[0]),
    )


def _run(argv: list[str], line: str) -> None:
    """Run one command line as the shell would, or raise what its exit code stands for."""
    from poisson_cli import main  # imports click, which only whoever runs commands needs

    print(f"  {line}", flush=True)
    code = main.run(argv)
    if code:
        kind = {kind.exit_code: kind for kind in _KINDS}.get(code, PoissonError)
        raise kind(f"the demo stops here, because this failed: {line}")


def _cell(panel: Panel, folder: Path, masks: dict[str, NDArray[np.bool_]]) -> Cell:
    """Fetch what a panel shows."""
    pixels = read(folder / panel.picture).pixels
    mask = None if panel.selection is None else masks[panel.selection]
    if panel.crop is not None:
        left, top, right, bottom = panel.crop
        pixels = pixels[top:bottom, left:right]
        mask = None if mask is None else mask[top:bottom, left:right]
    return Cell(panel.label, panel.note, pixels, mask, result=panel.picture in (RESULT, PREVIEW))


def _write(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a picture, replacing an older one."""
    write(prepare(path, overwrite=True), Picture(str(path), pixels))
