"""PNG, of eight bits and of sixteen.

Pillow reads 16-bit PNGs, but keeps only the upper half of each number, because it has no layout for more than one
channel of 16 bits. No other decoder comes with this program, and one that does it at once (OpenCV) is ten times the
size of Pillow. So a picture is decoded twice: as it is, for the upper halves, and as if its bytes lay the other way
round, for the lower ones. All the unpacking and checking is Pillow's.

Writing is simpler than reading: see `png_writer`.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import ImageFile, PngImagePlugin

from poisson_cli.errors import InputError
from poisson_cli.images.codecs import pillow, raster
from poisson_cli.images.codecs.png_writer import encode
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import Format
from poisson_cli.images.header import DEFLATE_RATIO, refuse_hollow

__all__ = ["decode", "encode"]

_SAMPLES: Final = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Numbers per pixel by colour type."""

_HALVES: Final = {
    # colour type: (mode, Pillow's name for this order of bytes and for the other one)
    2: ("RGB", "RGB;16B", "RGB;16L"),
    6: ("RGBA", "RGBA;16B", "RGBA;16L"),
}


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode a PNG; see `poisson_cli.images.codecs`."""
    # Signature 8, length and name of the first block 8; Pillow checks all of them when it opens the file.
    width, height, bits, colour = struct.unpack_from(">IIBB", data, 16)
    asked().refuse_large(name, width, height)
    row = (width * bits * _SAMPLES.get(colour, 1) + 7) // 8
    refuse_hollow(name, height * row, len(data), DEFLATE_RATIO)
    with _long_texts(), pillow.opened(data, form) as image:
        if image.size != (width, height):
            raise ValueError("two headers that differ")
        page = raster.page_of(image, name)
        if page:
            image.seek(page)
        if bits != 16:
            _scale_transparent_value(image, bits, colour)
            return pillow.eight_bits(image, pillow.decode_mode(image, name, form, indices=indices))
        if page:
            raise InputError(f"{name}: an animation of 16 bits; only its first frame is read")
        pixels = _sixteen_bits(image, data, form, colour)
        transparent = None if indices else image.info.get("transparency")
        pixels, alpha = _with_transparent_value(pixels, colour, transparent)
        return Decoded(pixels, alpha, pillow.orientation_of(image), False, pillow.metadata_of(image))


@contextmanager
def _long_texts() -> Iterator[None]:
    """Let texts and profiles be longer, unpacked, than the mebibyte that Pillow allows; together they may not be."""
    usual = PngImagePlugin.MAX_TEXT_CHUNK
    PngImagePlugin.MAX_TEXT_CHUNK = PngImagePlugin.MAX_TEXT_MEMORY
    try:
        yield
    finally:
        PngImagePlugin.MAX_TEXT_CHUNK = usual


def _scale_transparent_value(image: ImageFile.ImageFile, bits: int, colour: int) -> None:
    """Bring the one value that is transparent to the eight bits to which Pillow brings the pixels of 2 or 4 bits.

    Of a 16-bit number in the file that is to be compared with fewer bits, the lower ones count.
    """
    value = image.info.get("transparency")
    most = (1 << bits) - 1
    if colour == 0 and bits > 1 and isinstance(value, int):
        image.info["transparency"] = (value & most) * 255 // most
    elif colour == 2 and isinstance(value, tuple):
        image.info["transparency"] = tuple(number & most for number in value)


def _sixteen_bits(image: ImageFile.ImageFile, data: bytes, form: Format, colour: int) -> NDArray[np.uint16]:
    """(H, W) or (H, W, C)."""
    if colour == 0:
        return np.asarray(image, dtype=np.uint16)
    if colour == 4:  # grey and alpha are four bytes, and so are the four numbers of an 8-bit picture
        return _as_if(image, "RGBA", "RGBA").view(">u2").astype(np.uint16)
    mode, straight, swapped = _HALVES[colour]
    pixels = _as_if(image, mode, straight).astype(np.uint16)
    pixels <<= 8
    with pillow.opened(data, form) as again:
        pixels |= _as_if(again, mode, swapped)
    return pixels


def _as_if(image: ImageFile.ImageFile, mode: str, layout: str) -> NDArray[np.uint8]:
    """Decode a picture as if its pixels were laid out in another way of the same size."""
    image._mode = mode
    image.tile = [tile._replace(args=layout) for tile in image.tile]
    return np.asarray(image, dtype=np.uint8)


def _with_transparent_value(
    pixels: NDArray[np.uint16], colour: int, value: object
) -> tuple[NDArray[np.uint16], bool]:
    """Add an alpha channel to a picture of which one value is transparent."""
    if value is None or colour not in (0, 2):
        return pixels, colour in (4, 6)
    transparent = pixels == np.asarray(value, np.uint16)
    transparent = transparent if colour == 0 else transparent.all(axis=2)
    return np.dstack((pixels, np.where(transparent, np.uint16(0), np.uint16(65535)))), True
