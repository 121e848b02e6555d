"""Concealment (Fig. 2): a picture mended with a piece of itself."""

import operator
from time import perf_counter
from typing import Any, Unpack

from numpy.typing import NDArray

from poisson_cli.editing import guidance, tone
from poisson_cli.editing.compose import compose
from poisson_cli.editing.placement import place
from poisson_cli.editing.report import Edit
from poisson_cli.editing.scene import Scene
from poisson_cli.editing.searching import best_offset
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.spaces import SpaceName, named
from poisson_cli.errors import InputError


def heal(
    image: NDArray[Any],
    mask: NDArray[Any],
    *,
    offset: tuple[int, int] | None = None,
    reach: int | None = None,
    screen: float = 0.0,
    robust: bool = False,
    rescale: bool = False,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """Concealment: the selection cloned over from elsewhere in the same picture (Fig. 2).

    Without an offset, the one is taken whose surroundings look most like the selection's own.  What is compared is a
    rim of 4 pixels around the selection: per channel the variance of the differences there, plus a quarter of their
    squared mean, which cloning evens out, but at the price of colours that bleed in; plus a quarter of the variance of
    the patch, so that nothing new is brought in.  The selection should leave a margin of a few pixels around what is
    to go, or what is compared is its blurred edge.  The patch and its rim lie inside the picture and do not touch the
    selection.  Of equally good offsets the nearest is taken.  Large pictures are searched at a reduced size, a million
    pixels, and the best places are then looked at pixel by pixel.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
    mask : (H, W) array
        True or non-zero = hide.
    offset : (row, column), optional
        Where to take the patch from: pixel p of the selection is mended with p + offset, which must lie inside the
        picture for every p.  Without it, the offset whose surroundings fit best is searched for; the report says which.
    reach : int, optional
        How many rows and columns away from the selection to search; the whole picture without.
    screen, robust, rescale, space, **options
        See `clone`.
    """
    image = tone.check_picture("image", image)
    here = place(image.shape, image.shape, mask)
    searching = {}
    if offset is not None:
        row, col = _checked(offset, here.rectangle, image.shape)
    else:
        start = perf_counter()
        row, col = best_offset(image, here, reach)
        searching = {"search": perf_counter() - start}
    placement = place(image.shape, image.shape, mask, offset=(-row, -col), mask_on="destination")
    edit = compose(
        "heal",
        Scene(image, placement, image),
        guidance.imported,
        named(space, image.dtype),
        screen=screen,
        robust=robust,
        rescale=rescale,
        **options,
    )
    return edit.reporting(searching, offset=(row, col))


def _checked(
    offset: tuple[int, int], rectangle: tuple[int, int, int, int], shape: tuple[int, ...]
) -> tuple[int, int]:
    """The offset as whole numbers; InputError if the patch would not lie inside the picture."""
    try:
        row, col = (operator.index(n) for n in offset)
    except (TypeError, ValueError):
        raise InputError(f"offset is {offset!r}, but must be two whole numbers: (row, column)") from None
    top, left, height, width = rectangle
    if not (0 <= top + row <= shape[0] - height and 0 <= left + col <= shape[1] - width):
        raise InputError(
            f"a patch {width}x{height} at {left + col},{top + row} leaves the picture, which is "
            f"{shape[1]}x{shape[0]}: take it from elsewhere"
        )
    return row, col
