"""PNG, of eight bits and of sixteen.

Pillow reads 16-bit PNGs, but keeps only the upper half of each number, because it has no layout for more than one
channel of 16 bits. No other decoder comes with this program, and one that does it at once (OpenCV) is ten times the
size of Pillow. So a picture is decoded twice: as it is, for the upper halves, and as if its bytes lay the other way
round, for the lower ones. All the unpacking and checking is Pillow's.

Writing is simpler than reading, since a writer may choose: 16-bit PNGs are put together here.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import ImageFile, PngImagePlugin

from poisson_cli.errors import InputError
from poisson_cli.images.codecs import pillow, raster
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import Format
from poisson_cli.images.header import DEFLATE_RATIO, refuse_hollow
from poisson_cli.images.metadata import Metadata
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode"]

_SAMPLES: Final = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Numbers per pixel by colour type."""

_HALVES: Final = {
    # colour type: (mode, Pillow's name for this order of bytes and for the other one)
    2: ("RGB", "RGB;16B", "RGB;16L"),
    6: ("RGBA", "RGBA;16B", "RGBA;16L"),
}
_INCH: Final = 0.0254  # metres
_BAND: Final = 1 << 22  # bytes that are packed at a time


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


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a PNG; see `poisson_cli.images.codecs`."""
    if picture.depth == "8":
        settings = raster.settings_of(picture, form)
        xmp = settings.pop("xmp", None)
        if xmp is not None:
            settings["pnginfo"] = PngImagePlugin.PngInfo()
            settings["pnginfo"].add(b"iTXt", _xmp_text(xmp))
        return raster.encode_with_pillow(picture, form, settings)
    pixels = pillow.interleaved(picture.pixels, picture.alpha)
    height, width = picture.shape
    colour = {1: 0, 2: 4, 3: 2, 4: 6}[picture.channels]
    return b"".join(
        (
            b"\x89PNG\r\n\x1a\n",
            _block(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, colour, 0, 0, 0)),
            *_blocks_of(picture.metadata),
            *(_block(b"IDAT", piece) for piece in _packed(pixels.reshape(height, -1), picture.channels)),
            _block(b"IEND", b""),
        )
    )


def _packed(rows: NDArray[np.uint16], channels: int) -> Iterator[bytes]:
    """Rows of 16-bit numbers, each as the difference to the pixel on its left (the filter Sub), deflated."""
    height, width = rows.shape
    step = 2 * channels
    packer = zlib.compressobj(level=1, strategy=zlib.Z_RLE)
    band = max(1, _BAND // (2 * width))
    for first in range(0, height, band):
        stored = rows[first : first + band].astype(">u2").view(np.uint8)
        filtered = np.empty((stored.shape[0], 1 + stored.shape[1]), np.uint8)
        filtered[:, 0] = 1
        filtered[:, 1 : 1 + step] = stored[:, :step]
        np.subtract(stored[:, step:], stored[:, :-step], out=filtered[:, 1 + step :])
        yield packer.compress(filtered.tobytes())
    yield packer.flush()


def _blocks_of(metadata: Metadata) -> list[bytes]:
    """What belongs to a picture, in the order that the standard asks for."""
    blocks = []
    if metadata.profile is not None:
        blocks.append(_block(b"iCCP", b"ICC Profile\0\0" + zlib.compress(metadata.profile)))
    if metadata.dpi is not None:
        per_metre = [round(number / _INCH) for number in metadata.dpi]
        blocks.append(_block(b"pHYs", struct.pack(">IIB", *per_metre, 1)))
    if metadata.xmp is not None:
        blocks.append(_block(b"iTXt", _xmp_text(metadata.xmp)))
    if metadata.exif is not None:
        blocks.append(_block(b"eXIf", metadata.exif))
    return blocks


def _xmp_text(packet: bytes) -> bytes:
    """Keyword; not compressed, no language, no translated keyword; text."""
    return b"XML:com.adobe.xmp\0\0\0\0\0" + packet


def _block(name: bytes, data: bytes) -> bytes:
    check = zlib.crc32(data, zlib.crc32(name))
    return b"".join((struct.pack(">I", len(data)), name, data, struct.pack(">I", check)))
