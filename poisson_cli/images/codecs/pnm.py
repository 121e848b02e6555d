"""The formats of Netpbm: PBM, PGM and PPM, in figures or in bytes, and PFM, which has floats.

A header in plain text and then the numbers: numpy reads them as they are. Pillow would cut 16-bit colours to 8.
"""

from __future__ import annotations

import re
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import PFM, Format
from poisson_cli.images.header import refuse_hollow
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode"]

_BLANK: Final = rb"(?:[ \t\r\n\v\f]|#[^\n\r]*[\n\r])+"
_LONGEST_HEADER: Final = 1 << 16
_NUMBER: Final = rb"([0-9]{1,9})"
_BITS: Final = re.compile(b"P([14])" + _BLANK + _NUMBER + _BLANK + _NUMBER + rb"[ \t\r\n\v\f]")
_GREYS: Final = re.compile(
    b"P([2356])" + _BLANK + _NUMBER + _BLANK + _NUMBER + _BLANK + _NUMBER + rb"[ \t\r\n\v\f]"
)
_FLOATS: Final = re.compile(
    rb"P([fF])\s+" + _NUMBER + rb"\s+" + _NUMBER + rb"\s+(-?[0-9.eE+-]{1,20})\r?[ \t\n]"
)


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode a picture; see `poisson_cli.images.codecs`."""
    if form is PFM:
        return Decoded(_floats(data, name))
    header = data[:_LONGEST_HEADER]
    match = _BITS.match(header) or _GREYS.match(header)
    if match is None:
        raise ValueError("no header")
    kind, width, height = (int(group) for group in match.groups()[:3])
    most = 1 if kind in (1, 4) else int(match[4])
    if not 1 <= most <= 65535:
        raise ValueError(f"a largest value of {most}")
    asked().refuse_large(name, width, height)
    channels = 3 if kind in (3, 6) else 1
    body = memoryview(data)[match.end() :]
    if kind in (1, 2, 3):
        numbers = _figures(body, name, width * height * channels, single=kind == 1)
    else:
        numbers = _bytes(body, name, height, width * channels, 1 if kind == 4 else 8 if most < 256 else 16)
    shape = (height, width) if channels == 1 else (height, width, channels)
    return Decoded(_scaled(numbers, most, inverted=kind in (1, 4)).reshape(shape))


def _bytes(body: memoryview, name: str, height: int, width: int, bits: int) -> NDArray[Any]:
    """Numbers of 1, 8 or 16 bits; each row begins with a new byte."""
    row = (width * bits + 7) // 8
    refuse_hollow(name, height * row, len(body), 1)
    stored = np.frombuffer(body[: height * row], np.uint8).reshape(height, row)
    if bits == 1:
        return np.unpackbits(stored, axis=1, count=width)
    return stored.view(">u2") if bits == 16 else stored


def _figures(body: memoryview, name: str, count: int, *, single: bool) -> NDArray[Any]:
    """Numbers in figures, which in a PBM need no blanks between them."""
    refuse_hollow(name, count, len(body), 1)
    text = re.sub(rb"#[^\n\r]*", b"", bytes(body))
    if re.search(rb"[^0-9\s]", text):
        raise ValueError("something else than figures")
    words = re.findall(b"[01]", text) if single else text.split()
    if len(words) < count:
        raise ValueError(f"{len(words):,} numbers instead of {count:,}")
    if max(map(len, words[:count]), default=0) > 5:
        raise ValueError("a number that is too large")
    return np.array(words[:count], dtype="S5").astype(np.uint32)


def _scaled(numbers: NDArray[Any], most: int, *, inverted: bool) -> NDArray[Any]:
    """Numbers from 0 to `most` in our nearest depth that is no smaller."""
    if numbers.size and numbers.max() > most:
        raise ValueError(f"a value above the largest, {most}")
    full = 255 if most <= 255 else 65535
    dtype = np.uint8 if most <= 255 else np.uint16
    if inverted:
        return np.where(numbers, np.uint8(0), np.uint8(255))
    if most == full:
        return numbers.astype(dtype)
    table = np.rint(np.arange(most + 1) * full / most).astype(dtype)
    scaled: NDArray[Any] = table[numbers]
    return scaled


def _floats(data: bytes, name: str) -> NDArray[np.float32]:
    """A PFM: rows from the bottom up, the sign of the scale tells the order of bytes."""
    match = _FLOATS.match(data[:_LONGEST_HEADER])
    if match is None:
        raise ValueError("no header")
    width, height, scale = int(match[2]), int(match[3]), float(match[4])
    asked().refuse_large(name, width, height)
    shape = (height, width) if match[1] == b"f" else (height, width, 3)
    size = 4 * int(np.prod(shape, dtype=np.int64))
    body = memoryview(data)[match.end() :]
    refuse_hollow(name, size, len(body), 1)
    stored = np.frombuffer(body[:size], "<f4" if scale < 0 else ">f4").reshape(shape)
    return np.ascontiguousarray(stored[::-1]).astype(np.float32, copy=False)


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a picture without alpha; see `poisson_cli.images.codecs`."""
    height, width = picture.shape
    colours = picture.pixels.ndim == 3
    if form is PFM:
        head = f"{'PF' if colours else 'Pf'}\n{width} {height}\n-1.0\n"
        return head.encode() + np.ascontiguousarray(picture.pixels[::-1]).astype("<f4").tobytes()
    head = f"P{6 if colours else 5}\n{width} {height}\n{255 if picture.depth == '8' else 65535}\n"
    return head.encode() + picture.pixels.astype(">u2" if picture.depth == "16" else np.uint8).tobytes()
