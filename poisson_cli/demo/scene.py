"""A scene of the gallery, as data: what to prepare, to run and to show.

Coordinates are X, Y in pixels of the prepared pictures, as image viewers show them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from poisson_cli.demo.command import Command
from poisson_cli.demo.naive import Naive
from poisson_cli.demo.photographs import Photograph
from poisson_cli.demo.shapes import Shape

__all__ = ["PREVIEW", "RESULT", "SHEET", "Panel", "Scene", "Selection"]

RESULT: Final = "result.png"
"""The picture that a scene is about; its last command writes it."""

PREVIEW: Final = "preview.png"
"""The result three times three, of scenes that make a tile."""

SHEET: Final = "sheet.jpg"
"""A JPEG, so that the page can be sent: it is there to be looked at, everything else to be compared bit for bit."""


@dataclass(frozen=True)
class Selection:
    """A selection drawn on one of the scene's pictures.

    Parameters
    ----------
    on
        The picture's file name.
    shapes
        Selected is what any of them covers.
    """

    on: str
    shapes: tuple[Shape, ...]


@dataclass(frozen=True)
class Panel:
    """One picture on a sheet.

    Parameters
    ----------
    label
        What it is, in a word or two.
    note
        One line more about it.
    picture
        Its file name.
    selection
        File name of the mask to outline on it, None for the bare picture.
    crop
        Part to show: left, top, right, bottom in pixels; None for all of it.
    """

    label: str
    note: str
    picture: str
    selection: str | None = None
    crop: tuple[int, int, int, int] | None = None


@dataclass(frozen=True)
class Scene:
    """One example: pictures and selections to prepare, commands to run, and how to show what came of it.

    Parameters
    ----------
    name
        The scene's folder: the tool and a word.
    title
        What happens, for a headline.
    figure
        Where the paper shows or proposes this kind of edit; empty if it does not.
    caption
        What to look at and why it works.
    pictures
        Photographs by the file names they get; all end in ``.png``.
    selections
        Masks by the file names they get.
    naive
        What the last command is compared with, by the file names they get.
    commands
        What to run in order; the last one writes `RESULT`.
    panels
        The sheet, row by row.
    columns
        Panels in a row.
    """

    name: str
    title: str
    figure: str
    caption: str
    pictures: Mapping[str, Photograph]
    selections: Mapping[str, Selection]
    naive: Mapping[str, Naive]
    commands: tuple[Command, ...]
    panels: tuple[Panel, ...]
    columns: int = 2

    @property
    def source(self) -> str:
        """Where the idea comes from."""
        return f"Poisson Image Editing, {self.figure}" if self.figure else "beyond the paper"
