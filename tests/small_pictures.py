"""Small pictures that every test of the command line and of picture files can share.

destination.png  48 x 40 RGB     source.png  30 x 24 RGB     mask.png      30 x 24, on the source
grey.png         48 x 40 grey                                dest-mask.png 48 x 40, on the destination
alpha.png        48 x 40 RGB with alpha
"""

import io
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

RNG = np.random.default_rng(20031)


def smooth(height: int, width: int, channels: int) -> np.ndarray:
    """Something like a photograph: slow waves and a little noise, uint8."""
    y, x = np.mgrid[:height, :width]
    waves = [np.sin(x / (7 + c) + c) * np.cos(y / (9 - c)) for c in range(channels)]
    noise = RNG.normal(0, 4, (height, width, channels))
    return np.clip(128 + 70 * np.stack(waves, axis=2) + noise, 0, 255).astype(np.uint8)


def blob(height: int, width: int) -> np.ndarray:
    """A bool mask that touches no edge."""
    y, x = np.mgrid[:height, :width]
    return ((y - height / 2) / (height / 3)) ** 2 + ((x - width / 2) / (width / 3)) ** 2 < 1


DESTINATION = smooth(40, 48, 3)
SOURCE = smooth(24, 30, 3)
GREY = smooth(40, 48, 1)[:, :, 0]
ALPHA = np.dstack((DESTINATION, RNG.integers(0, 256, DESTINATION.shape[:2], np.uint8)))
MASK = blob(24, 30)
DESTINATION_MASK = blob(40, 48)

PICTURES = {
    "destination.png": DESTINATION,
    "source.png": SOURCE,
    "grey.png": GREY,
    "alpha.png": ALPHA,
    "mask.png": MASK.astype(np.uint8) * 255,
    "dest-mask.png": DESTINATION_MASK.astype(np.uint8) * 255,
}


def encoded(pixels: np.ndarray, form: str = "PNG", **settings: Any) -> bytes:
    """A picture file, made without our code."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, form, **settings)
    return file.getvalue()


def save_all(folder: Path) -> None:
    for name, pixels in PICTURES.items():
        (folder / name).write_bytes(encoded(pixels))


def load(path: Path | str) -> np.ndarray:
    """Pixels of a file, read without our code."""
    with Image.open(path) as image:
        return np.asarray(image)
