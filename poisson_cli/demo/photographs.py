"""The photographs in scikit-image's wheel, made ready for a scene.

The files are read by path: scikit-image itself, which takes a second to import and would fetch further pictures from
the network, is never imported.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from poisson_cli.demo.shapes import Brush
from poisson_cli.errors import InputError
from poisson_cli.images import read

__all__ = ["CREDITS", "Coat", "Photograph", "folder", "load"]

CREDITS: Final = {
    "astronaut.png": "Eileen Collins: NASA, public domain",
    "brick.png": "Brick wall: CC0Textures, CC0",
    "camera.png": "Photographer in a park: Lav Varshney, CC0",
    "chelsea.png": "Chelsea the cat: Stéfan van der Walt, CC0",
    "coffee.png": "Coffee cup at Pikolo Espresso Bar: Rachel Michetti, CC0",
    "coins.png": "Greek coins from Pompeii: Brooklyn Museum, no known copyright restrictions",
    "hubble_deep_field.jpg": "Hubble eXtreme Deep Field: NASA, free use",
    "logo.png": "The scikit-image logo: the scikit-image team",
    "motorcycle_left.png": "Motorcycle: D. Scharstein and others, Middlebury Stereo Datasets 2014",
    "rocket.jpg": "Falcon 9 with DSCOVR: SpaceX, public domain",
}
"""Who to thank for each file, as scikit-image's documentation says it."""

_CREASE: Final = (243, 238, 226)
"""RGB of the paper where the picture has come off."""


@dataclass(frozen=True)
class Coat:
    """Thin paint over a whole picture.

    Parameters
    ----------
    colour
        RGB, 0..255.
    opacity
        0 = nothing, 1 = only paint is seen.
    """

    colour: tuple[int, int, int]
    opacity: float


@dataclass(frozen=True)
class Photograph:
    """One picture of a scene: a file of the wheel and what is done to it first, in this order.

    Parameters
    ----------
    file
        Name in the wheel.
    crop
        Piece to use: left, top, right, bottom in pixels, right and bottom excluded.
    size
        Width and height to scale to, in pixels.
    margin
        Width of a white margin to put around it, in pixels.
    quarter_turns
        Quarter turns, counterclockwise.
    mirrored
        Whether left and right change sides.
    levels
        The values that become black and white; those between follow in a straight line. Black above white makes a
        negative.
    coat
        Paint over it, which makes a grey photograph a coloured picture.
    creases
        Folds where the colour has come off an old print.
    """

    file: str
    crop: tuple[int, int, int, int] | None = None
    size: tuple[int, int] | None = None
    margin: int = 0
    quarter_turns: int = 0
    mirrored: bool = False
    levels: tuple[int, int] | None = None
    coat: Coat | None = None
    creases: tuple[Brush, ...] = ()


def folder() -> Path:
    """Find the folder of photographs in the installed scikit-image.

    Raises
    ------
    InputError
        If scikit-image is not installed.
    """
    spec = importlib.util.find_spec("skimage")
    if spec is None or not spec.submodule_search_locations:
        raise InputError(
            "the demo takes its photographs from scikit-image, which is not installed: "
            "pip install 'poisson-cli[demo]'"
        )
    return Path(spec.submodule_search_locations[0], "data")


def load(photograph: Photograph, files: Path) -> NDArray[np.uint8]:
    """Read a photograph and make it ready.

    Parameters
    ----------
    photograph
        Which one, and how.
    files
        The `folder`.

    Returns
    -------
    ndarray
        (H, W) or (H, W, 3) uint8.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    image = Image.fromarray(read(files / photograph.file).pixels)
    if photograph.crop is not None:
        image = image.crop(photograph.crop)
    if photograph.size is not None:
        image = image.resize(photograph.size, Image.Resampling.LANCZOS)
    pixels = np.asarray(image)
    if photograph.margin:
        edges = [(photograph.margin, photograph.margin)] * 2 + [(0, 0)] * (pixels.ndim - 2)
        pixels = np.pad(pixels, edges, constant_values=255)
    pixels = np.rot90(pixels, photograph.quarter_turns)
    if photograph.mirrored:
        pixels = pixels[:, ::-1]
    if photograph.levels is not None:
        pixels = _stretched(pixels, *photograph.levels)
    if photograph.coat is not None:
        pixels = _painted(pixels, photograph.coat)
    if photograph.creases:
        pixels = _creased(pixels, photograph.creases)
    return np.ascontiguousarray(pixels)


def _stretched(pixels: NDArray[np.uint8], black: int, white: int) -> NDArray[np.uint8]:
    """Spread the values from black to white over the whole range, and clip the others."""
    values = (pixels.astype(np.float64) - black) * (255 / (white - black))
    return np.clip(values.round(), 0, 255).astype(np.uint8)


def _painted(pixels: NDArray[np.uint8], coat: Coat) -> NDArray[np.uint8]:
    """Put a coat of paint over a picture; (H, W, 3)."""
    colours = pixels if pixels.ndim == 3 else pixels[..., None]
    paint = np.array(coat.colour, np.float64)
    return np.rint(colours + coat.opacity * (paint - colours)).astype(np.uint8)


def _creased(pixels: NDArray[np.uint8], creases: tuple[Brush, ...]) -> NDArray[np.uint8]:
    """Fold a picture; (H, W, 3)."""
    image = Image.fromarray(pixels).convert("RGB")
    canvas = ImageDraw.Draw(image)
    for crease in creases:
        crease.draw(canvas, _CREASE)
    return np.asarray(image)
