"""What an ICC profile is called, to tell two colour spaces apart."""

from __future__ import annotations

import struct
from typing import Final

__all__ = ["called", "same_colours"]

SRGB: Final = "sRGB"


def called(profile: bytes | None) -> str:
    """The name that a profile gives itself.

    Parameters
    ----------
    profile
        The profile; None counts as sRGB, which is what programs take values without a profile for.

    Returns
    -------
    str
        ``an unnamed profile`` if it has no name that can be read.
    """
    if profile is None:
        return SRGB
    try:
        return _description(profile) or "an unnamed profile"
    except (struct.error, UnicodeDecodeError):
        return "an unnamed profile"


def same_colours(one: bytes | None, other: bytes | None) -> bool:
    """Whether values mean the same colours under two profiles, as far as names can tell: all kinds of sRGB do."""
    return one == other or (SRGB in called(one) and SRGB in called(other))


def _description(profile: bytes) -> str:
    """The text of the tag ``desc``, of ICC version 2 or 4."""
    (count,) = struct.unpack_from(">I", profile, 128)
    for entry in range(min(count, 100)):
        name, start, _ = struct.unpack_from(">4sII", profile, 132 + 12 * entry)
        if name != b"desc":
            continue
        if profile[start : start + 4] == b"mluc":
            length, offset = struct.unpack_from(">II", profile, start + 20)
            text = profile[start + offset : start + offset + min(length, 200)].decode("utf-16-be")
        else:
            (length,) = struct.unpack_from(">I", profile, start + 8)
            text = profile[start + 12 : start + 12 + min(length, 200)].decode("ascii")
        return "".join(c for c in text if c.isprintable()).strip()
    return ""
