"""A page of a TIFF file: how its pixels are laid out, and whether they can be read without loss."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from poisson_cli.errors import InputError
from poisson_cli.images.codecs.tiff_tags import Directory, Entry, Layout, layout_of, read, written
from poisson_cli.images.metadata import Metadata

__all__ = ["Page", "carried", "pages_of"]

SUBFILE: Final = 254
WIDTH: Final = 256
HEIGHT: Final = 257
BITS: Final = 258
COMPRESSION: Final = 259
PHOTOMETRIC: Final = 262
STRIP_STARTS: Final = 273
ORIENTATION: Final = 274
SAMPLES: Final = 277
ROWS_PER_STRIP: Final = 278
STRIP_SIZES: Final = 279
ACROSS: Final = 282
DOWN: Final = 283
PLANES: Final = 284
UNIT: Final = 296
PREDICTOR: Final = 317
TILE_WIDTH: Final = 322
TILE_HEIGHT: Final = 323
TILE_STARTS: Final = 324
TILE_SIZES: Final = 325
EXTRA: Final = 338
FORMAT: Final = 339
XMP: Final = 700
PROFILE: Final = 34675
IPTC: Final = 33723

DESCRIPTION: Final = frozenset(
    {269, 270, 271, 272, 285, 305, 306, 315, 316, 18246, 18249, 33432, *range(0x9C9B, 0x9CA0), 0x8769, 0x8825}
)  # fmt: skip
"""Tags that tell what is shown, by whom, when and where: those that go along."""

PARTS: Final = 330
DNG_VERSION: Final = 50706

_CANON: Final = b"CR"
"""Behind the header of Canon's raw files."""

JPEG: Final = 7
_READ: Final = frozenset({1, 2, 3, 4, 5, 6, JPEG, 8, 32773, 32946, 34925, 50000})
"""Compressions that Pillow's libtiff unpacks."""

_OTHERS: Final = {
    33003: "JPEG 2000", 33005: "JPEG 2000", 34712: "JPEG 2000", 34676: "LogLuv", 34677: "LogLuv", 34887: "LERC",
    34933: "PNG", 34934: "JPEG XR", 22610: "JPEG XR", 50001: "WebP", 50002: "JPEG XL", 52546: "JPEG XL",
}  # fmt: skip

_TOLD: Final = 270
_PLAN: Final = re.compile(rb'\s*(\{"shape":|ImageJ=|<\?xml.{0,2000}<OME|<OME)', re.DOTALL)
"""Descriptions that tell programs of science how the numbers of a file are laid out: not true of the output."""

_INKS: Final = {3: "palette", 5: "CMYK", 6: "YCbCr", 8: "CIE-Lab", 32844: "LogLuv", 32845: "LogLuv"}
_INCHES: Final = {2: 1.0, 3: 2.54}  # inches per unit of length, upside down
_MOST_PAGES: Final = 100_000
_EIGHT_OR_16: Final = "convert it to 8 or 16 bits per channel, or 32-bit floating point, first"


@dataclass(frozen=True)
class Page:
    """One page.

    Parameters
    ----------
    tags
        Its directory.
    layout
        Of its file.
    index
        Its place among all directories of the file, reduced copies included.
    """

    tags: Directory
    layout: Layout
    index: int

    def numbers(self, tag: int, default: tuple[int, ...]) -> tuple[int, ...]:
        """The whole numbers of a tag."""
        entry = self.tags.get(tag)
        return entry.numbers(self.layout.order) if isinstance(entry, Entry) else default

    def number(self, tag: int, default: int) -> int:
        """The first of them."""
        return next(iter(self.numbers(tag, ())), default)

    @property
    def width(self) -> int:
        """Pixels."""
        return self.number(WIDTH, 0)

    @property
    def height(self) -> int:
        """Pixels."""
        return self.number(HEIGHT, 0)

    @property
    def stored(self) -> tuple[int, int]:
        """(H, W) in pixels of what is stored, where tiles reach over the edge of the picture."""
        if TILE_STARTS not in self.tags:
            return self.height, self.width
        down, across = (max(1, self.number(tag, 1)) for tag in (TILE_HEIGHT, TILE_WIDTH))
        return -(-self.height // down) * down, -(-self.width // across) * across

    @property
    def samples(self) -> int:
        """Numbers per pixel."""
        return self.number(SAMPLES, 1)

    @property
    def bits(self) -> int:
        """Bits of the widest number."""
        return max(self.numbers(BITS, (1,)), default=1)

    @property
    def deep(self) -> bool:
        """Whether a number has more than eight bits."""
        return self.bits > 8

    @property
    def alpha(self) -> bool:
        """Whether the last number of each pixel is an opacity.

        OpenCV leaves out the tag that would say so, and no other program takes a fourth number for anything else.
        """
        extra = self.numbers(EXTRA, ())
        return extra in ((1,), (2,)) or (extra == () and self._colours == 3 and self.samples == 4)

    @property
    def premultiplied(self) -> bool:
        """Whether colours are multiplied by the opacity."""
        return self.numbers(EXTRA, ()) == (1,)

    @property
    def in_sheets(self) -> bool:
        """Whether Pillow has no layout for it, or the wrong one: it takes planes of grey and alpha for pixels."""
        grey_alpha = self.bits == 8 and self._colours == 1 and self.samples == 2
        return self.deep or (grey_alpha and self.number(COMPRESSION, 1) != JPEG)

    @property
    def _colours(self) -> int | None:
        """Numbers per pixel that are light; None where they are anything else."""
        return {0: 1, 1: 1, 2: 3}.get(self.number(PHOTOMETRIC, 1))

    def refuse_loss(self, name: str) -> None:
        """Raise `InputError` if the page cannot be read without loss."""
        refusal = self._refusal()
        if refusal is not None:
            raise InputError(f"{name}: a {refusal}")

    def _refusal(self) -> str | None:
        kinds = set(self.numbers(FORMAT, (1,)))
        extra = self.numbers(EXTRA, ())
        packing = self.number(COMPRESSION, 1)
        if packing not in _READ:
            method = _OTHERS.get(packing, f"method {packing}")
            return f"TIFF compressed with {method}, which is not read; save it with LZW or Deflate first"
        if kinds - {1, 3, 4}:  # 4: undefined, which writers mean as unsigned
            return "TIFF of signed or complex numbers; convert it to unsigned ones first"
        if 3 in kinds and (self.bits != 32 or kinds != {3}):
            return f"{self.bits}-bit floating-point TIFF; {_EIGHT_OR_16}"
        if self.deep and self.bits != 16 and kinds != {3}:
            return f"{self.bits}-bit TIFF; {_EIGHT_OR_16}"
        if extra not in ((), (1,), (2,)):
            return "TIFF with extra channels that are not alpha; save it without them first"
        photometric = self.number(PHOTOMETRIC, 1)
        if 3 in kinds and photometric == 0:
            return "TIFF of floating-point numbers where white is 0; turn them round first"
        if self.deep and self._colours is None:
            kind = _INKS.get(photometric, "special")
            return f"{kind} TIFF of {self.bits} bits; convert it to RGB or grey first"
        if self._colours is not None and (
            self.samples != self._colours + self.alpha or len(set(self.numbers(BITS, (1,)))) != 1
        ):
            return f"TIFF of {self.samples} channels; save it as grey or RGB, with or without alpha, first"
        return None

    def metadata(self) -> Metadata:
        """What the page holds beside the pixels."""
        order = self.layout.order
        kept = {tag: entry for tag, entry in self.tags.items() if tag in DESCRIPTION}
        told = kept.get(_TOLD)
        if isinstance(told, Entry) and _PLAN.match(told.data):
            del kept[_TOLD]
        exif = None
        if kept:
            mark = b"II*\0" if order == "<" else b"MM\0*"
            exif = mark + struct.pack(f"{order}I", 8) + written(kept, order, 8)
        return Metadata(self._bytes(PROFILE), exif, self._bytes(XMP), self._dpi(), self._bytes(IPTC))

    def _bytes(self, tag: int) -> bytes | None:
        entry = self.tags.get(tag)
        return entry.data or None if isinstance(entry, Entry) else None

    def _dpi(self) -> tuple[float, float] | None:
        across, down = self.tags.get(ACROSS), self.tags.get(DOWN)
        scale = _INCHES.get(self.number(UNIT, 2))
        if not isinstance(across, Entry) or not isinstance(down, Entry) or scale is None:
            return None
        dpi = across.fraction(self.layout.order) * scale, down.fraction(self.layout.order) * scale
        return dpi if all(0 < number < 1e6 for number in dpi) else None


def pages_of(data: bytes, name: str) -> list[Page]:
    """The pages of a file, without reduced copies and transparency masks of others; never empty.

    Parameters
    ----------
    data
        The whole file.
    name
        What the user calls it.

    Raises
    ------
    InputError
        If it is what a camera's sensor saw; the pages of such a file are previews.
    ValueError, struct.error
        If there is no page.
    """
    layout = layout_of(data)
    raw = data[8:10] == _CANON
    place = layout.first
    seen: set[int] = set()
    pages: list[Page] = []
    while place and place not in seen and len(seen) < _MOST_PAGES:
        seen.add(place)
        try:
            tags, following = read(data, layout, place)
        except (ValueError, struct.error):
            if not pages:
                raise
            break
        page = Page(tags, layout, len(seen) - 1)
        raw |= DNG_VERSION in tags or (PARTS in tags and bool(page.number(SUBFILE, 0) & 1) and len(seen) == 1)
        if not page.number(SUBFILE, 0) & 0b101:
            pages.append(page)
        place = following
    if raw:
        raise InputError(f"{name}: a camera's raw file; develop it, and save a TIFF of 16 bits first")
    if not pages:
        raise ValueError("no page in it")
    return pages


def carried(metadata: Metadata) -> tuple[str, Directory]:
    """What belongs to a picture as tags of a page, and the order of their bytes."""
    order, tags = "<", {}
    if metadata.exif is not None:
        layout = layout_of(metadata.exif)
        order = layout.order
        block, _ = read(metadata.exif, layout, layout.first)
        tags = {tag: entry for tag, entry in block.items() if tag in DESCRIPTION}
    if metadata.profile is not None:
        tags[PROFILE] = Entry(7, metadata.profile)
    if metadata.xmp is not None:
        tags[XMP] = Entry(1, metadata.xmp)
    if metadata.iptc is not None:
        tags[IPTC] = Entry(7, metadata.iptc)
    if metadata.dpi is not None:
        for tag, number in zip((ACROSS, DOWN), metadata.dpi, strict=True):
            fraction = Fraction(number).limit_denominator(1000)
            tags[tag] = Entry.of_numbers(5, order, fraction.numerator, fraction.denominator)
        tags[UNIT] = Entry.of_numbers(3, order, 2)
    return order, tags
