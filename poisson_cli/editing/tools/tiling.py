"""Seamless tiling (Fig. 12)."""

import operator
from typing import Any, Literal, Unpack, get_args

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import guidance, tone
from poisson_cli.editing.compose import compose
from poisson_cli.editing.placement import place
from poisson_cli.editing.report import Edit
from poisson_cli.editing.scene import Scene
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.spaces import Space, SpaceName, named
from poisson_cli.errors import InputError

Axis = Literal["both", "x", "y"]


def tile(
    image: NDArray[Any],
    *,
    rect: tuple[int, int, int, int] | None = None,
    axis: Axis = "both",
    rescale: bool = False,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """A rectangle of a picture made tileable: opposite sides become equal, the gradients stay (Fig. 12).

    f* on the sides is the mean of the picture on both of them, taken in `space` and then stored (integers: rounded half
    to even); at the corners the mean of all four.  The interior is solved with the picture's own gradients.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
    rect : (row, column, height, width), optional
        The rectangle; the whole picture without.  It must lie inside the picture, and be at least 3 pixels long along
        each axis that is made to repeat.
    axis : {"both", "x", "y"}
        "x": repeats from left to right only.  Left and right sides become equal, corners included; the upper and lower
        sides are unknown and have the natural condition, as if the picture ended there.
    rescale, space, **options
        See `clone`.

    Returns
    -------
    Edit
        The image has the rectangle's size, ``(height, width[, C])``.
    """
    image = tone.check_picture("image", image)
    if axis not in get_args(Axis):
        raise InputError(f"axis is {axis!r}, but must be 'both', 'x' or 'y'")
    material = _inside(image, rect)
    height, width = material.shape[:2]
    for repeats, length in ((axis != "x", height), (axis != "y", width)):
        if repeats and length < 3:
            raise InputError(
                f"the rectangle is {width}x{height}, but must be at least 3 pixels long where it is to repeat"
            )
    domain = named(space, image.dtype)
    interior = np.ones((height, width), np.bool_)
    if axis != "x":
        interior[[0, -1]] = False
    if axis != "y":
        interior[:, [0, -1]] = False
    scene = Scene(
        _with_equal_sides(material, axis, domain),
        place(material.shape, material.shape, interior),
        material,
    )
    return compose("tile", scene, guidance.imported, domain, rescale=rescale, **options)


def _inside(image: NDArray[Any], rect: tuple[int, int, int, int] | None) -> NDArray[Any]:
    """The rectangle of the picture."""
    if rect is None:
        return image
    try:
        row, col, height, width = (operator.index(n) for n in rect)
    except (TypeError, ValueError):
        raise InputError(
            f"rect is {rect!r}, but must be four whole numbers: (row, column, height, width)"
        ) from None
    size = f"{image.shape[1]}x{image.shape[0]}"
    if height < 1 or width < 1:
        raise InputError(f"the rectangle is {width}x{height}: give one that has pixels")
    if row < 0 or col < 0 or row + height > image.shape[0] or col + width > image.shape[1]:
        raise InputError(
            f"the rectangle {width}x{height} at {col},{row} does not lie inside the picture, which is {size}"
        )
    return image[row : row + height, col : col + width]


def _with_equal_sides(material: NDArray[Any], axis: Axis, space: Space) -> NDArray[Any]:
    """A copy of which opposite sides are their mean."""
    tone.check_values("image", material)
    channels = 1 if material.ndim == 2 else material.shape[2]
    space.check("image", channels)
    picture = material.copy()
    pixels = picture.reshape(*picture.shape[:2], channels)
    first, middle, last = (slice(0, 1), slice(1, -1), slice(-1, None))
    groups: list[list[tuple[slice, slice]]] = []
    if axis != "y":
        rows = middle if axis == "both" else slice(None)
        groups.append([(rows, first), (rows, last)])
    if axis != "x":
        cols = middle if axis == "both" else slice(None)
        groups.append([(first, cols), (last, cols)])
    if axis == "both":
        groups.append([(row, col) for row in (first, last) for col in (first, last)])
    for group in groups:
        stored = [pixels[part].astype(tone.working_dtype(picture.dtype)) for part in group]
        working = [space.to_working(part.copy()) for part in stored]
        mean: Any = sum(working) / len(working)
        equal = tone.to_storage(space.to_stored(mean, working[0], stored[0]), picture.dtype)
        for part in group:
            pixels[part] = equal
    return picture
