"""A file that says which pixels: a picture, annotations, or the corners of a polygon; what it holds tells which.

``FILE`` may be followed by a colon and the part of it that is meant::

    mask.png:alpha  mask.png:red  mask.png:green  mask.png:blue    a channel of a picture
    mask.png:index=3                                               an entry of its palette, or a grey value
    bird.json:wing                                                 a label of labelme, a category of COCO
    coco.json:1768                                                 one annotation of COCO, by its id

A file that has the whole as its name, colon included, wins.
"""

from __future__ import annotations

import codecs
import os
import re
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.images import read_bytes
from poisson_cli.images.formats import listed, recognise
from poisson_cli.masks.canvas import Canvas
from poisson_cli.masks.points import parse_points
from poisson_cli.masks.raster import count_near, decode_strength
from poisson_cli.masks.shapes import draw_polygon
from poisson_cli.settings import MaskFile, Polygon
from poisson_cli.streams import STANDARD

__all__ = ["Drawn", "decode_mask", "locate", "read_mask"]

_HEADING: Final = r"^[\"']?x[\"']?\s*,\s*[\"']?y[\"']?[ \t]*\r?\n"
"""What a spreadsheet calls its columns."""

_NUMBERS: Final = tuple("+-.#0123456789")
"""What the corners of a polygon begin with."""

_LARGEST: Final = 1 << 27
"""Bytes of a text; what it may hold has limits of its own, in characters."""


class Drawn(NamedTuple):
    """What a mask file selects.

    Parameters
    ----------
    mask
        (H, W) bool, True = selected.
    strongest
        Largest 8-bit value that was compared with the threshold; None where there are no such values.
    near
        Pixels that the threshold decided narrowly; see `poisson_cli.masks.raster.count_near`.
    """

    mask: NDArray[np.bool_]
    strongest: int | None = None
    near: int = 0


def read_mask(file: MaskFile, canvas: Canvas, threshold: int) -> Drawn:
    """Read a mask.

    Parameters
    ----------
    file
        Its name, and which part of it.
    canvas
        What it is drawn on; a mask that has a size must have this one's.
    threshold
        8-bit value from which a pixel of a mask picture is selected.

    Raises
    ------
    InputError
        If it cannot be read, is no mask, has no such part, or was made for a picture of another size.
    """
    path, part = locate(file)
    name = "standard input" if str(path) == STANDARD else str(path)
    return decode_mask(read_bytes(path), name, part, canvas, threshold)


def locate(file: MaskFile) -> tuple[Path, str | None]:
    """Tell a file's name from the part that is meant.

    Returns
    -------
    path : Path
        The longest name that exists, when the text is cut at one of its colons or not at all; else the text. ``-`` is
        the standard input.
    part : str or None
        What follows the colon.
    """
    if file.name.startswith(f"{STANDARD}:") and not os.path.lexists(file.name):
        return Path(STANDARD), file.name[len(STANDARD) + 1 :]
    end = len(file.name)
    while end > 0:
        if os.path.lexists(file.name[:end]):
            return Path(file.name[:end]), file.name[end + 1 :] if end < len(file.name) else None
        end = file.name.rfind(":", 0, end)
    return Path(file.name), None


def decode_mask(data: bytes, name: str, part: str | None, canvas: Canvas, threshold: int) -> Drawn:
    """Decode a mask; the parameters are those of `read_mask`, but the file's bytes and what to call it.

    Raises
    ------
    InputError
        As `read_mask`.
    """
    if recognise(data) is not None:
        values = decode_strength(data, name, part)
        canvas.refuse_other_size(f"mask {name} is", (values.shape[0], values.shape[1]))
        return Drawn(values >= threshold, int(values.max()), count_near(values, threshold))
    text = _text(data)
    try:
        if text.startswith(("{", "[")):
            from poisson_cli.masks.annotations import draw_annotations  # most runs can do without JSON

            return Drawn(draw_annotations(text, part, canvas))
        text = re.sub(_HEADING, "\n", text, flags=re.IGNORECASE)
        if text.lstrip().startswith(_NUMBERS):
            if part is not None:
                raise InputError(f"a polygon has no parts to choose from, such as {part!r}")
            return Drawn(draw_polygon(Polygon(parse_points(text)), canvas.shape))
    except InputError as error:
        raise InputError(f"{name}: {error}") from error
    what = "the file is empty" if not data else "not a mask"
    raise InputError(
        f"{name}: {what}; pictures ({listed()}), labelme and COCO JSON, and text files of x,y lines are read"
    )


def _text(data: bytes) -> str:
    """The file as text without what is blank at its ends; empty if it is none, or larger than any mask's text."""
    if len(data) > _LARGEST:
        return ""
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if wide else "utf-8-sig").strip()
    except UnicodeDecodeError:
        return ""
