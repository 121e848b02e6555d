"""Directories of TIFF files, and of EXIF blocks, which are the same: tags with values, read and written byte for byte.

Values keep their bytes, so what is carried from one file to another arrives as it was, in the same order of bytes.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Final, NamedTuple, TypeAlias

__all__ = ["SUBDIRECTORIES", "Directory", "Entry", "Layout", "layout_of", "read", "written"]

_SIZES: Final = {
    1: 1,
    2: 1,
    3: 2,
    4: 4,
    5: 8,
    6: 1,
    7: 1,
    8: 2,
    9: 4,
    10: 8,
    11: 4,
    12: 8,
    13: 4,
    16: 8,
    17: 8,
    18: 8,
}
_WHOLE: Final = {1: "B", 3: "H", 4: "I", 6: "b", 8: "h", 9: "i", 13: "I", 16: "Q", 17: "q", 18: "Q"}
SUBDIRECTORIES: Final = frozenset({0x8769, 0x8825, 0xA005})
"""Tags that hold the place of a directory: EXIF, GPS, interoperability."""

_LONG: Final = 4
_MOST_ENTRIES: Final = 4096
_DEEPEST: Final = 3


class Layout(NamedTuple):
    """How a file stores numbers.

    Parameters
    ----------
    order
        ``<`` or ``>``, as `struct` has them.
    big
        Whether it is a BigTIFF, with places of 8 bytes.
    first
        Where the first directory lies.
    """

    order: str
    big: bool
    first: int


@dataclass(frozen=True)
class Entry:
    """The values of one tag.

    Parameters
    ----------
    kind
        TIFF's number for their type.
    data
        Their bytes.
    """

    kind: int
    data: bytes

    def numbers(self, order: str) -> tuple[int, ...]:
        """The values, if they are whole numbers; ValueError if not."""
        form = _WHOLE.get(self.kind)
        if form is None:
            raise ValueError("a tag that should hold whole numbers holds something else")
        return struct.unpack(f"{order}{len(self.data) // _SIZES[self.kind]}{form}", self.data)

    def fraction(self, order: str) -> float:
        """The first value, a fraction or a whole number; 0.0 if it is no number."""
        if self.kind == 5 and len(self.data) >= 8:
            above, below = struct.unpack_from(f"{order}II", self.data)
            return float(above / below) if below else 0.0
        return float(self.numbers(order)[0]) if self.kind in _WHOLE and self.data else 0.0

    @classmethod
    def of_numbers(cls, kind: int, order: str, *numbers: int) -> Entry:
        """An entry that holds whole numbers, or fractions as numbers in pairs."""
        form = "I" if kind == 5 else _WHOLE[kind]
        return cls(kind, struct.pack(f"{order}{len(numbers)}{form}", *numbers))


Directory: TypeAlias = "dict[int, Entry | Directory]"


def layout_of(data: bytes) -> Layout:
    """Read a file's first bytes; struct.error if they are too few."""
    order = "<" if data[:1] == b"I" else ">"
    big = struct.unpack_from(f"{order}H", data, 2)[0] == 43
    first = struct.unpack_from(f"{order}Q", data, 8) if big else struct.unpack_from(f"{order}I", data, 4)
    return Layout(order, big, first[0])


def read(data: bytes, layout: Layout, at: int, depth: int = 0) -> tuple[Directory, int]:
    """Read a directory.

    Parameters
    ----------
    data
        The whole file.
    layout
        From `layout_of`.
    at
        Where the directory lies.
    depth
        How many directories it lies in.

    Returns
    -------
    Directory
        Its tags; those whose values lie outside the file are left out.
    int
        Where the next one lies, 0 if there is none.

    Raises
    ------
    ValueError, struct.error
        If it is none.
    """
    order, big, _ = layout
    count_form, entry_form, place_form = ("Q", "HHQ8s", "Q") if big else ("H", "HHI4s", "I")
    (count,) = struct.unpack_from(f"{order}{count_form}", data, at)
    if count > _MOST_ENTRIES:
        raise ValueError("a directory of too many tags")
    place = at + struct.calcsize(f"={count_form}")
    size = struct.calcsize(f"={entry_form}")
    directory: Directory = {}
    for _ in range(count):
        tag, kind, number, inline = struct.unpack_from(f"{order}{entry_form}", data, place)
        place += size
        length = number * _SIZES.get(kind, 1)
        if length <= len(inline):
            values = inline[:length]
        else:
            (start,) = struct.unpack(f"{order}{place_form}", inline)
            if start + length > len(data):
                continue
            values = data[start : start + length]
        entry = Entry(kind, values)
        if tag not in SUBDIRECTORIES:
            directory[tag] = entry
        elif depth < _DEEPEST and kind in _WHOLE and length:
            try:
                directory[tag], _ = read(data, layout, entry.numbers(order)[0], depth + 1)
            except (ValueError, struct.error):
                continue
    (following,) = struct.unpack_from(f"{order}{place_form}", data[place : place + 8].ljust(8, b"\0"))
    return directory, following


def written(directory: Directory, order: str, at: int) -> bytes:
    """A directory as bytes, its values and the directories in it behind it; not for a BigTIFF.

    Parameters
    ----------
    directory
        What to write.
    order
        Order of bytes, that of the values.
    at
        Where it will lie.
    """
    entries, behind = [], b""
    place = at + 2 + 12 * len(directory) + 4
    for tag, entry in sorted(directory.items()):
        if isinstance(entry, Entry):
            kind, data = entry.kind, entry.data
            count = len(data) // _SIZES.get(kind, 1)
        else:
            kind, count, data = _LONG, 1, written(entry, order, place)
        if len(data) <= 4 and isinstance(entry, Entry):
            inline = data.ljust(4, b"\0")
        else:
            inline = struct.pack(f"{order}I", place)
            data += b"\0" * (len(data) % 2)
            behind += data
            place += len(data)
        entries.append(struct.pack(f"{order}HHI4s", tag, kind, count, inline))
    return struct.pack(f"{order}H", len(directory)) + b"".join(entries) + bytes(4) + behind
