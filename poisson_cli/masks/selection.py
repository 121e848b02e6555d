"""From what the user asked for to one mask on one picture's grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.images import Picture, read
from poisson_cli.masks.raster import strength
from poisson_cli.masks.shapes import draw_rectangle
from poisson_cli.settings import Selection

__all__ = ["Canvas", "select"]


@dataclass(frozen=True)
class Canvas:
    """The picture that a selection is drawn on.

    Parameters
    ----------
    role
        What it is to the user: ``source``, ``destination`` or ``image``.
    picture
        The picture.
    other
        The picture that a mask may have been drawn on instead, with its role; None if there is no other.
    """

    role: str
    picture: Picture
    other: tuple[str, Picture] | None = None


def select(selection: Selection, canvas: Canvas) -> NDArray[np.bool_]:
    """Draw a selection.

    Parameters
    ----------
    selection
        Masks and rectangles: their union, inverted if asked.
    canvas
        What it is drawn on; every mask must have its size.

    Returns
    -------
    ndarray
        (H, W) bool of the canvas, True = selected; never all False.

    Raises
    ------
    InputError
        If a mask cannot be read or has another size, or nothing is selected.
    """
    strongest = 0
    mask = np.zeros(canvas.picture.shape, np.bool_)
    for path in selection.masks:
        picture = read(path).in_8_bits()
        _refuse_other_size(picture, canvas)
        values = strength(picture)
        strongest = max(strongest, int(values.max()))
        mask |= values >= selection.threshold
    for rectangle in selection.rectangles:
        draw_rectangle(mask, rectangle)
    if selection.invert:
        np.logical_not(mask, out=mask)
    if not mask.any():
        raise InputError(f"the selection is empty: {_why_empty(selection, canvas, strongest)}")
    return mask


def _refuse_other_size(mask: Picture, canvas: Canvas) -> None:
    """Name both sizes and the way out."""
    if mask.shape == canvas.picture.shape:
        return
    problem = f"mask {mask.name} is {mask.size}, but the {canvas.role} {canvas.picture.name} is {canvas.picture.size}"
    if canvas.other is None:
        raise InputError(f"{problem}; a mask must have the size of the {canvas.role}")
    role, other = canvas.other
    if mask.shape == other.shape:
        raise InputError(
            f"{problem}; it has the size of the {role}: if it was drawn there, add --mask-on {role}"
        )
    raise InputError(
        f"{problem}; give it the size of the {canvas.role}, "
        f"or that of the {role} ({other.size}) and add --mask-on {role}"
    )


def _why_empty(selection: Selection, canvas: Canvas, strongest: int) -> str:
    """Say why nothing is selected, and what would help."""
    if selection.invert:
        return "everything was selected, so --invert-mask leaves nothing"
    reasons = []
    if 0 < strongest < selection.threshold:
        reasons.append(
            f"the brightest pixel of a mask is {strongest}, below the threshold of {selection.threshold} "
            f"(lower it: --mask-threshold {strongest})"
        )
    elif selection.masks:
        reasons.append("no pixel of a mask is set (white selects; --invert-mask turns it round)")
    if selection.rectangles:
        reasons.append(f"no --rect meets the {canvas.role}, which is {canvas.picture.size}")
    return "; ".join(reasons)
