"""Reading a picture file.

The bytes are read here and handed to a decoder chosen by their magic number. A decoder never sees a path: it would
also open addresses, archives and example pictures under that name, or trust the file's ending.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.images.codec import decoded, opened
from poisson_cli.images.formats import Format, listed, recognise
from poisson_cli.images.header import Header, decoding, judge, refuse_deep
from poisson_cli.images.orientation import upright
from poisson_cli.images.picture import Picture

__all__ = ["decode", "decode_indices", "read", "read_bytes"]


def read(path: Path) -> Picture:
    """Read a picture from a file.

    Parameters
    ----------
    path
        A regular file, or a pipe.

    Raises
    ------
    InputError
        If it cannot be read, is not a picture, or holds one that would lose something (see `header`).
    """
    return decode(read_bytes(path), str(path))


def decode(data: bytes, name: str) -> Picture:
    """Decode a picture.

    Parameters
    ----------
    data
        The whole file: PNG, JPEG, TIFF, BMP or WebP.
    name
        What to call it in messages.

    Raises
    ------
    InputError
        As `read`.
    """
    header, pixels = _decoded(data, name, lambda header: header.mode)
    alpha = None
    if header.mode in ("LA", "RGBA"):
        pixels, alpha = np.ascontiguousarray(pixels[..., :-1]), np.ascontiguousarray(pixels[..., -1])
        if header.mode == "LA":
            pixels = pixels[..., 0]
    return Picture(name=name, pixels=pixels, alpha=alpha, profile=header.profile, palette=header.palette)


def decode_indices(data: bytes, name: str) -> NDArray[np.uint8]:
    """Decode what a picture stores for each pixel, where that is one number: the index of a colour, or a grey value.

    Parameters
    ----------
    data
        The whole file.
    name
        What to call it in messages.

    Returns
    -------
    ndarray
        (H, W) uint8, upright as the picture is.

    Raises
    ------
    InputError
        As `read`, and if the picture has neither a palette nor a single channel.
    """

    def mode(header: Header) -> str:
        if not header.palette and header.mode != "L":
            raise InputError(f"{name}: a picture without a palette; its pixels have no index")
        return "P" if header.palette else "L"

    return _decoded(data, name, mode)[1]


def _decoded(data: bytes, name: str, mode: Callable[[Header], str]) -> tuple[Header, NDArray[np.uint8]]:
    """A picture's header, and its pixels as they should be looked at, in the layout that `mode` chooses."""
    form = _recognised(data, name)
    with decoding(name, form):
        refuse_deep(data, name, form)
        with opened(data, form) as image:
            header = judge(image, name, form)
            return header, upright(*decoded(data, image, form, mode(header)))


def _recognised(data: bytes, name: str) -> Format:
    known = recognise(data)
    if isinstance(known, Format):
        return known
    if known is not None:
        raise InputError(f"{name}: {known} is not read; convert it to one of {listed()}")
    what = "not a picture" if data else "the file is empty"
    raise InputError(f"{name}: {what}; {listed()} are read")


def read_bytes(path: Path) -> bytes:
    """Read a whole file, if it is one that ends.

    Parameters
    ----------
    path
        A regular file, or a pipe.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    try:
        with open(path, "rb") as file:
            kind = os.fstat(file.fileno()).st_mode
            if stat.S_ISREG(kind) or stat.S_ISFIFO(kind):
                return file.read()
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file") from error
    except IsADirectoryError as error:
        raise InputError(f"{path}: a folder, not a picture") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    raise InputError(f"{path}: not a file with a picture in it")  # a device, which may never end
