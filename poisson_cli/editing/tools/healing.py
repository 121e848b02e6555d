"""Concealment (Fig. 2): a picture mended with a piece of itself."""

from typing import Any, Unpack

from numpy.typing import NDArray

from poisson_cli.editing.report import Edit
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.spaces import SpaceName


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
    raise NotImplementedError
