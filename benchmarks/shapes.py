"""Region shapes: pure functions of the frame's side, True = unknown, the same every time.

Each returns (side, side) bool.  In `spiral`, `pins` and `cracks` the known pixels are thin beside the unknown ones,
so that a coarse grid can lose them; the last three know one pixel, one corner, nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
Shape = Callable[[int], Array]

MARGIN = 2  # known pixels left around every shape that does not mean to touch the frame


def disk(side: int) -> Array:
    return _radius(side) < side / 2 - MARGIN


def disk_of(unknowns: int) -> Array:
    """A disk of about that many pixels, in the smallest frame that holds it."""
    radius = np.sqrt(unknowns / np.pi)
    return _radius(2 * int(np.ceil(radius)) + 2 * MARGIN) < radius


def lasso(side: int) -> Array:
    """A loose outline as drawn by hand: a disk with bulges and bays."""
    y, x = _centred(side)
    angle = np.arctan2(y, x)
    outline = 1 + 0.22 * np.sin(3 * angle + 0.7) + 0.1 * np.sin(7 * angle) + 0.05 * np.sin(13 * angle + 2)
    return np.hypot(y, x) < outline * (side / 2 - MARGIN) / 1.37


def ring(side: int) -> Array:
    radius = _radius(side) / (side / 2 - MARGIN)
    return (radius < 1) & (radius > 0.4)


def strokes(side: int) -> Array:
    """Curves one to three pixels wide, as one mends scratches and wires."""
    region = np.zeros((side, side), bool)
    rng = np.random.default_rng(3)
    for width in np.resize([1, 2, 3], max(side // 8, 3)):
        heading, bend = rng.uniform(0, 2 * np.pi), rng.normal(0, 2 / side)
        steps = np.arange(int(rng.uniform(0.3, 0.8) * side))
        course = heading + bend * steps
        row, col = (
            (start + np.cumsum(step)).astype(int)
            for start, step in zip(rng.uniform(0, side, 2), (np.sin(course), np.cos(course)), strict=True)
        )
        for i in range(width):
            for j in range(width):
                r, c = row + i, col + j
                inside = (np.minimum(r, c) >= MARGIN) & (np.maximum(r, c) < side - MARGIN)
                region[r[inside], c[inside]] = True
    return region


def islands(side: int) -> Array:
    """Specks of two to six pixels across, scattered: dust on a scan."""
    region = np.zeros((side, side), bool)
    rng = np.random.default_rng(4)
    for _ in range(max(side * side // 400, 4)):
        radius = rng.integers(1, 4)
        r, c = rng.integers(MARGIN + radius, side - MARGIN - radius, 2)
        y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1]
        region[r - radius : r + radius + 1, c - radius : c + radius + 1] |= y * y + x * x <= radius * radius
    return region


def singles(side: int) -> Array:
    """Single pixels, no two of them neighbours: one in every four by four, hot pixels of a sensor."""
    region = np.zeros((side, side), bool)
    rng = np.random.default_rng(5)
    corner = np.arange(MARGIN, side - MARGIN - 2, 4)
    row, col = np.meshgrid(corner, corner, indexing="ij")
    region[row + rng.integers(0, 3, row.shape), col + rng.integers(0, 3, col.shape)] = True
    return region


def noise(side: int) -> Array:
    """Every second pixel, by the throw of a coin."""
    return _framed(np.random.default_rng(6).random((side, side)) < 0.5)


def checkerboard(side: int) -> Array:
    return _framed(np.add.outer(np.arange(side), np.arange(side)) % 2 == 0)


def spiral(side: int) -> Array:
    """One long corridor, fifteen pixels wide, between walls of one known pixel or two."""
    y, x = _centred(side)
    turns = np.hypot(y, x) / 16 - np.arctan2(y, x) / (2 * np.pi)
    return (turns % 1 > 0.08) & disk(side)


def pins(side: int) -> Array:
    """A square in which one pixel of a thousand is known."""
    return _framed(np.random.default_rng(7).random((side, side)) > 0.001)


def cracks(side: int) -> Array:
    """A square crossed by a few known lines, one pixel wide and nearly along the grid, that end inside it."""
    region = _framed(np.ones((side, side), bool))
    rng = np.random.default_rng(8)
    for _ in range(8):
        start, slope = rng.uniform(0.1, 0.9) * side, rng.uniform(-0.02, 0.02)
        along = np.arange(int(rng.uniform(0, 0.4) * side), int(rng.uniform(0.6, 1) * side))
        across = np.clip((start + slope * (along - side / 2)).astype(int), 0, side - 1)
        if rng.random() < 0.5:
            region[across, along] = False
        else:
            region[along, across] = False
    return region


def all_but_one(side: int) -> Array:
    """The whole frame but one pixel near its middle."""
    region = np.ones((side, side), bool)
    region[side // 2 - 11, side // 2 + 7] = False
    return region


def one_corner(side: int) -> Array:
    """The whole frame but the pixel in its corner."""
    region = np.ones((side, side), bool)
    region[0, 0] = False
    return region


def everything(side: int) -> Array:
    """No known pixel at all: the solution is known up to a constant."""
    return np.ones((side, side), bool)


ROUND: dict[str, Shape] = {"disk": disk, "lasso": lasso, "ring": ring}
THIN: dict[str, Shape] = {
    "strokes": strokes,
    "islands": islands,
    "single pixels": singles,
    "noise": noise,
    "checkerboard": checkerboard,
}
PIERCED: dict[str, Shape] = {"spiral": spiral, "pins": pins, "cracks": cracks}
NEAR_SINGULAR: dict[str, Shape] = {
    "all but one pixel": all_but_one,
    "one known corner": one_corner,
    "all": everything,
}
INTERIOR = ROUND | THIN | PIERCED
EVERY = INTERIOR | NEAR_SINGULAR


def with_unknowns(shape: Shape, unknowns: int) -> Array:
    """The shape in a frame that makes it about that many pixels large."""
    side = int(np.sqrt(2 * unknowns))
    for _ in range(6):
        region = shape(side)
        ratio = unknowns / max(int(region.sum()), 1)
        if abs(ratio - 1) < 0.02:
            break
        side = max(round(side * np.sqrt(ratio)), 16)
    return region


def _centred(side: int) -> tuple[Array, Array]:
    at = np.arange(side) - (side - 1) / 2
    return at[:, None], at[None, :]


def _radius(side: int) -> Array:
    y, x = _centred(side)
    return np.hypot(y, x)


def _framed(region: Array) -> Array:
    out = np.zeros_like(region)
    out[MARGIN:-MARGIN, MARGIN:-MARGIN] = region[MARGIN:-MARGIN, MARGIN:-MARGIN]
    return out
