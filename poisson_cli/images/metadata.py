"""What belongs to a picture beside its pixels, and goes along into the output."""

from __future__ import annotations

import re
from typing import Final, NamedTuple

from poisson_cli.images import exif as exif_blocks

__all__ = ["Kind", "Metadata"]

Kind = str
"""``profile``, ``exif``, ``xmp`` or ``dpi``."""

_XMP_ORIENTATION: Final = re.compile(rb"(tiff:Orientation(?:\s*=\s*[\"']|>)\s*)[0-9]")


class Metadata(NamedTuple):
    """What is carried from the destination to the output.

    Parameters
    ----------
    profile
        ICC profile that gives the pixels their meaning.
    exif
        An EXIF block: a small TIFF file without pixels, without the ``Exif`` mark of JPEG in front.
    xmp
        An XMP packet.
    dpi
        Pixels per inch, across and down.
    """

    profile: bytes | None = None
    exif: bytes | None = None
    xmp: bytes | None = None
    dpi: tuple[float, float] | None = None

    def kinds(self) -> tuple[Kind, ...]:
        """What there is."""
        return tuple(kind for kind in ("profile", "exif", "xmp", "dpi") if getattr(self, kind) is not None)

    def of_upright(self) -> Metadata:
        """The same for the picture as it is written: upright, its preview in EXIF out of date and so left out."""
        xmp = None if self.xmp is None else _XMP_ORIENTATION.sub(rb"\g<1>1", self.xmp)
        return Metadata(self.profile, exif_blocks.of_upright(self.exif), xmp, self.dpi)
