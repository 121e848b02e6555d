"""EXIF blocks: small TIFF files without pixels.

They are changed in place, value by value: writing one anew would break what cameras hide in them behind offsets that
nobody else knows.
"""

from __future__ import annotations

import struct
from typing import Final

__all__ = ["MARK", "bare", "of_size", "of_upright", "orientation"]

MARK: Final = b"Exif\0\0"
"""Stands before the block in JPEG, and by mistake elsewhere."""

_WIDTHS: Final = (0x0100, 0xA002)
_HEIGHTS: Final = (0x0101, 0xA003)
_ORIENTATION: Final = 0x0112
_EXIF: Final = 0x8769
_PREVIEW_OFFSET: Final = 0x0201
_PREVIEW_LENGTH: Final = 0x0202
_LONGEST: Final = 4096
"""Entries of a directory; more is damage."""


def bare(block: bytes | None) -> bytes | None:
    """A block without the mark; None if it is empty or no such block."""
    block = (block or b"").removeprefix(MARK)
    return block if block[:4] in (b"II*\0", b"MM\0*") else None


def orientation(block: bytes | None) -> int:
    """The Orientation tag; 1 where there is none."""
    if block is None:
        return 1
    entries, _ = _directory(block, _first(block))
    return _short(block, entries[_ORIENTATION]) if _ORIENTATION in entries else 1


def of_upright(block: bytes | None) -> bytes | None:
    """A block as it belongs to the edited picture, which is upright: orientation 1, and no preview.

    The preview shows the picture before the edit. It is overwritten with zeros, since what was edited away may be
    what nobody should see, and its directory is cut off.

    Parameters
    ----------
    block
        Without the mark; a damaged one is left as far as it can be understood.
    """
    if block is None:
        return None
    changed = bytearray(block)
    order = _order(block)
    entries, following = _directory(block, _first(block))
    if _ORIENTATION in entries:
        at = entries[_ORIENTATION]
        struct.pack_into(f"{order}HI", changed, at + 2, 3, 1)
        struct.pack_into(f"{order}HH", changed, at + 8, 1, 0)
    if following is not None:
        at, second = following
        preview, _ = _directory(block, second)
        if _PREVIEW_OFFSET in preview and _PREVIEW_LENGTH in preview:
            start, length = (
                struct.unpack_from(f"{order}I", block, preview[tag] + 8)[0]
                for tag in (_PREVIEW_OFFSET, _PREVIEW_LENGTH)
            )
            if start + length <= len(changed):
                changed[start : start + length] = bytes(length)
        struct.pack_into(f"{order}I", changed, at, 0)
    return bytes(changed)


def of_size(block: bytes | None, height: int, width: int) -> bytes | None:
    """A block in which the size of the picture, where it stands, is the one it has: turned or cut out, it is another.

    Parameters
    ----------
    block
        Without the mark.
    height, width
        Pixels.
    """
    if block is None:
        return None
    changed = bytearray(block)
    order = _order(block)
    main, _ = _directory(block, _first(block))
    inner = struct.unpack_from(f"{order}I", block, main[_EXIF] + 8)[0] if _EXIF in main else 0
    for entries in (main, _directory(block, inner)[0]):
        for tags, side in ((_WIDTHS, width), (_HEIGHTS, height)):
            for tag in entries.keys() & tags:
                struct.pack_into(f"{order}HII", changed, entries[tag] + 2, 4, 1, side)
    return bytes(changed)


def _order(block: bytes) -> str:
    return "<" if block[:1] == b"I" else ">"


def _first(block: bytes) -> int:
    """Where the first directory lies."""
    return int(struct.unpack_from(f"{_order(block)}I", block, 4)[0]) if len(block) >= 8 else 0


def _directory(block: bytes, at: int) -> tuple[dict[int, int], tuple[int, int] | None]:
    """Where the entries of a directory lie, by tag; and where the next one's offset lies and what it is, if any."""
    order = _order(block)
    if at < 8 or at + 2 > len(block):
        return {}, None
    (count,) = struct.unpack_from(f"{order}H", block, at)
    end = at + 2 + 12 * count
    if count > _LONGEST or end > len(block):
        return {}, None
    places = range(at + 2, end, 12)
    entries = {struct.unpack_from(f"{order}H", block, place)[0]: place for place in places}
    if end + 4 > len(block):
        return entries, None
    (following,) = struct.unpack_from(f"{order}I", block, end)
    return entries, (end, following) if following else None


def _short(block: bytes, entry: int) -> int:
    """The value of an entry that holds one small number."""
    order = _order(block)
    (kind,) = struct.unpack_from(f"{order}H", block, entry + 2)
    form = {3: "H", 4: "I", 1: "B"}.get(kind)
    return 1 if form is None else int(struct.unpack_from(f"{order}{form}", block, entry + 8)[0])
