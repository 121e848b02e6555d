"""Seamless tiling (Fig. 12)."""

from typing import Any, Literal, Unpack

from numpy.typing import NDArray

from poisson_cli.editing.report import Edit
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.spaces import SpaceName

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
    raise NotImplementedError
