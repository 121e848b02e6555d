"""A page of a TIFF file: how its pixels are laid out, and whether they can be read without loss."""

from __future__ import annotations

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

DESCRIPTION: Final = frozenset(
    {269, 270, 271, 272, 285, 305, 306, 315, 316, 18246, 18249, 33432, 33723, *range(0x9C9B, 0x9CA0), 0x8769, 0x8825}
)  # fmt: skip
"""Tags that tell what is shown, by whom, when and where: those that go along."""

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
        """Whether the last number of each pixel is an opacity."""
        return self.numbers(EXTRA, ()) == (2,)

    def refuse_loss(self, name: str) -> None:
        """Raise `InputError` if the page cannot be read without loss."""
        refusal = self._refusal()
        if refusal is not None:
            raise InputError(f"{name}: a {refusal}")

    def _refusal(self) -> str | None:
        kinds = set(self.numbers(FORMAT, (1,)))
        extra = self.numbers(EXTRA, ())
        if kinds - {1, 3, 4}:  # 4: undefined, which writers mean as unsigned
            return "TIFF of signed or complex numbers; convert it to unsigned ones first"
        if 3 in kinds and (self.bits != 32 or kinds != {3}):
            return f"{self.bits}-bit floating-point TIFF; {_EIGHT_OR_16}"
        if self.deep and self.bits != 16 and kinds != {3}:
            return f"{self.bits}-bit TIFF; {_EIGHT_OR_16}"
        if 1 in extra:
            return "TIFF with premultiplied alpha; save it with straight (unassociated) alpha first"
        if extra not in ((), (2,)):
            return "TIFF with extra channels that are not alpha; save it without them first"
        return self._refusal_of_deep(3 in kinds) if self.deep else None

    def _refusal_of_deep(self, floats: bool) -> str | None:
        photometric = self.number(PHOTOMETRIC, 1)
        colours = {0: 1, 1: 1, 2: 3}.get(photometric)
        if colours is None or (floats and photometric == 0):
            kind = {0: "inverted", 3: "palette", 5: "CMYK", 6: "YCbCr", 8: "CIE-Lab"}.get(
                photometric, "special"
            )
            return f"{kind} TIFF of {self.bits} bits; convert it to RGB or grey first"
        if self.samples != colours + self.alpha or len(set(self.numbers(BITS, (1,)))) != 1:
            return f"TIFF of {self.samples} channels; save it as grey or RGB, with or without alpha, first"
        return None

    def metadata(self) -> Metadata:
        """What the page holds beside the pixels."""
        order = self.layout.order
        kept = {tag: entry for tag, entry in self.tags.items() if tag in DESCRIPTION}
        exif = None
        if kept:
            mark = b"II*\0" if order == "<" else b"MM\0*"
            exif = mark + struct.pack(f"{order}I", 8) + written(kept, order, 8)
        return Metadata(self._bytes(PROFILE), exif, self._bytes(XMP), self._dpi())

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


def pages_of(data: bytes) -> list[Page]:
    """The pages of a file, without reduced copies and transparency masks of others; never empty.

    Raises
    ------
    ValueError, struct.error
        If there is none.
    """
    layout = layout_of(data)
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
        if not page.number(SUBFILE, 0) & 0b101:
            pages.append(page)
        place = following
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
    if metadata.dpi is not None:
        for tag, number in zip((ACROSS, DOWN), metadata.dpi, strict=True):
            fraction = Fraction(number).limit_denominator(1000)
            tags[tag] = Entry.of_numbers(5, order, fraction.numerator, fraction.denominator)
        tags[UNIT] = Entry.of_numbers(3, order, 2)
    return order, tags
