"""A picture in memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["Picture"]

_LAYOUTS: Final = {1: "grey", 2: "grey with alpha", 3: "RGB", 4: "RGB with alpha"}


@dataclass(frozen=True)
class Picture:
    """An 8-bit picture as it should be looked at: upright, palette applied.

    Parameters
    ----------
    name
        What the user calls it, for messages.
    pixels
        Grey (H, W) or RGB (H, W, 3), uint8, without alpha.
    alpha
        Opacity (H, W), uint8, 255 = opaque; None where the file has none.
    profile
        ICC profile that gives the pixels their meaning, None where the file has none.
    palette
        True if the file stored indices into a list of colours.
    """

    name: str
    pixels: NDArray[np.uint8]
    alpha: NDArray[np.uint8] | None = None
    profile: bytes | None = None
    palette: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W): rows and columns."""
        height, width = self.pixels.shape[:2]
        return height, width

    @property
    def size(self) -> str:
        """Width and height as people write them, ``640x480``."""
        height, width = self.shape
        return f"{width}x{height}"

    @property
    def channels(self) -> int:
        """Channels, alpha included: 1 to 4."""
        colours = 1 if self.pixels.ndim == 2 else 3
        return colours + (self.alpha is not None)

    @property
    def layout(self) -> str:
        """The channels in words."""
        return _LAYOUTS[self.channels]
