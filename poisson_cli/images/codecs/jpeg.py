"""JPEG, through the one plugin of Pillow that it needs; and what Pillow does not ask.

Where the data end before the picture does, libjpeg fills it up with grey. That is found out in two ways. Before
anything is decoded: the data must be long enough for a picture of that size, were it all of one colour (`jpeg_scans`).
And meanwhile: the marker that ends the data is held back until all before it has been decoded, and the rows that are
not there by then were never in the file.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from io import BytesIO
from typing import Final

from PIL import Image

from poisson_cli.images import exif
from poisson_cli.images.codecs import pillow, raster
from poisson_cli.images.codecs.jpeg_scans import scans_of
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import Format
from poisson_cli.images.header import refuse_hollow
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode"]

_PIXELS_PER_BYTE: Final = 512
"""A block of 64 pixels takes a bit at least, whatever the kind."""

_DENSE: Final = 4
"""Pixels per byte of a usual photograph; only where there are more, the scans are looked at."""


class _Halting(BytesIO):
    """A file that is read up to some place first, and only then beyond it."""

    def __init__(self, data: bytes, place: int, halt: Callable[[], None]) -> None:
        super().__init__(data)
        self._place, self._halt, self._halted = place, halt, False

    def read(self, size: int | None = -1, /) -> bytes:
        before = self._place - self.tell()
        if self._halted or before < 0:
            return super().read(size)
        if before == 0:
            self._halted = True
            self._halt()
            return super().read(size)
        return super().read(before if size is None or size < 0 else min(size, before))


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode a JPEG; see `poisson_cli.images.codecs`.

    The further pictures of a multi-picture file are previews, gain maps and the like of the first one, so it counts as
    one picture, as it does in every viewer.
    """
    scans = list(scans_of(data))
    pending = scans[0].pending if len(scans) == 1 else None
    kept: list[bytes] = []
    file = BytesIO(data)
    if pending is not None:
        file = _Halting(data, scans[0].end, lambda: kept.append(_row(image, pending)))
    with pillow.opened(file, form) as image:
        asked().refuse_large(name, image.width, image.height)
        refuse_hollow(name, image.width * image.height, len(data), _PIXELS_PER_BYTE)
        if image.width * image.height > _DENSE * len(data):
            for scan in scans:
                refuse_hollow(name, scan.bits, scan.end - scan.start, 8)
        decoded = pillow.eight_bits(image, pillow.decode_mode(image, name, form, indices=indices))
        if pending is not None and kept and kept != [_row(image, pending)]:
            raise ValueError("its data end early")
        return decoded


def _row(image: Image.Image, pending: int) -> bytes:
    """The last row that must be there when only the marker that ends the data is missing."""
    row = image.height - 1 - pending
    return image._new(image.im.crop((0, row, image.width, row + 1))).tobytes() if row >= 0 else b""


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a JPEG; see `poisson_cli.images.codecs`."""
    settings = raster.settings_of(picture, form)
    metadata = picture.metadata
    if metadata.exif is not None:
        settings["exif"] = exif.MARK + metadata.exif
    if metadata.iptc is not None:
        settings["extra"] = _photoshop(metadata.iptc)
    if quality is not None:
        settings["quality"] = quality
    file = pillow.NamedBuffer()
    file.name = f"picture{form.extensions[0]}"
    with pillow.encoding():
        Image.fromarray(picture.pixels).save(file, **settings)
    return file.getvalue()


def _photoshop(iptc: bytes) -> bytes:
    """A segment with Photoshop's resources, IPTC's records the only one among them, without a name."""
    resource = struct.pack(">4sHHI", b"8BIM", pillow.IPTC_RESOURCE, 0, len(iptc))
    body = b"Photoshop 3.0\0" + resource + iptc + bytes(len(iptc) % 2)
    return struct.pack(">HH", 0xFFED, len(body) + 2) + body
