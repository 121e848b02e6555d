"""From what the user asked for to one mask on one picture's grid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.masks.canvas import Canvas
from poisson_cli.masks.growth import grow, shrink
from poisson_cli.masks.raster import NEAR
from poisson_cli.masks.shapes import draw_ellipse, draw_polygon, draw_rectangle
from poisson_cli.masks.source import Drawn, read_mask
from poisson_cli.settings import Area, Combine, Ellipse, Grow, MaskFile, Polygon, Rectangle, Selection

__all__ = ["Selected", "select"]


class Selected(NamedTuple):
    """A selection that was drawn.

    Parameters
    ----------
    mask
        (H, W) bool of the canvas, True = selected; never all False.
    notices
        What the user should know about how it was made, a line each.
    """

    mask: NDArray[np.bool_]
    notices: tuple[str, ...] = ()


def select(selection: Selection, canvas: Canvas) -> Selected:
    """Draw a selection.

    Parameters
    ----------
    selection
        What to do, step by step.
    canvas
        What it is drawn on; a mask that has a size must have this one's.

    Raises
    ------
    InputError
        If a mask cannot be read or has another size, or nothing is selected.
    """
    mask = np.zeros(canvas.shape, np.bool_)
    notices = []
    reasons = []  # why nothing is selected, should it come to that
    for step in selection.steps:
        before = mask.any()
        if isinstance(step, Grow):
            mask = grow(mask, step.pixels) if step.pixels >= 0 else shrink(mask, -step.pixels)
            if before and not mask.any():
                reasons = [f"--shrink {-step.pixels} leaves nothing"]
            continue
        drawn = _draw(step.area, canvas, selection.threshold)
        if drawn.near:
            assert isinstance(step.area, MaskFile)
            notices.append(_of_grey_edges(step.area, drawn.near, selection.threshold))
        mask = _combined(mask, step, drawn)
        if not mask.any():
            if before:
                reasons = [f"--{step.how} leaves nothing"]
            elif (
                step.how == "add"
                and (reason := _of_empty_area(step.area, drawn, selection, canvas)) not in reasons
            ):
                reasons.append(reason)
    if selection.invert:
        mask = ~mask
        reasons = ["everything was selected, so --invert-mask leaves nothing"]
    if not mask.any():
        raise InputError(f"the selection is empty: {'; '.join(reasons) or 'nothing was added to it'}")
    return Selected(mask, tuple(notices))


def _combined(mask: NDArray[np.bool_], step: Combine, drawn: Drawn) -> NDArray[np.bool_]:
    match step.how:
        case "add":
            return mask | drawn.mask
        case "subtract":
            return mask & ~drawn.mask
        case "intersect":
            return mask & drawn.mask


def _draw(area: Area, canvas: Canvas, threshold: int) -> Drawn:
    match area:
        case MaskFile():
            return read_mask(area, canvas, threshold)
        case Rectangle():
            return Drawn(draw_rectangle(area, canvas.shape))
        case Ellipse():
            return Drawn(draw_ellipse(area, canvas.shape))
        case Polygon():
            return Drawn(draw_polygon(area, canvas.shape))


def _of_grey_edges(file: MaskFile, near: int, threshold: int) -> str:
    return (
        f"mask {file.name} has grey edges: it is cut at {threshold}, and {near:,} of its pixels are less than {NEAR} "
        "levels from there (--mask-threshold moves the cut)"
    )


def _of_empty_area(area: Area, drawn: Drawn, selection: Selection, canvas: Canvas) -> str:
    """Why an area selects nothing, and what would help."""
    match area:
        case MaskFile():
            return _of_empty_file(area, drawn, selection.threshold, canvas)
        case Rectangle():
            option = "--rect"
        case Ellipse():
            option = "--ellipse"
        case Polygon():
            option = "--polygon" if area.rule == "even-odd" else "--lasso"
    return f"no {option} meets the {canvas.role}, which is {canvas.picture.size}"


def _of_empty_file(file: MaskFile, drawn: Drawn, threshold: int, canvas: Canvas) -> str:
    if drawn.strongest is None:
        return f"{file.name} selects no pixel of the {canvas.role}, which is {canvas.picture.size}"
    if 0 < drawn.strongest < threshold:
        return (
            f"the brightest pixel of a mask is {drawn.strongest}, below the threshold of {threshold} "
            f"(lower it: --mask-threshold {drawn.strongest}; or choose from a map of labels: :index={drawn.strongest})"
        )
    if file.name.rpartition(":index=")[2].isdecimal():
        return f"no pixel is {file.name}"
    return "no pixel of a mask is set (white selects; --invert-mask turns it round)"
