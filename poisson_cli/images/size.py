"""How large a picture is, without reading it: for whoever plans."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from PIL import Image

from poisson_cli.errors import InputError
from poisson_cli.images.formats import FORMATS, PNG
from poisson_cli.images.header import decoding

__all__ = ["peek"]


def peek(path: Path) -> tuple[int, int] | None:
    """The size that a picture file claims.

    Parameters
    ----------
    path
        Any path; a pipe is left alone, since what is read from it is gone.

    Returns
    -------
    tuple of int or None
        (H, W) in pixels, as they are stored; None if that cannot be told, for whatever reason: who reads the picture
        will say which.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            return None
        with (
            decoding(str(path), PNG),
            Image.open(path, formats=[form.pillow for form in FORMATS if form.pillow]) as image,
        ):
            return image.height, image.width
    except (OSError, ValueError, InputError):
        return None
