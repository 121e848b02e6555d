"""The picture formats that are read and written: how to recognise each one, and what it can hold."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

__all__ = ["FORMATS", "Format", "by_extension", "listed", "recognise"]


@dataclass(frozen=True)
class Format:
    """One picture format.

    Parameters
    ----------
    name
        As people write it.
    codec
        As the decoder calls it.
    plugin
        Pillow's module that holds the decoder.
    extensions
        File name endings in lower case, with the dot; the first is the usual one.
    alpha
        Whether it can hold an alpha channel.
    grey
        Whether it can hold a single channel; where not, grey is stored as equal red, green and blue.
    profile
        Whether it can hold an ICC profile.
    largest_side
        Greatest width and height that it can hold, in pixels.
    exact
        Whether what is read from a file is what was written.
    encoding
        Settings for the encoder.
    """

    name: str
    codec: str
    plugin: str
    extensions: tuple[str, ...]
    alpha: bool
    grey: bool
    profile: bool
    largest_side: int
    exact: bool = True
    encoding: Mapping[str, Any] = field(default_factory=dict)

    def can_hold_profile(self, profile: bytes) -> bool:
        """Whether a picture's ICC profile can go along; one for a single channel means nothing beside three."""
        return self.profile and (self.grey or profile[16:20] != b"GRAY")


PNG: Final = Format(
    name="PNG",
    codec="PNG",
    plugin="PngImagePlugin",
    extensions=(".png",),
    alpha=True,
    grey=True,
    profile=True,
    largest_side=2**31 - 1,
    # Only repeated bytes are looked for: the filters leave little else to find in a photograph. That takes a quarter
    # of the default level's time for files of the same size, within a few per cent.
    encoding=MappingProxyType({"compress_level": 1, "compress_type": zlib.Z_RLE}),
)
JPEG: Final = Format(
    name="JPEG",
    codec="JPEG",
    plugin="JpegImagePlugin",
    extensions=(".jpg", ".jpeg", ".jpe"),
    alpha=False,
    grey=True,
    profile=True,
    largest_side=65_500,
    exact=False,
    # Subsampled colours would smear the result across the border of the region that was solved for.
    encoding=MappingProxyType({"quality": 95, "subsampling": "4:4:4", "optimize": True}),
)
TIFF: Final = Format(
    name="TIFF",
    codec="TIFF",
    plugin="TiffImagePlugin",
    extensions=(".tif", ".tiff"),
    alpha=True,
    grey=True,
    profile=True,
    largest_side=2**31 - 1,
    encoding=MappingProxyType({"compression": "tiff_adobe_deflate"}),
)
BMP: Final = Format(
    name="BMP",
    codec="BMP",
    plugin="BmpImagePlugin",
    extensions=(".bmp",),
    alpha=False,  # the 32-bit kind exists, but most readers drop its fourth channel
    grey=True,
    profile=False,
    largest_side=2**31 - 1,
)
WEBP: Final = Format(
    name="WebP",
    codec="WEBP",
    plugin="WebPImagePlugin",
    extensions=(".webp",),
    alpha=True,
    grey=False,
    profile=True,
    largest_side=16_383,
    # Lossless, with the colours under transparent pixels kept, so that nothing outside the region changes. Trying
    # harder than method 0 takes six times as long for files a few per cent smaller.
    encoding=MappingProxyType({"lossless": True, "exact": True, "quality": 25, "method": 0}),
)

FORMATS: Final = (PNG, JPEG, TIFF, BMP, WEBP)

_MAGIC: Final[tuple[tuple[bytes, Format], ...]] = (
    (b"\x89PNG\r\n\x1a\n", PNG),
    (b"\xff\xd8\xff", JPEG),
    (b"II*\x00", TIFF),
    (b"MM\x00*", TIFF),
    (b"II+\x00", TIFF),
    (b"BM", BMP),
)

_FOREIGN: Final[tuple[tuple[int, bytes, str], ...]] = (
    (0, b"GIF8", "GIF"),
    (0, b"MM\x00+", "big-endian BigTIFF"),  # the decoder takes it for a plain one
    (0, b"8BPS", "Photoshop"),
    (0, b"%PDF", "PDF"),
    (0, b"\x76\x2f\x31\x01", "OpenEXR"),
    (0, b"#?R", "Radiance HDR"),
    (0, b"\xff\x0a", "JPEG XL"),
    (0, b"\x00\x00\x00\x0cJXL ", "JPEG XL"),
    (0, b"\x00\x00\x00\x0cjP  ", "JPEG 2000"),
    (0, b"\xff\x4f\xff\x51", "JPEG 2000"),
    (0, b"PK\x03\x04", "ZIP archive"),
    (0, b"<svg", "SVG"),
    (4, b"ftypavif", "AVIF"),
    (4, b"ftyp", "HEIC"),
)


def recognise(data: bytes) -> Format | str | None:
    """Tell a picture's format by its first bytes; the file name plays no part.

    Parameters
    ----------
    data
        The file, or at least its first 16 bytes.

    Returns
    -------
    Format | str | None
        The format; or the name of one that is known but not read; or None.
    """
    for magic, known in _MAGIC:
        if data.startswith(magic):
            return known
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return WEBP
    for start, magic, name in _FOREIGN:
        if data.startswith(magic, start):
            return name
    return None


def by_extension(path: Path) -> Format | None:
    """The format that a file name's ending asks for, whatever its case; None if no format has that ending."""
    ending = path.suffix.lower()
    return next((known for known in FORMATS if ending in known.extensions), None)


def listed(formats: tuple[Format, ...] = FORMATS) -> str:
    """Names of formats for a sentence: ``PNG, JPEG and TIFF``."""
    *first, last = (known.name for known in formats)
    return f"{', '.join(first)} and {last}" if first else last
