"""BMP, WebP and GIF, through imageio, which finds and sets up the decoder itself.

It could do the same for JPEG (`jpeg`) and PNG (`png`), which nearly every run reads or writes, with the same pixels;
but importing it, and all the plugins of Pillow that it sets up for an encoder, takes about 50 ms, several times as long
as the solve of a clone of usual size.
"""

from __future__ import annotations

import struct
from typing import Any, Final, cast

import numpy as np
from PIL import Image, ImageFile

from poisson_cli.errors import InputError
from poisson_cli.images.codecs import pillow
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import BMP, GIF, WEBP, Format
from poisson_cli.images.header import refuse_hollow
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode", "page_of", "settings_of"]

_PIXELS_PER_BYTE: Final = {
    GIF: 2600,  # twelve bits stand for fewer than 4096 pixels
    BMP: 8,  # where it is not compressed
}
"""How many pixels a byte can hold at most."""

_LARGE: Final = 1 << 24  # pixels
_FIRST_CHUNKS: Final = 1 << 24  # bytes, in which the first frame begins


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode a picture of at most eight bits; see `poisson_cli.images.codecs`."""
    with pillow.opened(data, form) as image:
        asked().refuse_large(name, image.width, image.height)
        if form in _PIXELS_PER_BYTE and not (form is BMP and image.info.get("compression")):
            refuse_hollow(name, image.width * image.height, len(data), _PIXELS_PER_BYTE[form])
        page = page_of(image, name)
        _refuse_empty(image, name, _drawn(image, data, form))
        if page:
            image.seek(page)
        mode = pillow.decode_mode(image, name, form, indices=indices)
        palette = image.mode == "P"
        metadata, orientation = pillow.metadata_of(image), pillow.orientation_of(image)

    import imageio.v3 as iio

    with pillow.unlimited(), iio.imopen(data, "r", plugin="pillow") as file:
        pixels = np.asarray(cast("Any", file).read(index=page, mode=mode), dtype=np.uint8)
    return Decoded(pixels, mode in ("LA", "RGBA"), orientation, palette, metadata)


def _drawn(image: ImageFile.ImageFile, data: bytes, form: Format) -> tuple[int, int]:
    """Width and height of what the first frame of an animation draws; those of the whole if there is no knowing."""
    if form is GIF and image.tile and image.tile[0].extents is not None:
        _, _, right, bottom = image.tile[0].extents
        return right, bottom
    if form is WEBP and data[12:16] == b"VP8X":
        place = 12
        while place + 24 <= len(data) and place < _FIRST_CHUNKS:
            name, length = struct.unpack_from("<4sI", data, place)
            if name == b"ANMF":
                width, height = (
                    int.from_bytes(data[place + at : place + at + 3], "little") + 1 for at in (14, 17)
                )
                return width, height
            place += 8 + length + length % 2
    return image.size


def _refuse_empty(image: ImageFile.ImageFile, name: str, drawn: tuple[int, int]) -> None:
    """Refuse a picture that claims to be large and then draws next to nothing."""
    width, height = drawn
    if image.width * image.height > max(_LARGE, 16 * width * height):
        raise InputError(
            f"{name}: damaged, its header claims {image.width}x{image.height} pixels, and it draws {width}x{height}"
        )


def page_of(image: Image.Image, name: str) -> int:
    """Which frame of an animation to read, from 0."""
    return asked().choose(name, getattr(image, "n_frames", 1), "frames")


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a picture of eight bits; see `poisson_cli.images.codecs`."""
    settings = settings_of(picture, form)
    if quality is not None:
        settings["quality"] = quality
        if form is WEBP:
            settings |= {"lossless": False, "method": 4}
    import imageio.v3 as iio

    pixels = pillow.interleaved(picture.pixels, picture.alpha)
    with pillow.encoding():
        data: bytes = iio.imwrite(
            "<bytes>", pixels, plugin="pillow", extension=form.extensions[0], is_batch=False, **settings
        )
    return data


def settings_of(picture: Picture, form: Format) -> dict[str, Any]:
    """Pillow's settings for a format, and for all that belongs to a picture."""
    metadata = picture.metadata
    settings: dict[str, Any] = dict(form.encoding)
    if metadata.profile is not None:
        settings["icc_profile"] = metadata.profile
    if metadata.exif is not None:
        settings["exif"] = metadata.exif
    if metadata.xmp is not None:
        settings["xmp"] = metadata.xmp
    if metadata.dpi is not None:
        settings["dpi"] = metadata.dpi
    return settings
