"""PNG files put together: a writer may choose how, and this way is quick and keeps everything that `Metadata` holds.

Two choices decide what a PNG takes, in time and in bytes. Each row is stored as differences to what is foreseen for it,
and a byte of its own says how: *filters*. Pillow tries all five of them on every row, which takes most of its time.
Four of them are tried here, each for many rows at once; the fifth, Paeth's, would take as long again as all the rest.
And for what is left, `zlib` is told to look for repeated bytes only, since little else repeats in the differences of a
photograph.

On scikit-image's pictures that takes half the time of Pillow's encoder with the same setting of `zlib`, for files 2 %
larger, 10 % at worst; and a fifth of the time of Pillow's default.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.images.formats import Format
from poisson_cli.images.metadata import Metadata
from poisson_cli.images.picture import Picture

__all__ = ["encode"]

_COLOUR_TYPE: Final = {1: 0, 2: 4, 3: 2, 4: 6}
"""By channels: grey, grey and alpha, RGB, RGB and alpha."""

_INCH: Final = 0.0254  # metres
_BAND: Final = 1 << 18  # bytes of rows that are filtered at a time: they stay in the processor's cache


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a PNG; see `poisson_cli.images.codecs`."""
    height, width = picture.shape
    bits = 16 if picture.depth == "16" else 8
    header = struct.pack(">IIBBBBB", width, height, bits, _COLOUR_TYPE[picture.channels], 0, 0, 0)
    return b"".join(
        (
            b"\x89PNG\r\n\x1a\n",
            _block(b"IHDR", header),
            *_blocks_of(picture.metadata),
            *(_block(b"IDAT", piece) for piece in _packed(picture)),
            _block(b"IEND", b""),
        )
    )


def _packed(picture: Picture) -> Iterator[bytes]:
    """All rows, filtered and deflated, in pieces."""
    packer = zlib.compressobj(level=1, strategy=zlib.Z_RLE)
    distance = picture.channels * picture.pixels.itemsize
    above: NDArray[np.uint8] = np.zeros(distance * picture.shape[1], np.uint8)
    for stored in _bands(picture):
        piece = packer.compress(_filtered(stored, above, distance).data)
        if piece:
            yield piece
        above = stored[-1]
    yield packer.flush()


def _bands(picture: Picture) -> Iterator[NDArray[np.uint8]]:
    """Some rows at a time as they are stored, (n, bytes of a row): alpha last, and high bytes first."""
    pixels, alpha = picture.pixels, picture.alpha
    height, width = picture.shape
    step = max(1, _BAND // (picture.channels * pixels.itemsize * width))
    for first in range(0, height, step):
        rows = pixels[first : first + step]
        if alpha is not None:
            rows = np.dstack((rows, alpha[first : first + step]))
        rows = np.ascontiguousarray(rows, rows.dtype.newbyteorder(">"))
        yield rows.reshape(rows.shape[0], -1).view(np.uint8)


def _filtered(stored: NDArray[np.uint8], above: NDArray[np.uint8], distance: int) -> NDArray[np.uint8]:
    """Rows by the filter that leaves the smallest differences of each, as numbers from -128 to 127.

    Parameters
    ----------
    stored
        (n, bytes of a row).
    above
        The row before the first of them; zeros if there is none.
    distance
        Bytes of a pixel.

    Returns
    -------
    ndarray
        (n, 1 + bytes of a row), each row behind the number of its filter.
    """
    left = np.zeros_like(stored)
    left[:, distance:] = stored[:, :-distance]
    up = np.concatenate((above[np.newaxis], stored[:-1]))
    average = (left & up) + ((left ^ up) >> 1)  # of the two, rounded down, within eight bits
    filters = (stored, stored - left, stored - up, stored - average)  # 0 None, 1 Sub, 2 Up, 3 Average
    sizes = [np.abs(rest.view(np.int8)).view(np.uint8).sum(axis=1, dtype=np.int64) for rest in filters]
    best = np.argmin(sizes, axis=0)
    filtered = np.empty((stored.shape[0], 1 + stored.shape[1]), np.uint8)
    filtered[:, 0] = best
    for number, rest in enumerate(filters):
        chosen = best == number
        filtered[chosen, 1:] = rest[chosen]
    return filtered


def _blocks_of(metadata: Metadata) -> list[bytes]:
    """What belongs to a picture, in the order that the standard asks for."""
    blocks = []
    if metadata.profile is not None:
        blocks.append(_block(b"iCCP", b"ICC Profile\0\0" + zlib.compress(metadata.profile)))
    if metadata.dpi is not None:
        per_metre = [round(number / _INCH) for number in metadata.dpi]
        blocks.append(_block(b"pHYs", struct.pack(">IIB", *per_metre, 1)))
    if metadata.xmp is not None:
        # Keyword; not compressed, no language, no translated keyword; text.
        blocks.append(_block(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + metadata.xmp))
    if metadata.exif is not None:
        blocks.append(_block(b"eXIf", metadata.exif))
    return blocks


def _block(name: bytes, data: bytes) -> bytes:
    check = zlib.crc32(data, zlib.crc32(name))
    return b"".join((struct.pack(">I", len(data)), name, data, struct.pack(">I", check)))
