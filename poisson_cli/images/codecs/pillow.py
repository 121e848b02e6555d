"""Pictures of at most eight bits through Pillow: what its header says, its pixels, and what belongs to them.

A decoder asked for pixels hands over *something* for nearly every file: a fourth channel dropped, inks taken for
opacity. So the layout is judged here first, and what would lose anything is refused by name.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFile

from poisson_cli.errors import InputError
from poisson_cli.images import exif
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import Format
from poisson_cli.images.metadata import Metadata

__all__ = [
    "IPTC_RESOURCE",
    "NamedBuffer",
    "decode_mode",
    "eight_bits",
    "encoding",
    "metadata_of",
    "opened",
    "orientation_of",
    "pixels_of",
    "unlimited",
]

_DECODE_AS: Final = {"1": "L", "L": "L", "LA": "LA", "P": "RGB", "PA": "RGBA", "RGB": "RGB", "RGBA": "RGBA"}
_WITH_TRANSPARENT_COLOUR: Final = {"L": "LA", "RGB": "RGBA"}
_OTHER_MODES: Final = {"CMYK": "CMYK", "YCbCr": "YCbCr", "LAB": "CIE-Lab"}

IPTC_RESOURCE: Final = 0x0404
"""Photoshop's number for IPTC's records."""

_BAND: Final = 1 << 23
"""Pixels that are handed over at a time."""

_MOST_DPI: Final = 1e6


@contextmanager
def opened(data: bytes | BytesIO, form: Format) -> Iterator[ImageFile.ImageFile]:
    """A picture whose header has been read and whose pixels have not.

    Parameters
    ----------
    data
        The whole file.
    form
        Its format; no other decoder gets to see the file.

    Yields
    ------
    Image
        To be decoded while the ``with`` lasts. Pillow's own limits on its size are out of force until then:
        ours count, see `poisson_cli.images.demands`.
    """
    # `Image.open` would import the plugins of five formats before it looks at the one it is told.
    importlib.import_module(f"PIL.{form.plugin}")
    open_file, _ = Image.OPEN[form.pillow]
    file = BytesIO(data) if isinstance(data, bytes) else data
    with unlimited(), open_file(file, "") as image:
        yield image


@contextmanager
def unlimited() -> Iterator[None]:
    """Pillow's own limit on the size of a picture out of force."""
    usual = Image.MAX_IMAGE_PIXELS
    Image.MAX_IMAGE_PIXELS = None
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = usual


def decode_mode(image: Image.Image, name: str, form: Format, *, indices: bool) -> str:
    """The mode of Pillow's that holds all of a picture's pixels without loss.

    Parameters
    ----------
    image
        The picture, not decoded yet.
    name
        What the user calls it.
    form
        Its format.
    indices
        Whether to leave a palette unapplied.

    Raises
    ------
    InputError
        If it is too large, or there is no such mode.
    """
    asked().refuse_large(name, image.width, image.height)
    mode = _DECODE_AS.get(image.mode)
    if mode is None:
        kind = _OTHER_MODES.get(image.mode, image.mode)
        raise InputError(f"{name}: a {kind} {form.name}; convert it to RGB or grey first")
    if indices and image.mode in ("P", "1", "L"):
        return "P" if image.mode == "P" else "L"
    if "transparency" in image.info:
        mode = _WITH_TRANSPARENT_COLOUR.get(mode, mode)
    return mode


def eight_bits(image: Image.Image, mode: str) -> Decoded:
    """Decode a picture of eight bits or fewer.

    Parameters
    ----------
    image
        From `opened`, at the right page.
    mode
        From `decode_mode`.
    """
    palette = image.mode in ("P", "PA")
    pixels = pixels_of(image, mode)
    # These are asked for after decoding: some formats keep them behind the pixels, and Pillow turns the picture of a
    # TIFF by itself and drops the tag.
    return Decoded(pixels, mode in ("LA", "RGBA"), orientation_of(image), palette, metadata_of(image))


def pixels_of(image: Image.Image, mode: str) -> NDArray[np.uint8]:
    """Decode a picture, (H, W) or (H, W, C).

    Parameters
    ----------
    image
        From `opened`, at the right page.
    mode
        Of Pillow's, with eight bits per channel, to convert it to.
    """
    image.load()  # some formats know their size only now
    height, width = image.height, image.width
    if height * width <= _BAND:
        return np.asarray(image if image.mode == mode else image.convert(mode), dtype=np.uint8)
    # Pillow hands over twice what it converts; so of a large picture it gets a part at a time.
    channels = len(mode)
    pixels = np.empty((height, width) if channels == 1 else (height, width, channels), np.uint8)
    rows = max(1, _BAND // width)
    for top in range(0, height, rows):
        band = image.crop((0, top, width, min(top + rows, height)))
        pixels[top : top + rows] = np.asarray(band if band.mode == mode else band.convert(mode))
    return pixels


def orientation_of(image: Image.Image) -> int:
    """The Orientation tag, wherever the format keeps it; 1 if nobody can tell."""
    try:
        orientation = image.getexif().get(0x0112, 1)
    except Exception:  # a damaged block is no reason to refuse the picture
        orientation = exif.orientation(exif.bare(image.info.get("exif")))
    return orientation if isinstance(orientation, int) else 1


def metadata_of(image: Image.Image) -> Metadata:
    """What the file holds beside the pixels."""
    info: dict[Any, Any] = image.info
    return Metadata(
        profile=_bytes(info.get("icc_profile")),
        exif=exif.bare(_bytes(info.get("exif"))),
        xmp=_bytes(info.get("xmp")),
        dpi=_resolution(info.get("dpi")),
        iptc=_iptc(info.get("photoshop")),
    )


def _iptc(resources: object) -> bytes | None:
    """IPTC's records among what Photoshop keeps in a JPEG; a preview is there as well, which is left out."""
    return _bytes(resources.get(IPTC_RESOURCE)) if isinstance(resources, dict) else None


def _bytes(value: object) -> bytes | None:
    if isinstance(value, str):
        value = value.encode()
    return value or None if isinstance(value, bytes) else None


def _resolution(value: object) -> tuple[float, float] | None:
    """Two numbers that can be pixels per inch, or nothing."""
    try:
        across, down = (float(number) for number in cast("Any", value))
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    fine = all(math.isfinite(number) and 0 < number < _MOST_DPI for number in (across, down))
    return (across, down) if fine else None


@contextmanager
def encoding() -> Iterator[None]:
    """Turn what an encoder raises when it cannot go on into what all others raise then."""
    try:
        yield
    except ValueError as error:
        raise OSError(str(error)) from error


class NamedBuffer(BytesIO):
    """A file in memory with a name, by whose ending Pillow imports one plugin instead of five."""

    name: str


def interleaved(pixels: NDArray[Any], alpha: NDArray[Any] | None) -> NDArray[Any]:
    """Pixels as files store them, (H, W) or (H, W, C), alpha last; contiguous."""
    return np.ascontiguousarray(pixels if alpha is None else np.dstack((pixels, alpha)))
