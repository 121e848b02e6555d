"""JPEG, BMP, WebP and GIF.

JPEG, which nearly every run reads or writes, is handed to the one plugin of Pillow that it needs, as PNG is (`png`).
The others go through imageio, which finds and sets up the decoder itself. It could do the same for JPEG, with the same
pixels; but importing it, and all the plugins of Pillow that it sets up for an encoder, takes about 50 ms, several times
as long as the solve of a clone of usual size.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final, cast

import numpy as np
from PIL import Image

from poisson_cli.images import exif
from poisson_cli.images.codecs import pillow
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import BMP, GIF, JPEG, WEBP, Format
from poisson_cli.images.header import refuse_hollow
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode", "page_of"]

_PIXELS_PER_BYTE: Final = {
    JPEG: 512,  # a block of 64 pixels takes a bit at least; past its end, a file would be read on as grey
    GIF: 2600,  # twelve bits stand for fewer than 4096 pixels
    BMP: 8,  # where it is not compressed
}
"""How many pixels a byte can hold at most."""


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode a picture of at most eight bits; see `poisson_cli.images.codecs`."""
    with pillow.opened(data, form) as image:
        asked().refuse_large(name, image.width, image.height)
        if form in _PIXELS_PER_BYTE and not (form is BMP and image.info.get("compression")):
            refuse_hollow(name, image.width * image.height, len(data), _PIXELS_PER_BYTE[form])
        page = page_of(image, name)
        if page:
            image.seek(page)
        mode = pillow.decode_mode(image, name, form, indices=indices)
        if form is JPEG:
            return pillow.eight_bits(image, mode)
        palette = image.mode == "P"
        metadata, orientation = pillow.metadata_of(image), pillow.orientation_of(image)

    import imageio.v3 as iio

    with _no_limit(), iio.imopen(data, "r", plugin="pillow") as file:
        pixels = np.asarray(cast("Any", file).read(index=page, mode=mode), dtype=np.uint8)
    return Decoded(pixels, mode in ("LA", "RGBA"), orientation, palette, metadata)


def page_of(image: Image.Image, name: str) -> int:
    """Which frame of an animation to read, from 0.

    The further pictures of a multi-picture JPEG are previews, gain maps and the like of the first one, so it counts
    as one picture, as it does in every viewer.
    """
    count = getattr(image, "n_frames", 1)
    return 0 if image.format in ("MPO", "JPEG") else asked().choose(name, count, "frames")


@contextmanager
def _no_limit() -> Iterator[None]:
    """Pillow's own limit on the size of a picture out of force: ours was."""
    usual = Image.MAX_IMAGE_PIXELS
    Image.MAX_IMAGE_PIXELS = None
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = usual


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a picture of eight bits; see `poisson_cli.images.codecs`."""
    settings = _settings_of(picture, form)
    if quality is not None:
        settings["quality"] = quality
        if form is WEBP:
            settings |= {"lossless": False, "method": 4}
    if form is JPEG:
        return _encode_with_pillow(picture, form, settings)

    import imageio.v3 as iio

    pixels = pillow.interleaved(picture.pixels, picture.alpha)
    data: bytes = iio.imwrite(
        "<bytes>", pixels, plugin="pillow", extension=form.extensions[0], is_batch=False, **settings
    )
    return data


def _settings_of(picture: Picture, form: Format) -> dict[str, Any]:
    """Pillow's settings for a format, and for all that belongs to a picture."""
    metadata = picture.metadata
    settings: dict[str, Any] = dict(form.encoding)
    if metadata.profile is not None:
        settings["icc_profile"] = metadata.profile
    if metadata.exif is not None:
        settings["exif"] = exif.MARK + metadata.exif if form is JPEG else metadata.exif
    if metadata.xmp is not None:
        settings["xmp"] = metadata.xmp
    if metadata.dpi is not None:
        settings["dpi"] = metadata.dpi
    return settings


def _encode_with_pillow(picture: Picture, form: Format, settings: Mapping[str, Any]) -> bytes:
    """Encode a picture of eight bits with the one plugin of Pillow that it needs."""
    file = pillow.NamedBuffer()
    file.name = f"picture{form.extensions[0]}"
    Image.fromarray(pillow.interleaved(picture.pixels, picture.alpha)).save(file, **settings)
    return file.getvalue()
