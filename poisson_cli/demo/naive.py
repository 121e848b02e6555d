"""What one would do without gradients: paste, blend, blur, brighten. Each result of the gallery stands beside one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from poisson_cli.demo.command import Command
from poisson_cli.demo.paste import plain_paste

__all__ = [
    "Blurred",
    "Brightened",
    "Contrasted",
    "Grey",
    "Hue",
    "Median",
    "Naive",
    "Pasted",
    "Repeated",
]

Pixels = NDArray[np.uint8]
Change = Callable[[Pixels], Pixels]
"""Something done to a whole picture: (H, W) or (H, W, 3) uint8 in, the same out."""


class Naive(Protocol):
    """A naive way to do what a command does."""

    def draw(
        self, command: Command, read: Callable[[str], Pixels], masks: Mapping[str, NDArray[np.bool_]]
    ) -> Pixels:
        """Do it.

        Parameters
        ----------
        command
            The command to compete with.
        read
            Reads one of the scene's pictures.
        masks
            The scene's selections; (H, W) bool, True = selected.
        """
        ...


@dataclass(frozen=True)
class Pasted:
    """Paste the selection of the (changed) source onto the destination; of one picture, onto itself.

    Parameters
    ----------
    change
        What to do to the whole source first; None for nothing.
    backdrop
        What to do to the whole destination first; None for nothing.
    feather
        Standard deviation in pixels of the blur that softens the outline of the selection: alpha blending. 0 = hard.
    at
        X, Y of the source's top-left corner; None for what the command says.
    """

    change: Change | None = None
    backdrop: Change | None = None
    feather: float = 0
    at: tuple[int, int] | None = None

    def draw(
        self, command: Command, read: Callable[[str], Pixels], masks: Mapping[str, NDArray[np.bool_]]
    ) -> Pixels:
        """Paste."""
        source, destination = read(command.pictures[0]), read(command.pictures[-1])
        if self.change is not None:
            source = self.change(source)
        if self.backdrop is not None:
            destination = self.backdrop(destination)
        name = command.option("-m", "")
        one = len(command.pictures) == 1  # its selection stays where it is, whatever is put there
        x, y = map(int, command.option("--at", "0,0").split(",")) if self.at is None else self.at
        return plain_paste(
            destination,
            source,
            masks[name] if name else np.ones(source.shape[:2], np.bool_),
            offset=(y, x),
            mask_on="destination" if one or command.option("--mask-on", "") == "destination" else "source",
            feather=self.feather,
        )


@dataclass(frozen=True)
class Repeated:
    """Cut the command's rectangle out and repeat it three times three."""

    def draw(
        self, command: Command, read: Callable[[str], Pixels], masks: Mapping[str, NDArray[np.bool_]]
    ) -> Pixels:
        """Repeat."""
        del masks  # a rectangle is all there is to select
        pixels = read(command.pictures[0])
        x, y, width, height = map(int, command.option("--rect", "").split(","))
        piece = pixels[y : y + height, x : x + width]
        return np.tile(piece, (3, 3, 1)[: piece.ndim])


@dataclass(frozen=True)
class Blurred:
    """A Gaussian blur of so many pixels."""

    sigma: float

    def __call__(self, pixels: Pixels) -> Pixels:
        """Blur."""
        return np.asarray(Image.fromarray(pixels).filter(ImageFilter.GaussianBlur(self.sigma)))


@dataclass(frozen=True)
class Median:
    """The median of a square of so many pixels, an odd number."""

    width: int

    def __call__(self, pixels: Pixels) -> Pixels:
        """Take the median."""
        return np.asarray(Image.fromarray(pixels).filter(ImageFilter.MedianFilter(self.width)))


@dataclass(frozen=True)
class Brightened:
    """A gamma curve: below 1 brighter, above 1 darker."""

    exponent: float

    def __call__(self, pixels: Pixels) -> Pixels:
        """Apply the curve."""
        return np.rint(255 * (pixels / 255) ** self.exponent).astype(np.uint8)


@dataclass(frozen=True)
class Contrasted:
    """Values stretched by a factor about the mean colour of the picture."""

    factor: float

    def __call__(self, pixels: Pixels) -> Pixels:
        """Stretch."""
        mean: NDArray[np.float64] = pixels.mean(axis=(0, 1))
        values: NDArray[np.float64] = mean + self.factor * (pixels - mean)
        return np.clip(np.rint(values), 0, 255).astype(np.uint8)


@dataclass(frozen=True)
class Hue:
    """Colours turned round the circle of HSV by so many degrees."""

    degrees: float

    def __call__(self, pixels: Pixels) -> Pixels:
        """Turn."""
        hsv = np.array(Image.fromarray(pixels).convert("HSV"))
        hsv[..., 0] = (hsv[..., 0].astype(np.int64) + round(self.degrees * 256 / 360)) % 256
        turned = Image.frombytes("HSV", (hsv.shape[1], hsv.shape[0]), hsv.tobytes())
        return np.asarray(turned.convert("RGB"))


@dataclass(frozen=True)
class Grey:
    """All colour taken away."""

    def __call__(self, pixels: Pixels) -> Pixels:
        """Take it away."""
        return np.asarray(Image.fromarray(pixels).convert("L").convert("RGB"))
