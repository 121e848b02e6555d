"""A source that is transparent in places: only where it can be seen has it gradients to give."""

from __future__ import annotations

from typing import Literal

import numpy as np

from poisson_cli.errors import InputError
from poisson_cli.images import Picture
from poisson_cli.masks.growth import shrink
from poisson_cli.masks.selection import Selected

__all__ = ["leave_out_transparent"]


def leave_out_transparent(
    selected: Selected,
    source: Picture,
    threshold: int,
    offset: tuple[int, int],
    mask_on: Literal["source", "destination"],
) -> Selected:
    """Leave out of a selection where the source is transparent, and the pixels beside.

    The colours under transparent pixels mean nothing. A pixel that is edited takes part in the gradients to its four
    neighbours, so they must be opaque as well.

    Parameters
    ----------
    selected
        The selection.
    source
        The source; nothing changes unless it has an alpha channel.
    threshold
        8-bit opacity from which a pixel counts as opaque.
    offset, mask_on
        Where the source lies on the destination, and whose pixels the selection speaks of; see
        `poisson_cli.settings.Placement`.

    Returns
    -------
    Selected
        With a notice more if pixels were left out.

    Raises
    ------
    InputError
        If nothing is left.
    """
    if source.alpha is None:
        return selected
    opacity = source.in_8_bits().alpha
    assert opacity is not None
    transparent = ~shrink(opacity >= threshold, 1)
    mask = selected.mask.copy()
    row, col = offset if mask_on == "destination" else (0, 0)
    under = mask[
        max(row, 0) : max(row + transparent.shape[0], 0), max(col, 0) : max(col + transparent.shape[1], 0)
    ]
    top, left = max(-row, 0), max(-col, 0)
    under &= ~transparent[top : top + under.shape[0], left : left + under.shape[1]]
    left_out = np.count_nonzero(selected.mask) - np.count_nonzero(mask)
    if left_out == 0:
        return selected
    if not mask.any():
        raise InputError(
            f"the selection is empty: the source {source.name} is transparent, or next to it, wherever it is selected"
        )
    notice = (
        f"{left_out:,} selected pixels are left out: the source {source.name} is transparent there or beside"
    )
    return Selected(mask, (*selected.notices, notice))
