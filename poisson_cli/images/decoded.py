"""What a decoder hands over."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from poisson_cli.images.metadata import Metadata

__all__ = ["Decoded"]


class Decoded(NamedTuple):
    """A picture as it is stored, lying on its side if the camera did.

    Parameters
    ----------
    pixels
        (H, W) or (H, W, C); uint8, uint16 or float32, alpha last.
    alpha
        Whether the last channel is one.
    orientation
        See `poisson_cli.images.orientation`.
    palette
        Whether the file stores indices into a list of colours.
    metadata
        As the file has it.
    """

    pixels: NDArray[Any]
    alpha: bool = False
    orientation: int = 1
    palette: bool = False
    metadata: Metadata = Metadata()
