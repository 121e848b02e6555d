"""A process of its own that reads an OpenEXR: stdin to stdout.

The library ends the process for some damaged headers, and writes to stdout and stderr what it thinks of others. Run by
its path, without the rest of this package: ``exr_reader.py LARGEST``, where LARGEST is the greatest number of pixels.
Answers with a line of JSON, in which ``refused`` or ``damaged`` says why there is no picture, or ``width``, ``height``
and ``channels`` what follows: the channels one after the other, float32 in the order of this machine. ``in_part`` tells
whether these pixels are others than those that the picture is said to have.
"""

from __future__ import annotations

import json
import os
import sys
from io import BytesIO
from typing import Any

LAYOUTS = (("R", "G", "B", "A"), ("R", "G", "B"), ("Y", "A"), ("Y",))
WHOLE = 0
"""The library's number for channels of whole numbers."""


def answer(data: bytes, largest: int) -> tuple[dict[str, Any], list[bytes]]:
    """What to say of a file, and its channels."""
    import Imath
    import OpenEXR

    # The newer interface of the library, `File`, says no more of a damaged file than that it has no parts.
    file = OpenEXR.InputFile(BytesIO(data))
    header = file.header()
    window, channels = header["dataWindow"], header["channels"]
    width, height = window.max.x - window.min.x + 1, window.max.y - window.min.y + 1
    corners = [(w.min.x, w.min.y, w.max.x, w.max.y) for w in (window, header["displayWindow"])]
    said = {"width": width, "height": height, "in_part": corners[0] != corners[1]}
    if width < 1 or height < 1 or width * height > largest:
        return said, []
    if not str(header.get("type", "scanlineimage")).strip("b'").startswith(("scanline", "tiled")):
        return {"refused": "a deep OpenEXR; flatten it first"}, []
    names = next((layout for layout in LAYOUTS if set(layout) == set(channels)), None)
    if names is None:
        return {
            "refused": f"an OpenEXR with the channels {', '.join(sorted(channels))}; save R, G and B, or Y"
        }, []
    if any(channel.type.v == WHOLE or channel.xSampling != 1 for channel in channels.values()):
        return {"refused": "an OpenEXR of whole numbers, or with small channels; save floats of one size"}, []
    floats = Imath.PixelType(Imath.PixelType.FLOAT)
    return {**said, "channels": names}, [file.channel(name, floats) for name in names]


def main() -> None:
    """Read, answer, and be quiet otherwise."""
    out = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for number in (1, 2):
        os.dup2(nowhere, number)
    planes: list[bytes] = []
    try:
        said, planes = answer(sys.stdin.buffer.read(), int(sys.argv[1]))
    except Exception as error:
        said = {"damaged": " ".join(str(error).split()) or type(error).__name__}
    out.write(json.dumps(said).encode() + b"\n")
    for plane in planes:
        out.write(plane)
    out.close()
    os._exit(0)  # nor must the library end it when it is taken apart


if __name__ == "__main__":
    main()
