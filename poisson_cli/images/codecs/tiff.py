"""TIFF of 8 and 16 bits and of floats.

Pillow brings libtiff, which unpacks all that is in use (LZW, Deflate, ZSTD, PackBits, JPEG), so compressed files need
no further package. But Pillow has layouts for one channel of 16 bits or of floats only, and cuts 16-bit colours to 8.
So a deep page is taken apart into sheets of one channel (`tiff_sheets`), which it reads without loss. Pages of up to
eight bits are Pillow's as they are, but for grey with alpha: palettes, bits, inverted greys and colour differences are
known to it.

Pages are written here, deflated, whatever their depth: a writer may choose the one layout it knows.
"""

from __future__ import annotations

import struct
import zlib
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError, OutputError
from poisson_cli.images.codecs import pillow, tiff_page, tiff_sheets
from poisson_cli.images.codecs.jpeg_scans import size_of
from poisson_cli.images.codecs.quiet import quiet
from poisson_cli.images.codecs.tiff_page import Page, carried, pages_of
from poisson_cli.images.codecs.tiff_tags import Directory, Entry, written
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.depth import depth_of, full_scale
from poisson_cli.images.formats import Format
from poisson_cli.images.header import DEFLATE_RATIO, refuse_hollow
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode"]

_RATIOS: Final = {
    1: 1,
    5: 4096,  # LZW
    8: DEFLATE_RATIO,
    32946: DEFLATE_RATIO,
    32773: 64,  # PackBits
    34925: 1 << 14,  # LZMA: 273 bytes in a quarter of a bit, when nothing else comes for long
    50000: 1 << 15,  # ZSTD: a block of 128 KiB of one value takes 4 bytes
}
"""Bytes that one byte can become at most, by compression; others know no bound worth asking for."""

_PREMULTIPLIED: Final = (
    "a TIFF with premultiplied alpha, transparent in places; save it with straight (unassociated) alpha first"
)
_STRIP: Final = 1 << 18  # bytes, before they are packed
_TILE: Final = 1 << 24  # pixels that a small picture's tiles may have
_LARGEST: Final = 2**32 - 1


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode a TIFF; see `poisson_cli.images.codecs`."""
    pages = pages_of(data, name)
    page = pages[asked().choose(name, len(pages), "pages")]
    asked().refuse_large(name, page.width, page.height)
    page.refuse_loss(name)
    height, width = page.stored
    if height * width > _TILE + 2 * page.height * page.width:
        raise InputError(
            f"{name}: damaged, its tiles are far larger than its {page.width}x{page.height} pixels"
        )
    size = height * ((width * page.samples * page.bits + 7) // 8)
    ratio = _RATIOS.get(page.number(tiff_page.COMPRESSION, 1))
    if ratio is not None:
        refuse_hollow(name, size, len(data), ratio)
    _refuse_small_strips(data, page, name)
    with quiet():
        decoded = (
            _of_sheets(data, page) if page.in_sheets else _of_pillow(data, name, form, page, indices=indices)
        )
    if page.premultiplied and decoded.pixels[..., -1].min() < full_scale(depth_of(decoded.pixels)):
        raise InputError(f"{name}: {_PREMULTIPLIED}")
    return decoded


def _refuse_small_strips(data: bytes, page: Page, name: str) -> None:
    """Refuse a page in JPEGs that are smaller than its strips or tiles: libtiff leaves the rest black."""
    if page.number(tiff_page.COMPRESSION, 1) != tiff_page.JPEG or page.number(tiff_page.PLANES, 1) != 1:
        return
    tiles = tiff_page.TILE_STARTS in page.tags
    starts = page.numbers(tiff_page.TILE_STARTS if tiles else tiff_page.STRIP_STARTS, ())
    rows = min(page.number(tiff_page.ROWS_PER_STRIP, page.height), page.height)
    for number, start in enumerate(starts):
        wanted = min(rows, page.height - number * rows), page.width
        if tiles:
            wanted = page.number(tiff_page.TILE_HEIGHT, 0), page.number(tiff_page.TILE_WIDTH, 0)
        there = size_of(data, start)
        if there is not None and (there[0] < wanted[0] or there[1] < wanted[1]):
            raise InputError(
                f"{name}: damaged, part {number + 1} of it should have {wanted[1]}x{wanted[0]} pixels, "
                f"and it has {there[1]}x{there[0]}"
            )


def _of_sheets(data: bytes, page: Page) -> Decoded:
    """Decode a page that Pillow has no layout for."""
    pixels = tiff_sheets.decode(data, page)
    if page.number(tiff_page.PHOTOMETRIC, 1) == 0:
        pixels = pixels.copy()
        colours = pixels[..., 0] if page.alpha else pixels
        np.subtract(np.iinfo(pixels.dtype).max, colours, out=colours)
    return Decoded(pixels, page.alpha, page.number(tiff_page.ORIENTATION, 1), False, page.metadata())


def _of_pillow(data: bytes, name: str, form: Format, page: Page, *, indices: bool) -> Decoded:
    """Decode a page of up to eight bits."""
    plain = page.layout.big
    with pillow.opened(tiff_sheets.plain(data, page) if plain else data, form) as image:
        if page.index and not plain:
            image.seek(page.index)
        mode = pillow.decode_mode(image, name, form, indices=indices)
        palette = image.mode in ("P", "PA")
        pixels = pillow.pixels_of(image, mode)
        # Pillow has turned the picture by now, and dropped the tag.
        return Decoded(pixels, mode in ("LA", "RGBA"), 1, palette, page.metadata())


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a TIFF; see `poisson_cli.images.codecs`."""
    order, tags = carried(picture.metadata)
    pixels = pillow.interleaved(picture.pixels, picture.alpha)
    height, width = picture.shape
    samples = picture.channels
    rows = max(1, min(height, _STRIP // (width * samples * pixels.itemsize)))
    predicted = picture.depth != "float"
    stored = np.dtype(f"{order}{pixels.dtype.kind}{pixels.itemsize}")
    strips = [
        zlib.compress(_prepared(pixels[first : first + rows], stored, predicted), 4)
        for first in range(0, height, rows)
    ]

    def whole(tag: int, kind: int, *numbers: int) -> None:
        tags[tag] = Entry.of_numbers(kind, order, *numbers)

    whole(tiff_page.WIDTH, 4, width)
    whole(tiff_page.HEIGHT, 4, height)
    whole(tiff_page.BITS, 3, *[8 * pixels.itemsize] * samples)
    whole(tiff_page.COMPRESSION, 3, 8)
    whole(tiff_page.PHOTOMETRIC, 3, 1 if picture.pixels.ndim == 2 else 2)
    whole(tiff_page.ORIENTATION, 3, 1)
    whole(tiff_page.SAMPLES, 3, samples)
    whole(tiff_page.ROWS_PER_STRIP, 4, rows)
    whole(tiff_page.STRIP_SIZES, 4, *map(len, strips))
    whole(tiff_page.PLANES, 3, 1)
    whole(tiff_page.PREDICTOR, 3, 2 if predicted else 1)
    whole(tiff_page.FORMAT, 3, *[1 if predicted else 3] * samples)
    if picture.alpha is not None:
        whole(tiff_page.EXTRA, 3, 2)
    return _file(tags, order, strips)


def _prepared(rows: NDArray[Any], stored: np.dtype[Any], predicted: bool) -> bytes:
    """Bytes of some rows, each number as the difference to that of the pixel on the left if asked for."""
    if predicted:
        differences = rows.copy()
        differences[:, 1:] -= rows[:, :-1]
        rows = differences
    return rows.astype(stored, copy=False).tobytes()


def _file(tags: Directory, order: str, strips: list[bytes]) -> bytes:
    """Header, strips, directory: so the places of the strips are known before the directory is written."""
    places, place = [], 8
    for strip in strips:
        places.append(place)
        place += len(strip)
    padding = bytes(place % 2)
    place += len(padding)
    if place > _LARGEST:
        raise OutputError(f"a TIFF holds at most 4 GiB, and this one would have {place:,} bytes; choose PNG")
    tags[tiff_page.STRIP_STARTS] = Entry.of_numbers(4, order, *places)
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(f"{order}I", place)
    return b"".join((head, *strips, padding, written(tags, order, place)))
