"""How large a picture is, without reading it: for whoever plans."""

from __future__ import annotations

import importlib
import os
import re
import stat
import struct
import warnings
from pathlib import Path
from typing import BinaryIO, Final, NamedTuple

from PIL import Image

from poisson_cli.images.codecs import tiff_page, tiff_tags
from poisson_cli.images.demands import Sized, asking
from poisson_cli.images.depth import Depth
from poisson_cli.images.formats import EXR, TIFF, Format, recognise

__all__ = ["Size", "peek"]

_HEAD: Final = 1 << 16
"""Bytes that hold the header of most formats."""


class Size(NamedTuple):
    """What a picture file claims.

    Parameters
    ----------
    height, width
        In pixels, as they are stored.
    depth
        The deepest that its format can have: this picture may be less deep.
    """

    height: int
    width: int
    depth: Depth


def peek(path: Path) -> Size | None:
    """What a picture file claims.

    Parameters
    ----------
    path
        Any path; a pipe is left alone, since what is read from it is gone.

    Returns
    -------
    Size or None
        None if it cannot be told, for whatever reason: who reads the picture will say which.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            return None
        with open(path, "rb") as file:
            head = file.read(_HEAD)
            form = recognise(head)
            if not isinstance(form, Format):
                return None
            file.seek(0)
            height, width = _size(file, head, form)
            return Size(height, width, form.depths[-1])
    except Exception:  # a decoder may raise anything
        return None


def _size(file: BinaryIO, head: bytes, form: Format) -> tuple[int, int]:
    if form is TIFF:
        return _size_of_tiff(file, head)
    if form is EXR:
        return _size_of_exr(head)
    if form.pillow:
        from poisson_cli.images.codecs.pillow import unlimited

        with warnings.catch_warnings(), unlimited():
            warnings.simplefilter("ignore")
            with Image.open(file, formats=[form.pillow]) as image:
                return image.height, image.width
    codec = importlib.import_module(f"poisson_cli.images.codecs.{form.codec}")
    try:
        with asking(only_size=True):
            codec.decode(head, "", form)
    except Sized as size:
        return size.height, size.width
    raise ValueError("a decoder that does not ask whether a picture is too large")


def _size_of_tiff(file: BinaryIO, head: bytes) -> tuple[int, int]:
    """From the first directory, which may lie anywhere; Pillow does not open what it has no layout for."""
    layout = tiff_tags.layout_of(head)
    file.seek(layout.first)
    # Places are counted from the beginning of the file, but those of the size are not needed: it lies in the directory.
    tags, _ = tiff_tags.read(file.read(_HEAD), layout, 0)
    page = tiff_page.Page(tags, layout, 0)
    return page.height, page.width


_WINDOW: Final = re.compile(rb"dataWindow\0box2i\0\x10\0\0\0")


def _size_of_exr(head: bytes) -> tuple[int, int]:
    """From the header of an OpenEXR, which its library does not read without the rest of the file."""
    window = _WINDOW.search(head)
    if window is None:
        raise ValueError("no window")
    left, top, right, bottom = struct.unpack_from("<4i", head, window.end())
    return bottom - top + 1, right - left + 1
