"""Radiance HDR: three mantissas of eight bits and one exponent for each pixel.

What is read is exact, and pixels that were read come back as they were. Others are rounded to what the format has: 8
bits for the largest of the three channels, and the others as coarse as that one. OpenCV would read it too, but is no
part of this program.
"""

from __future__ import annotations

import re
from typing import Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import Format
from poisson_cli.images.header import refuse_hollow
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode"]

_SIZE: Final = re.compile(rb"([-+][XY]) ([0-9]{1,9}) ([-+][XY]) ([0-9]{1,9})\n")
_LONGEST_HEADER: Final = 1 << 16
_LONGEST_ROW: Final = 32767
_LARGEST: Final = 255 * 2.0**119
_RATIO: Final = 64
"""Bytes that one byte can become at most: a run of 127 takes two."""


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode a picture; see `poisson_cli.images.codecs`."""
    end = data.find(b"\n\n", 0, _LONGEST_HEADER)
    if end < 0:
        raise ValueError("no header")
    if b"FORMAT=32-bit_rle_xyze" in data[:end]:
        raise InputError(f"{name}: a Radiance HDR of CIE XYZ values; convert it to RGB first")
    size = _SIZE.match(data, end + 2)
    if size is None:
        raise ValueError("no size")
    if (size[1][1:], size[3][1:]) != (b"Y", b"X"):
        raise InputError(f"{name}: a Radiance HDR that is stored by columns; turn it first")
    height, width = int(size[2]), int(size[4])
    asked().refuse_large(name, width, height)
    refuse_hollow(name, 4 * width * height, len(data) - size.end(), _RATIO)
    rgbe = _unpacked(data, size.end(), height, width)
    rgbe = rgbe[:: 1 if size[1] == b"-Y" else -1, :: 1 if size[3] == b"+X" else -1]
    exponent = np.where(rgbe[..., 3:] > 0, rgbe[..., 3:].astype(np.int32) - 136, -1000)
    return Decoded(np.ldexp(rgbe[..., :3].astype(np.float32), exponent))


def _unpacked(data: bytes, at: int, height: int, width: int) -> NDArray[np.uint8]:
    """(H, W, 4): mantissas and exponents."""
    if not 8 <= width <= _LONGEST_ROW or data[at : at + 2] != b"\2\2" or data[at + 2] & 0x80:
        return _flat(data, at, height, width)
    rows = np.empty((height, 4, width), np.uint8)
    start = bytes((2, 2, width >> 8, width & 255))
    for row in rows.reshape(height, 4 * width):
        if data[at : at + 4] != start:
            raise ValueError("a row that does not begin as it should")
        at = _row(data, at + 4, row, width)
    return rows.transpose(0, 2, 1)


def _flat(data: bytes, at: int, height: int, width: int) -> NDArray[np.uint8]:
    """Pixels one after the other, with none of the runs that the oldest files have."""
    size = 4 * width * height
    if len(data) - at < size:
        raise ValueError("it ends early")
    rgbe = np.frombuffer(data, np.uint8, size, at).reshape(height, width, 4)
    if (rgbe[..., :3] == 1).all(axis=2).any():
        raise ValueError("runs of the oldest kind, which are not read")
    return rgbe


def _row(data: bytes, at: int, row: NDArray[np.uint8], width: int) -> int:
    """Unpack the runs of one row, channel after channel; returns where they end."""
    packed = memoryview(data)
    out = row.data
    filled, end = 0, width
    while filled < 4 * width:
        count = packed[at]
        if count > 128:
            count -= 128
            if filled + count > end:
                raise ValueError("a run that is too long")
            out[filled : filled + count] = data[at + 1 : at + 2] * count
            at += 2
        else:
            if count == 0 or filled + count > end or at + 1 + count > len(data):
                raise ValueError("a run that is too long")
            out[filled : filled + count] = packed[at + 1 : at + 1 + count]
            at += 1 + count
        filled += count
        if filled == end:
            end += width
    return at


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a picture of three channels; see `poisson_cli.images.codecs`.

    Without runs, which save little in photographs. No pixel can be taken for the beginning of a run, because the
    largest mantissa of a pixel is 128 at least.

    Negative values and NaNs, which the format cannot hold, become 0, too large ones the largest there is.
    """
    height, width = picture.shape
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
    return head + b"".join(_packed(row) for row in picture.pixels)


def _packed(row: NDArray[np.float32]) -> bytes:
    """One row of mantissas and exponents."""
    row = np.clip(np.nan_to_num(row, nan=0.0, posinf=_LARGEST), 0, _LARGEST)
    largest = row.max(axis=1)
    _, exponent = np.frexp(largest)
    # Rounding may lift the largest mantissa to 256, which is the next exponent's 128.
    exponent += np.rint(np.ldexp(largest, 8 - exponent)) > 255
    seen = (largest > 0) & (exponent > -128)
    rgbe = np.zeros((row.shape[0], 4), np.uint8)
    rgbe[seen, :3] = np.rint(np.ldexp(row[seen], 8 - exponent[seen, np.newaxis]))
    rgbe[seen, 3] = exponent[seen] + 128
    return rgbe.tobytes()
