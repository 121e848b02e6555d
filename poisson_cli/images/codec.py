"""Where the decoders and encoders are reached: files' bytes <-> arrays as they are stored.

PNG and JPEG, which nearly every run reads and writes, are handed to the one plugin of Pillow that each needs. The
others go through imageio, which finds and sets up the decoder itself. It could do the same for PNG and JPEG, with the
same pixels; but importing it, and the sixty plugins of Pillow that it sets up for an encoder, takes 60 to 90 ms, and
that is more than everything else a clone of a photograph does.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from io import BytesIO
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from poisson_cli.images.formats import JPEG, PNG, Format

__all__ = ["decoded", "encoded", "opened"]

_AT_ONCE: Final = (PNG, JPEG)


def opened(data: bytes, form: Format) -> Image.Image:
    """A picture whose header has been read and whose pixels have not.

    Parameters
    ----------
    data
        The whole file.
    form
        Its format; no other decoder gets to see the file.

    Returns
    -------
    Image
        To be closed. Any exception may be raised: see `poisson_cli.images.header.decoding`.
    """
    # `Image.open` would import the plugins of five formats before it looks at the one it is told.
    importlib.import_module(f"PIL.{form.plugin}")
    open_file, _ = Image.OPEN[form.codec]
    return open_file(BytesIO(data), "")


def decoded(data: bytes, image: Image.Image, form: Format, mode: str) -> tuple[NDArray[np.uint8], int]:
    """Decode the only, or first, picture of a file.

    Parameters
    ----------
    data
        The whole file.
    image
        The same, from `opened`.
    form
        Its format.
    mode
        Pillow's name of the layout to be had: L, LA, RGB or RGBA.

    Returns
    -------
    pixels : ndarray
        (H, W) or (H, W, C), as stored.
    orientation : int
        See `poisson_cli.images.orientation`.
    """
    # The orientation is asked for after decoding: by then the TIFF decoder has turned its picture and dropped the tag.
    if form in _AT_ONCE:
        pixels = np.asarray(image.convert(mode), dtype=np.uint8)
        orientation = image.getexif().get(0x0112, 1)
    else:
        import imageio.v3 as iio

        with iio.imopen(data, "r", plugin="pillow") as file:
            pixels = np.asarray(cast("Any", file).read(index=0, mode=mode), dtype=np.uint8)
            orientation = cast("Any", file).metadata(index=0, exclude_applied=False).get("Orientation", 1)
    return pixels, orientation if isinstance(orientation, int) else 1


def encoded(pixels: NDArray[np.uint8], form: Format, settings: Mapping[str, Any]) -> bytes:
    """Encode a picture.

    Parameters
    ----------
    pixels
        (H, W) or (H, W, C), C-contiguous, in a layout that the format has.
    form
        The format.
    settings
        For the encoder.

    Returns
    -------
    bytes
        The file.
    """
    if form in _AT_ONCE:
        file = _NamedBuffer()
        file.name = f"picture{form.extensions[0]}"
        Image.fromarray(pixels).save(file, **settings)
        return file.getvalue()

    import imageio.v3 as iio

    data: bytes = iio.imwrite(
        "<bytes>", pixels, plugin="pillow", extension=form.extensions[0], is_batch=False, **settings
    )
    return data


class _NamedBuffer(BytesIO):
    """A file in memory with a name, by whose ending Pillow imports one plugin instead of five."""

    name: str
