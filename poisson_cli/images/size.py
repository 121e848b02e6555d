"""How large a picture is, without reading it: for whoever plans."""

from __future__ import annotations

import importlib
import mmap
import os
import re
import stat
import struct
import warnings
from pathlib import Path
from typing import Final, NamedTuple

from PIL import Image

from poisson_cli.images.demands import Sized, asking
from poisson_cli.images.depth import Depth
from poisson_cli.images.formats import EXR, TIFF, Format, recognise

__all__ = ["Size", "peek"]

_MAGIC: Final = 16
"""Bytes that tell a format."""


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
        with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            form = recognise(data[:_MAGIC])
            if not isinstance(form, Format):
                return None
            height, width = _size(data, form)
            return Size(height, width, form.depths[-1])
    except Exception:  # a decoder may raise anything
        return None


def _size(data: mmap.mmap, form: Format) -> tuple[int, int]:
    if form is EXR:
        return _size_of_exr(data)
    if form.pillow and form is not TIFF:
        from poisson_cli.images.codecs.pillow import unlimited

        with warnings.catch_warnings(), unlimited():
            warnings.simplefilter("ignore")
            with Image.open(data, formats=[form.pillow]) as image:  # type: ignore[arg-type]
                return image.height, image.width
    # Ours take a whole file; but of one that is mapped only what they look at is read, which is the header.
    codec = importlib.import_module(f"poisson_cli.images.codecs.{form.codec}")
    try:
        with asking(only_size=True):
            codec.decode(data, "", form)
    except Sized as size:
        return size.height, size.width
    raise ValueError("a decoder that does not ask whether a picture is too large")


_WINDOW: Final = re.compile(rb"dataWindow\0box2i\0\x10\0\0\0")


def _size_of_exr(data: mmap.mmap) -> tuple[int, int]:
    """From the header of an OpenEXR, which its library does not read without the rest of the file."""
    window = _WINDOW.search(data, 0, 1 << 16)
    if window is None:
        raise ValueError("no window")
    left, top, right, bottom = struct.unpack_from("<4i", data, window.end())
    return bottom - top + 1, right - left + 1
