"""OpenEXR, through its own library, which comes with the extra ``exr``."""

from __future__ import annotations

import json
import subprocess
import sys
from io import BytesIO
from typing import Any, Final

import numpy as np

from poisson_cli.errors import InputError, OutputError
from poisson_cli.images.codecs import exr_reader
from poisson_cli.images.codecs.quiet import quiet
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import Format
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode"]

_SEVERAL_PARTS: Final = 0x10
"""Bit in the sixth byte of a file."""

_TRANSPARENT: Final = (
    "transparent in places, and the colours of OpenEXR are premultiplied then; flatten it, or use a format with "
    "straight alpha"
)
_COLOURS: Final = ("R", "G", "B")


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode the first part of a file; see `poisson_cli.images.codecs`.

    Halves become floats, which is exact. A process of its own reads it, see `exr_reader`.
    """
    if data[5] & _SEVERAL_PARTS:
        asked().notices.append(f"{name} holds several parts: the first one is used")
    ran = subprocess.run(
        [sys.executable, "-P", exr_reader.__file__, str(asked().largest)],
        input=data,
        stdout=subprocess.PIPE,
        check=False,
    )
    line, _, body = ran.stdout.partition(b"\n")
    said: dict[str, Any] = {"damaged": "its reader came to grief"}
    if ran.returncode == 0 and line:
        said = json.loads(line)
    if "refused" in said:
        raise InputError(f"{name}: {said['refused']}")
    if "damaged" in said:
        raise ValueError(said["damaged"])
    asked().refuse_large(name, said["width"], said["height"])
    if said["in_part"]:
        asked().notices.append(
            f"{name} is part of a larger picture, or a larger one than is shown: the output says no longer which"
        )
    planes = np.frombuffer(body, np.float32).reshape(-1, said["height"], said["width"])
    alpha = said["channels"][-1] == "A"
    if alpha and (planes[-1] != 1).any():
        raise InputError(f"{name}: an OpenEXR that is {_TRANSPARENT}")
    return Decoded(np.ascontiguousarray(np.moveaxis(planes, 0, 2)), alpha)


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a picture; see `poisson_cli.images.codecs`."""
    import OpenEXR

    pixels = picture.pixels
    colours = {"Y": pixels} if pixels.ndim == 2 else {c: pixels[..., k] for k, c in enumerate(_COLOURS)}
    if picture.alpha is not None:
        if (picture.alpha != 1).any():
            raise OutputError(f"{picture.name} is {_TRANSPARENT}")
        colours["A"] = picture.alpha
    channels = {channel: np.ascontiguousarray(plane) for channel, plane in colours.items()}
    file = BytesIO()
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with quiet():
        OpenEXR.File(header, channels).write(file)
    return file.getvalue()
