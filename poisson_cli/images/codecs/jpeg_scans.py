"""The scans of a JPEG: how many bytes they must have at least for the size that its header claims, and where they end.

A decoder that comes to the end of the data too early goes on in grey, and says nothing: for it, and for Pillow, this is
a picture. Here the codes for an empty block are counted, which can be known without unpacking anything.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from typing import Final, NamedTuple

__all__ = ["Scan", "scans_of", "size_of"]

_NEXT_MARKER: Final = re.compile(rb"\xff[^\x00\xd0-\xd7\xff]")
_FRAMES: Final = {0xC0: False, 0xC1: False, 0xC2: True}
"""Markers of frames that are packed in Huffman's codes, and whether they are progressive."""

_TABLES, _SCAN, _END = 0xC4, 0xDA, 0xD9
_WORD: Final = 80
"""Bits, and some more."""

_WITHOUT_EOB: Final = 8
"""Bits that the 63 further numbers of a block take at least if the code that ends it is not used: four runs of 16."""


class Scan(NamedTuple):
    """One pass over the picture, or over a channel of it.

    Parameters
    ----------
    start, end
        Where its data lie in the file.
    bits
        How many it must have at least.
    pending
        Rows of pixels, from the last one up, for which a decoder may wait until it sees what follows the data; None if
        it may wait for all of them, because the picture has further scans.
    """

    start: int
    end: int
    bits: int
    pending: int | None


class _Frame(NamedTuple):
    progressive: bool
    height: int
    width: int
    sampling: dict[int, tuple[int, int]]


def scans_of(data: bytes) -> Iterator[Scan]:
    """Walk through a JPEG.

    Parameters
    ----------
    data
        The whole file; what stands behind the end of its first picture is left out.

    Yields
    ------
    Scan
        Until the markers make no sense any more; none for the rare kinds that are packed in another way.
    """
    frame: _Frame | None = None
    shortest: dict[int, tuple[int, int]] = {}
    for marker, body, place in _segments(data, 2):
        try:
            if marker in _FRAMES:
                frame = _frame(body, progressive=_FRAMES[marker])
            elif marker == _TABLES:
                shortest |= dict(_shortest_codes(body))
            elif marker == _SCAN:
                if frame is None:
                    return
                yield _scan(body, frame, shortest, place, _end(data, place))
        except (IndexError, KeyError, ZeroDivisionError, struct.error):  # Pillow will say what is wrong
            return


def size_of(data: bytes, start: int) -> tuple[int, int] | None:
    """(H, W) that a JPEG within other data claims, from where it begins; None if it claims none."""
    for marker, body, _ in _segments(data, start + 2):
        if marker in _FRAMES and len(body) >= 5:
            height, width = struct.unpack_from(">HH", body, 1)
            return height, width
    return None


def _segments(data: bytes, place: int) -> Iterator[tuple[int, bytes, int]]:
    """Markers, what belongs to each, and where that ends, up to the end of the picture; data of scans are left out."""
    while place + 4 <= len(data) and data[place] == 0xFF:
        marker = data[place + 1]
        if marker == 0xFF:  # may stand before any marker
            place += 1
            continue
        if marker == _END:
            return
        (length,) = struct.unpack_from(">H", data, place + 2)
        yield marker, data[place + 4 : place + 2 + length], place + 2 + length
        place += 2 + length
        if marker == _SCAN:
            place = _end(data, place)


def _end(data: bytes, place: int) -> int:
    """Where the data of a scan end that begin there."""
    following = _NEXT_MARKER.search(data, place)
    return following.start() if following else len(data)


def _frame(body: bytes, *, progressive: bool) -> _Frame:
    height, width, count = struct.unpack_from(">HHB", body, 1)
    parts = [body[6 + 3 * k : 9 + 3 * k] for k in range(count)]
    return _Frame(progressive, height, width, {part[0]: (part[1] >> 4, part[1] & 15) for part in parts})


def _shortest_codes(body: bytes) -> Iterator[tuple[int, tuple[int, int]]]:
    """By the number of the table: bits of its shortest code, and of the one of the symbol 0, which ends a block."""
    while len(body) > 17:
        lengths = [bits for bits, count in enumerate(body[1:17], start=1) for _ in range(count)]
        symbols = body[17 : 17 + len(lengths)]
        last = symbols.find(0)
        yield body[0], (lengths[0], lengths[last] if last >= 0 else _WITHOUT_EOB)
        body = body[17 + len(lengths) :]


def _scan(body: bytes, frame: _Frame, shortest: dict[int, tuple[int, int]], start: int, end: int) -> Scan:
    parts = [(body[1 + 2 * k], body[2 + 2 * k]) for k in range(body[0])]
    first, refined = body[1 + 2 * body[0]], body[3 + 2 * body[0]] >> 4
    most_across = max(across for across, _ in frame.sampling.values())
    most_down = max(down for _, down in frame.sampling.values())
    bits = 0
    for part, tables in parts:
        across, down = frame.sampling[part]
        if len(parts) == 1:  # as many blocks as the channel has; else whole groups of them
            blocks = -(-frame.width * across // (8 * most_across)) * -(
                -frame.height * down // (8 * most_down)
            )
        else:
            blocks = (
                -(-frame.width // (8 * most_across)) * -(-frame.height // (8 * most_down)) * across * down
            )
        if first:
            continue  # a single code can stand for thousands of empty blocks
        if refined:
            bits += blocks
            continue
        bits += blocks * shortest[tables >> 4][0]
        if not frame.progressive:
            bits += blocks * min(shortest[0x10 | tables & 15][1], _WITHOUT_EOB)
    pending = None
    if not frame.progressive and len(parts) == len(frame.sampling):
        # The row of blocks that is not complete, the one before, for whose colours a decoder looks at the next one, and
        # those for which it has the bits already but will not begin before it has a whole word of them.
        lines = -(-frame.height // (8 * most_down))
        pending = 8 * most_down * (2 + -(-_WORD * lines // bits))
    return Scan(start, end, bits, pending)
