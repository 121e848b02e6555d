"""Reading a picture file.

The bytes are read here and handed to a decoder chosen by their magic number. A decoder never sees a path: it would
also open addresses, archives and example pictures under that name, or trust the file's ending.
"""

from __future__ import annotations

import importlib
import os
import stat
import sys
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import Format, listed, recognise
from poisson_cli.images.header import decoding
from poisson_cli.images.orientation import upright
from poisson_cli.images.picture import Picture
from poisson_cli.streams import STANDARD, missing

__all__ = ["decode", "decode_indices", "read", "read_bytes"]

_BYTES_PER_PIXEL: Final = 4
"""Of the largest picture that is read; no stream is read any further."""

_MOST_BYTES_PER_PIXEL: Final = 16
"""Four floats."""

_PIECE: Final = 1 << 22
_UNKNOWN: Final = 1 << 28
"""Bytes of a stream that is no picture but may be the text of a mask."""


def read(path: Path) -> Picture:
    """Read a picture from a file.

    Parameters
    ----------
    path
        A regular file, or a pipe; ``-`` for the standard input.

    Raises
    ------
    InputError
        If it cannot be read, is not a picture, or holds one that would lose something.
    """
    return decode(read_bytes(path), "standard input" if str(path) == STANDARD else str(path))


def decode(data: bytes, name: str) -> Picture:
    """Decode a picture.

    Parameters
    ----------
    data
        The whole file, in one of `formats.FORMATS`.
    name
        What to call it in messages.

    Raises
    ------
    InputError
        As `read`.
    """
    decoded = _decoded(data, name)
    pixels, alpha = _upright(decoded), None
    if decoded.alpha:
        pixels, alpha = np.ascontiguousarray(pixels[..., :-1]), np.ascontiguousarray(pixels[..., -1])
    if pixels.ndim == 3 and pixels.shape[2] == 1:
        pixels = pixels[..., 0]
    if pixels.dtype == np.float32:
        strange = pixels.size - np.count_nonzero(np.isfinite(pixels))
        if strange:
            asked().notices.append(f"{name} has {strange:,} values that are NaN or infinite")
    return Picture(
        name=name, pixels=pixels, alpha=alpha, palette=decoded.palette, metadata=decoded.metadata.of_upright()
    )


def decode_indices(data: bytes, name: str) -> NDArray[Any]:
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
        (H, W) of uint8, uint16 or float32, upright as the picture is.

    Raises
    ------
    InputError
        As `read`, and if the picture has neither a palette nor a single channel.
    """
    decoded = _decoded(data, name, indices=True)
    if decoded.pixels.ndim != 2:
        raise InputError(f"{name}: a picture without a palette; its pixels have no index")
    return _upright(decoded)


def _decoded(data: bytes, name: str, *, indices: bool = False) -> Decoded:
    form = _recognised(data, name)
    if form.absent is not None:
        raise InputError(f"{name}: {form.absent}")
    codec = importlib.import_module(f"poisson_cli.images.codecs.{form.codec}")
    with decoding(name, form):
        decoded: Decoded = codec.decode(data, name, form, indices=indices)
    return decoded


def _upright(decoded: Decoded) -> NDArray[Any]:
    return upright(decoded.pixels, decoded.orientation)


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
        A regular file, or a pipe; ``-`` for the standard input, once in a run.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    if str(path) == STANDARD:
        return _standard_input()
    try:
        with open(path, "rb") as file:
            kind = os.fstat(file.fileno()).st_mode
            if stat.S_ISREG(kind):
                _refuse_stuffed(file.fileno(), str(path))
                return file.read()
            if stat.S_ISFIFO(kind):
                return _stream(file, str(path))
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file") from error
    except IsADirectoryError as error:
        raise InputError(f"{path}: a folder, not a picture") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except MemoryError as error:
        raise InputError(f"{path}: not enough memory to read it") from error
    raise InputError(f"{path}: not a file with a picture in it")  # a device, which may never end


def _refuse_stuffed(descriptor: int, name: str) -> None:
    """Refuse a large file that cannot be a picture, or is mostly nothing, before memory is asked for."""
    size = os.fstat(descriptor).st_size
    if size <= _UNKNOWN:
        return
    with open(descriptor, "rb", closefd=False, buffering=0) as file:
        _recognised(file.read(16), name)
        file.seek(0)
    if size > asked().largest * _MOST_BYTES_PER_PIXEL:
        raise InputError(
            f"{name}: {size:,} bytes are more than {asked().largest:,} pixels take; --max-pixels allows more"
        )
    if _written(descriptor, size) < size // 2:
        raise InputError(f"{name}: damaged, most of its {size:,} bytes were never written")


def _written(descriptor: int, size: int) -> int:
    """Bytes of a file that are no holes, as far as the system tells."""
    if not hasattr(os, "SEEK_DATA"):
        return size
    written = place = 0
    try:
        while place < size:
            begin = os.lseek(descriptor, place, os.SEEK_DATA)
            place = os.lseek(descriptor, begin, os.SEEK_HOLE)
            written += place - begin
    except OSError:  # nothing but a hole up to the end
        pass
    finally:
        os.lseek(descriptor, 0, os.SEEK_SET)
    return written


def _standard_input() -> bytes:
    """All that comes from the standard input."""
    current = asked()
    if current.stdin_taken:
        raise InputError(
            "standard input: it holds one input, and was read already; name a file for the other"
        )
    current.stdin_taken = True
    if missing(sys.stdin):
        raise InputError("standard input: it is closed; name a file")
    if sys.stdin.isatty():
        raise InputError("standard input: a terminal; send a picture through a pipe, or name a file")
    try:
        return _stream(sys.stdin.buffer, "standard input")
    except OSError as error:
        raise InputError(f"standard input: cannot be read ({error.strerror})") from error


def _stream(file: BinaryIO, name: str) -> bytes:
    """Read a stream to its end, but not for ever."""
    data = bytearray()
    limit = _PIECE
    while piece := file.read(_PIECE):
        data += piece
        if len(data) > limit:
            # What is no picture may be the text of a mask; what has zeros in it is not even that.
            known = isinstance(recognise(bytes(data[:16])), Format)
            limit = asked().largest * _BYTES_PER_PIXEL if known else 0 if 0 in data[:512] else _UNKNOWN
            if len(data) > limit:
                raise InputError(
                    f"{name}: more than {len(data):,} bytes and still no end; too much for a picture"
                )
    return bytes(data)
