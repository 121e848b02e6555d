"""A picture in memory."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from numpy.typing import NDArray

from poisson_cli.images.depth import Conversion, Depth, convert, depth_of, full_scale
from poisson_cli.images.metadata import Metadata

__all__ = ["Picture"]

_LAYOUTS: Final = {1: "grey", 2: "grey with alpha", 3: "RGB", 4: "RGB with alpha"}


class Picture(NamedTuple):
    """A picture as it should be looked at: upright, palette applied.

    Parameters
    ----------
    name
        What the user calls it, for messages.
    pixels
        Grey (H, W) or RGB (H, W, 3), without alpha; uint8, uint16 or float32, full scale 255, 65535 or 1.
    alpha
        Opacity (H, W), not premultiplied, in the depth of the pixels, full scale = opaque; None where the file has
        none.
    palette
        True if the file stored indices into a list of colours.
    metadata
        What else the file holds.
    """

    name: str
    pixels: NDArray[Any]
    alpha: NDArray[Any] | None = None
    palette: bool = False
    metadata: Metadata = Metadata()

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
    def opaque(self) -> bool:
        """Whether no pixel is transparent, not even a little."""
        return self.alpha is None or bool((self.alpha >= full_scale(self.depth)).all())

    @property
    def layout(self) -> str:
        """The channels in words."""
        return _LAYOUTS[self.channels]

    @property
    def depth(self) -> Depth:
        """The depth of pixels and alpha."""
        return depth_of(self.pixels)

    def converted(self, depth: Depth) -> tuple[Picture, Conversion]:
        """The picture in another depth, and what its pixels lost on the way."""
        pixels = convert(self.pixels, depth)
        alpha = None if self.alpha is None else convert(self.alpha, depth).values
        return self._replace(pixels=pixels.values, alpha=alpha), pixels

    def in_8_bits(self) -> Picture:
        """The picture as a mask is read, in levels from 0 to 255."""
        return self.converted("8")[0]
