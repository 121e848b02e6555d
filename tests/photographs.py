"""Photographs to test on: files inside scikit-image's wheel, read by path, so that no network is needed.

Every picture is (H, W, 3) or (H, W) uint8 and read-only: a tool that wrote into its arguments would raise.
"""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

import imageio.v3 as imageio
import numpy as np

COLOUR = ("astronaut.png", "chelsea.png", "coffee.png", "rocket.jpg")
GREY = ("camera.png", "coins.png", "moon.png")


@cache
def photograph(name: str) -> np.ndarray:
    """One of the wheel's pictures, by file name."""
    spec = find_spec("skimage")
    assert spec is not None and spec.origin is not None, "the tests need scikit-image: pip install '.[test]'"
    picture = imageio.imread(Path(spec.origin).parent / "data" / name, plugin="pillow")
    picture.flags.writeable = False
    return picture


def crop(name: str, height: int, width: int, *, top: int = 60, left: int = 90) -> np.ndarray:
    """A piece of a photograph, (height, width[, 3]) uint8; faces and edges lie about the default corner."""
    piece = photograph(name)[top : top + height, left : left + width]
    assert piece.shape[:2] == (height, width)
    return piece
