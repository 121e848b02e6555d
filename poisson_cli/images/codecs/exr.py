"""OpenEXR, through its own library, which comes with the extra ``exr``."""

from __future__ import annotations

from io import BytesIO
from typing import Any, Final

import numpy as np

from poisson_cli.errors import InputError, OutputError, PoissonError
from poisson_cli.images.codecs.quiet import quiet
from poisson_cli.images.decoded import Decoded
from poisson_cli.images.demands import asked
from poisson_cli.images.formats import Format
from poisson_cli.images.picture import Picture

__all__ = ["decode", "encode"]

_SEVERAL_PARTS: Final = 0x10
"""Bit in the sixth byte of a file."""

_WHOLE: Final = 0
"""OpenEXR's number for channels of whole numbers."""

_TRANSPARENT: Final = (
    "transparent in places, and the colours of OpenEXR are premultiplied then; flatten it, or use a format with "
    "straight alpha"
)
_COLOURS: Final = ("R", "G", "B")
_LAYOUTS: Final = (("R", "G", "B", "A"), ("R", "G", "B"), ("Y", "A"), ("Y",))


def _library(name: str, failure: type[PoissonError]) -> Any:
    """The package; an error that names the extra if it is not there."""
    try:
        import OpenEXR
    except ImportError as error:
        raise failure(f"{name}: OpenEXR needs a further package: pip install 'poisson-cli[exr]'") from error
    return OpenEXR


def decode(data: bytes, name: str, form: Format, *, indices: bool = False) -> Decoded:
    """Decode the first part of a file; see `poisson_cli.images.codecs`.

    Halves become floats, which is exact.
    """
    library = _library(name, InputError)
    import Imath

    if data[5] & _SEVERAL_PARTS:
        asked().notices.append(f"{name} holds several parts: the first one is used")
    # The newer interface of the library, `File`, writes a line to stdout for a damaged file, and says no more.
    with quiet():
        file = library.InputFile(BytesIO(data))
        header = file.header()
        window = header["dataWindow"]
        width, height = window.max.x - window.min.x + 1, window.max.y - window.min.y + 1
        asked().refuse_large(name, width, height)
        names = _channels(header, name)
        floats = Imath.PixelType(Imath.PixelType.FLOAT)
        planes = [
            np.frombuffer(file.channel(channel, floats), np.float32).reshape(height, width)
            for channel in names
        ]
    if names[-1] == "A" and (planes[-1] != 1).any():
        raise InputError(f"{name}: an OpenEXR that is {_TRANSPARENT}")
    return Decoded(np.stack(planes, axis=2), alpha=names[-1] == "A")


def _channels(header: dict[str, Any], name: str) -> tuple[str, ...]:
    """Names of the channels, colours first; `InputError` if they are not what a picture has."""
    channels = header["channels"]
    if not str(header.get("type", "scanlineimage")).strip("b'").startswith(("scanline", "tiled")):
        raise InputError(f"{name}: a deep OpenEXR; flatten it first")
    names = next((layout for layout in _LAYOUTS if set(layout) == set(channels)), None)
    if names is None:
        raise InputError(
            f"{name}: an OpenEXR with the channels {', '.join(sorted(channels))}; save R, G and B, or Y"
        )
    if any(channel.type.v == _WHOLE or channel.xSampling != 1 for channel in channels.values()):
        raise InputError(
            f"{name}: an OpenEXR of whole numbers, or with small channels; save floats of one size"
        )
    return names


def encode(picture: Picture, form: Format, quality: int | None) -> bytes:
    """Encode a picture; see `poisson_cli.images.codecs`."""
    library = _library(picture.name, OutputError)
    pixels = picture.pixels
    colours = {"Y": pixels} if pixels.ndim == 2 else {c: pixels[..., k] for k, c in enumerate(_COLOURS)}
    if picture.alpha is not None:
        if (picture.alpha != 1).any():
            raise OutputError(f"{picture.name} is {_TRANSPARENT}")
        colours["A"] = picture.alpha
    channels = {channel: np.ascontiguousarray(plane) for channel, plane in colours.items()}
    file = BytesIO()
    header = {"compression": library.ZIP_COMPRESSION, "type": library.scanlineimage}
    with quiet():
        library.File(header, channels).write(file)
    return file.getvalue()
