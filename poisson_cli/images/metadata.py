"""What belongs to a picture beside its pixels, and goes along into the output."""

from __future__ import annotations

import re
from typing import Final, NamedTuple

from poisson_cli.images import exif as exif_blocks

__all__ = ["Kind", "Metadata"]

Kind = str
"""``profile``, ``exif``, ``xmp``, ``dpi`` or ``iptc``."""

# Patterns, which most pictures need none of: they are compiled when one does.
_XMP_ORIENTATION: Final = rb"(tiff:Orientation(?:\s*=\s*[\"']|>)\s*)[0-9]"
_XMP_PREVIEWS: Final = rb"(?s)<(xmp|xap):Thumbnails\b.*?</\1:Thumbnails>"
_XMP_SIDES: Final = tuple(
    rb"((?:exif:Pixel%bDimension|tiff:Image%b)(?:\s*=\s*[\"']|>)\s*)[0-9]+" % names
    for names in ((b"Y", b"Length"), (b"X", b"Width"))
)


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
    iptc
        The older captions and keywords of the press, as IPTC's records are stored.
    """

    profile: bytes | None = None
    exif: bytes | None = None
    xmp: bytes | None = None
    dpi: tuple[float, float] | None = None
    iptc: bytes | None = None

    def kinds(self) -> tuple[Kind, ...]:
        """What there is."""
        return tuple(
            kind for kind in ("profile", "exif", "xmp", "dpi", "iptc") if getattr(self, kind) is not None
        )

    def of_upright(self) -> Metadata:
        """The same for the picture as it is written: upright, and without the previews, which are out of date."""
        xmp = self.xmp
        if xmp is not None:
            xmp = re.sub(_XMP_PREVIEWS, b"", re.sub(_XMP_ORIENTATION, rb"\g<1>1", xmp))
        return self._replace(exif=exif_blocks.of_upright(self.exif), xmp=xmp)

    def of_size(self, height: int, width: int) -> Metadata:
        """The same for a picture of some size in pixels, wherever that stands."""
        xmp = self.xmp
        if xmp is not None:
            for pattern, side in zip(_XMP_SIDES, (height, width), strict=True):
                xmp = re.sub(pattern, rb"\g<1>%d" % side, xmp)
        return self._replace(exif=exif_blocks.of_size(self.exif, height, width), xmp=xmp)
