"""Pages of TIFF files for which Pillow has no layout, taken apart into sheets of one channel, for which it has one.

A page of C numbers per pixel, one pixel after the other, has the same bytes as a page of one number per pixel that is
C times as wide. So a second directory is put behind the file that says just that, and Pillow, with libtiff, unpacks
it. Only the predictor, which subtracts *pixels* from each other before they are packed, has to be undone here.
"""

from __future__ import annotations

import struct
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from poisson_cli.images.codecs import pillow, tiff_page
from poisson_cli.images.codecs.tiff_page import Page
from poisson_cli.images.codecs.tiff_tags import Directory, Entry, written
from poisson_cli.images.formats import TIFF

__all__ = ["decode", "plain"]

_SHORT: Final = 3
_LONG: Final = 4
_MODES: Final[dict[int, tuple[str, Any]]] = {
    8: ("L", np.uint8),
    16: ("I;16", np.uint16),
    32: ("F", np.float32),
}
_EIGHT_BYTES: Final = (16, 17, 18)
_COPIED: Final = (
    tiff_page.HEIGHT, tiff_page.COMPRESSION, tiff_page.ROWS_PER_STRIP, tiff_page.STRIP_STARTS, tiff_page.STRIP_SIZES,
    tiff_page.TILE_HEIGHT, tiff_page.TILE_STARTS, tiff_page.TILE_SIZES, 266,
)  # fmt: skip
_PREDICTED: Final = frozenset({5, 8, 32946, 34925, 50000})
"""Compressions to which a predictor belongs: LZW, Deflate, LZMA, ZSTD."""


def decode(data: bytes, page: Page) -> NDArray[Any]:
    """Decode a page of 8-bit or 16-bit integers, or of 32-bit floats.

    Parameters
    ----------
    data
        The whole file; not a BigTIFF of more than 4 GiB.
    page
        One that `Page.refuse_loss` let pass.

    Returns
    -------
    ndarray
        (H, W) or (H, W, C) uint8, uint16 or float32, as stored.
    """
    samples = page.samples
    predictor = page.number(tiff_page.PREDICTOR, 1)
    if page.number(tiff_page.COMPRESSION, 1) not in _PREDICTED:
        predictor = 1
    if samples == 1 or page.number(tiff_page.PLANES, 1) == 2:
        sheets = [_sheet(data, page, page.width, 1, predictor, (k, samples)) for k in range(samples)]
        return sheets[0] if samples == 1 else np.stack(sheets, axis=2)
    tile = page.number(tiff_page.TILE_WIDTH, page.width)
    across = -(-page.width // tile)
    sheet = _sheet(data, page, across * tile, samples, 1)
    if predictor != 1:
        sheet = np.hstack(
            [_summed(part, samples, predictor, page.layout.order) for part in np.hsplit(sheet, across)]
        )
    pixels = sheet.reshape(page.height, across * tile, samples)
    return np.ascontiguousarray(pixels[:, : page.width])


def _sheet(
    data: bytes, page: Page, width: int, samples: int, predictor: int, plane: tuple[int, int] = (0, 1)
) -> NDArray[Any]:
    """One channel, or all of them side by side, (H, width * samples).

    Parameters
    ----------
    data, page
        As in `decode`.
    width
        Pixels across, the rest of the last tile included where there are several channels.
    samples
        Numbers per pixel that lie side by side.
    predictor
        What libtiff is to undo.
    plane
        Which plane, of how many.
    """
    order = page.layout.order
    tags: Directory = {tag: page.tags[tag] for tag in _COPIED if tag in page.tags}
    for tag in (tiff_page.STRIP_STARTS, tiff_page.STRIP_SIZES, tiff_page.TILE_STARTS, tiff_page.TILE_SIZES):
        if tag in tags:
            numbers = page.numbers(tag, ())
            share = len(numbers) // plane[1]
            tags[tag] = Entry.of_numbers(_LONG, order, *numbers[plane[0] * share : (plane[0] + 1) * share])
    own = {
        tiff_page.WIDTH: width * samples,
        tiff_page.BITS: page.bits,
        tiff_page.PHOTOMETRIC: 1,
        tiff_page.SAMPLES: 1,
        tiff_page.PREDICTOR: predictor,
        tiff_page.FORMAT: page.number(tiff_page.FORMAT, 1) if page.bits == 32 else 1,
    }
    if tiff_page.TILE_WIDTH in page.tags:
        own[tiff_page.TILE_WIDTH] = page.number(tiff_page.TILE_WIDTH, 0) * samples
    for tag, number in own.items():
        tags[tag] = Entry.of_numbers(_LONG if number > 65535 else _SHORT, order, number)

    with pillow.opened(with_directory(data, tags, order), TIFF) as image:
        wanted, dtype = _MODES[page.bits]
        if not image.mode.startswith(wanted) or image.size != (width * samples, page.height):
            raise ValueError(f"a layout that cannot be read: {image.mode}")
        if page.bits == 32:
            # libtiff hands over numbers in the order of this machine, but Pillow takes them for the file's.
            image.tile = [
                tile._replace(args=("F;32NF", *cast("tuple[Any, ...]", tile.args)[1:]))
                if tile.codec_name == "libtiff"
                else tile
                for tile in image.tile
            ]
        pixels = np.asarray(image)
    return pixels.astype(dtype, copy=False)


def with_directory(data: bytes, tags: Directory, order: str) -> bytes:
    """A file with another directory behind it, the only one that is then found; never a BigTIFF."""
    place = len(data) + len(data) % 2
    mark = b"II*\0" if order == "<" else b"MM\0*"
    head = mark + struct.pack(f"{order}I", place)
    return b"".join((head, data[8:], bytes(len(data) % 2), written(tags, order, place)))


def plain(data: bytes, page: Page) -> bytes:
    """A page of a BigTIFF as the only one of a plain TIFF: Pillow knows the big-endian kind of them not at all."""
    order = page.layout.order
    tags: Directory = {
        tag: Entry.of_numbers(_LONG, order, *entry.numbers(order)) if entry.kind in _EIGHT_BYTES else entry
        for tag, entry in page.tags.items()
        if isinstance(entry, Entry)
    }
    return with_directory(data, tags, order)


def _summed(part: NDArray[Any], samples: int, predictor: int, order: str) -> NDArray[Any]:
    """Undo a predictor in one column of tiles, (H, pixels * samples)."""
    height = part.shape[0]
    if predictor == 2:  # each number is the difference to that of the pixel on the left
        numbers = np.ascontiguousarray(part).view(np.dtype(f"u{part.itemsize}"))
        sums = np.cumsum(numbers.reshape(height, -1, samples), axis=1, dtype=numbers.dtype)
        return sums.reshape(height, -1).view(part.dtype)
    if predictor != 3:
        raise ValueError(f"an unknown predictor, {predictor}")
    # The first bytes of all numbers of a row, then the second ones and so on; and each byte is the difference to the
    # one that lies `samples` before it. They have no order of bytes, so that of libtiff is taken back.
    stored = np.ascontiguousarray(part.astype("<f4" if order == "<" else ">f4")).view(np.uint8)
    sums = np.cumsum(stored.reshape(height, -1, samples), axis=1, dtype=np.uint8)
    planes = sums.reshape(height, 4, -1)
    return np.ascontiguousarray(planes.transpose(0, 2, 1)).view(">f4")[..., 0].astype(np.float32)
