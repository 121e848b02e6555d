"""The picture formats that are read and written: how to recognise each one, and what it can hold."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any, Final, NamedTuple

from poisson_cli.images.depth import Depth
from poisson_cli.images.metadata import Kind

__all__ = ["FORMATS", "WRITTEN", "Format", "by_extension", "listed", "recognise"]


class Format(NamedTuple):
    """One picture format.

    Parameters
    ----------
    name
        As people write it.
    codec
        Module of `poisson_cli.images.codecs` that decodes and encodes it; imported when a file asks for it.
    extensions
        File name endings in lower case, with the dot; the first is the usual one. None for a format that is read only.
    depths
        What a channel can have when it is written.
    alpha
        Whether it can hold an alpha channel.
    grey
        Whether it can hold a single channel; where not, grey is stored as equal red, green and blue.
    carries
        What it can hold beside the pixels.
    largest_side
        Greatest width and height that it can hold, in pixels.
    exact
        Whether what is read from a file is what was written.
    quality
        Whether ``--quality`` means something to it.
    package, extra
        A package that it needs besides those that are always there, and our extra that brings it.
    pillow, plugin
        What Pillow calls it, and the module of Pillow that reads it; for those that Pillow reads.
    encoding
        Settings for Pillow's encoder, by name.
    """

    name: str
    codec: str
    extensions: tuple[str, ...] = ()
    depths: tuple[Depth, ...] = ("8",)
    alpha: bool = False
    grey: bool = True
    carries: tuple[Kind, ...] = ()
    largest_side: int = 2**31 - 1
    exact: bool = True
    quality: bool = False
    package: str = ""
    extra: str = ""
    pillow: str = ""
    plugin: str = ""
    encoding: tuple[tuple[str, Any], ...] = ()

    @property
    def absent(self) -> str | None:
        """What to say where the package is not installed; None where it is, or none is needed."""
        if not self.package or importlib.util.find_spec(self.package) is not None:
            return None
        return f"{self.name} needs a further package: pip install 'poisson-cli[{self.extra}]'"

    def can_hold_profile(self, profile: bytes) -> bool:
        """Whether a picture's ICC profile can go along; one for a single channel means nothing beside three."""
        return "profile" in self.carries and (self.grey or profile[16:20] != b"GRAY")


PNG: Final = Format(
    name="PNG",
    codec="png",
    extensions=(".png",),
    depths=("8", "16"),
    alpha=True,
    carries=("profile", "exif", "xmp", "dpi"),
    pillow="PNG",
    plugin="PngImagePlugin",
)
JPEG: Final = Format(
    name="JPEG",
    codec="jpeg",
    extensions=(".jpg", ".jpeg", ".jpe"),
    carries=("profile", "exif", "xmp", "dpi", "iptc"),
    largest_side=65_500,
    exact=False,
    quality=True,
    pillow="JPEG",
    plugin="JpegImagePlugin",
    # Subsampled colours would smear the result across the border of the region that was solved for.
    encoding=(("quality", 95), ("subsampling", "4:4:4"), ("optimize", True)),
)
TIFF: Final = Format(
    name="TIFF",
    codec="tiff",
    extensions=(".tif", ".tiff"),
    depths=("8", "16", "float"),
    alpha=True,
    carries=("profile", "exif", "xmp", "dpi", "iptc"),
    pillow="TIFF",
    plugin="TiffImagePlugin",
)
BMP: Final = Format(
    name="BMP",
    codec="raster",
    extensions=(".bmp",),  # the 32-bit kind exists, but most readers drop its fourth channel
    carries=("dpi",),
    pillow="BMP",
    plugin="BmpImagePlugin",
)
WEBP: Final = Format(
    name="WebP",
    codec="raster",
    extensions=(".webp",),
    alpha=True,
    grey=False,
    carries=("profile", "exif", "xmp"),
    largest_side=16_383,
    quality=True,
    pillow="WEBP",
    plugin="WebPImagePlugin",
    # Lossless, with the colours under transparent pixels kept, so that nothing outside the region changes. Trying
    # harder than method 0 takes six times as long for files a few per cent smaller.
    encoding=(("lossless", True), ("exact", True), ("quality", 25), ("method", 0)),
)
GIF: Final = Format(name="GIF", codec="raster", pillow="GIF", plugin="GifImagePlugin")
PNM: Final = Format(
    name="PNM",
    codec="pnm",
    extensions=(".ppm", ".pgm", ".pnm"),
    depths=("8", "16"),
)
PFM: Final = Format(name="PFM", codec="pnm", extensions=(".pfm",), depths=("float",))
HDR: Final = Format(
    name="Radiance HDR",
    codec="hdr",
    extensions=(".hdr",),
    depths=("float",),
    grey=False,
    largest_side=2**20,
    exact=False,
)
EXR: Final = Format(
    name="OpenEXR",
    codec="exr",
    extensions=(".exr",),
    depths=("float",),
    alpha=True,  # where it is opaque
    largest_side=2**20,
    package="OpenEXR",
    extra="exr",
)

FORMATS: Final = (PNG, JPEG, TIFF, BMP, WEBP, GIF, PNM, PFM, HDR, EXR)
WRITTEN: Final = tuple(known for known in FORMATS if known.extensions)

_MAGIC: Final[tuple[tuple[bytes, Format], ...]] = (
    (b"\x89PNG\r\n\x1a\n", PNG),
    (b"\xff\xd8\xff", JPEG),
    (b"II*\x00", TIFF),
    (b"MM\x00*", TIFF),
    (b"II+\x00", TIFF),
    (b"MM\x00+", TIFF),
    (b"BM", BMP),
    (b"GIF87a", GIF),
    (b"GIF89a", GIF),
    (b"#?RADIANCE", HDR),
    (b"#?RGBE", HDR),
    (b"\x76\x2f\x31\x01", EXR),
    *((b"P%d%c" % (kind, blank), PNM) for kind in range(1, 7) for blank in b" \t\r\n#"),
    *((b"P%c%c" % (kind, blank), PFM) for kind in b"fF" for blank in b" \t\r\n"),
)

_RAW: Final = "a camera's raw file"

_FOREIGN: Final[tuple[tuple[int, bytes, str], ...]] = (
    (0, b"8BPS", "Photoshop"),
    (0, b"%PDF", "PDF"),
    (0, b"P7\n", "PAM"),
    (0, b"\xff\x0a", "JPEG XL"),
    (0, b"\x00\x00\x00\x0cJXL ", "JPEG XL"),
    (0, b"\x00\x00\x00\x0cjP  ", "JPEG 2000"),
    (0, b"\xff\x4f\xff\x51", "JPEG 2000"),
    (0, b"PK\x03\x04", "ZIP archive"),
    (0, b"<svg", "SVG"),
    (4, b"ftypavif", "AVIF"),
    (4, b"ftypavis", "AVIF"),
    *((4, b"ftyp" + brand, "HEIC") for brand in (b"hei", b"hev", b"mif1", b"msf1")),
    (4, b"ftypcrx ", _RAW),
    (4, b"ftyp", "a video"),
    (0, b"FUJIFILMCCD-RAW", _RAW),
    (0, b"IIU\0", _RAW),
    (0, b"IIRO", _RAW),
    (0, b"IIRS", _RAW),
    (0, b"gimp xcf", "XCF"),
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
    return next((known for known in WRITTEN if ending in known.extensions), None)


def listed(formats: tuple[Format, ...] = FORMATS) -> str:
    """Names of formats for a sentence: ``PNG, JPEG and TIFF``."""
    *first, last = (known.name for known in formats)
    return f"{', '.join(first)} and {last}" if first else last
