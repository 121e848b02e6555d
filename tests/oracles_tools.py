"""The truth for the tools that edit one picture: section 4 of the paper, its conclusion, and what it points to.

Written from the equations alone, on top of `oracles`; the conventions are the same.  A transform takes a guidance
field, a pair (across, down), and gives another.  Where the paper leaves a choice open, the docstring says what was
taken; the tool's own docstring says why.
"""

from typing import Any

import numpy as np

from tests import oracles
from tests.oracles import Array, Field, Transform

# --- transforms of a guidance field -----------------------------------------------------------------


def sieve(edges: Array) -> Transform:
    """Eq. (15): v_pq is kept where an edge lies between p and q: where one of the two is an edge pixel."""
    edge = np.asarray(edges) != 0

    def transform(field: Field) -> Field:
        across, down = (v.copy() for v in field)
        for row in range(edge.shape[0]):
            for col in range(edge.shape[1]):
                for v, (r, c) in ((across, (row, col + 1)), (down, (row + 1, col))):
                    if r < edge.shape[0] and c < edge.shape[1] and not (edge[row, col] or edge[r, c]):
                        v[row, col] = 0
        return across, down

    return transform


def scale(amount: float) -> Transform:
    """The conclusion's change of sharpness: every gradient times `amount`."""
    return lambda field: (amount * field[0], amount * field[1])


# --- section 4 --------------------------------------------------------------------------------------


def own(image: Array, mask: Array, **variant: Any) -> Array:
    """An edit by the picture's own gradients, transformed as `variant` (see `oracles.edit`) says."""
    return oracles.edit(oracles.imported, image, image, np.asarray(mask) != 0, **variant)


def flatten(image: Array, mask: Array, *, edges: Array, **variant: Any) -> Array:
    """Texture flattening, eqs. (14)-(15)."""
    return own(image, mask, then=[sieve(edges)], **variant)


def decolored(image: Array, mask: Array, *, source: Array | None = None, **variant: Any) -> Array:
    """Fig. 11, centre: f* is the luminance of the picture, g the picture, or `source` where it was recoloured too.

    Stored values, so a destination of integers is rounded before it is cloned into.
    """
    grey = oracles.grey(image)
    if np.issubdtype(image.dtype, np.integer):
        grey = np.rint(grey)
    destination = np.repeat(grey[..., None], 3, axis=2).astype(image.dtype)
    return oracles.clone(destination, image if source is None else source, mask, **variant)


def tile(
    image: Array, *, rect: tuple[int, int, int, int] | None = None, axis: str = "both", space: str = "rgb"
) -> Array:
    """Seamless tiling of a rectangle (row, column, height, width), Fig. 12; the result is as large as it.

    Along `axis` "x" the left and the right side become their mean, and nothing is known on the other two; "y" the
    other way round.  With "both" all four sides are known, and a corner is the mean of the four.
    """
    row, col, height, width = rect or (0, 0, *image.shape[:2])
    full = oracles.full_scale(image.dtype)
    g = oracles.working(image[row : row + height, col : col + width], full, space)
    f, region = g.copy(), np.ones((height, width), bool)
    if axis in ("x", "both"):
        f[:, 0] = f[:, -1] = (f[:, 0] + f[:, -1]) / 2
        region[:, [0, -1]] = False
    if axis in ("y", "both"):
        f[0] = f[-1] = (f[0] + f[-1]) / 2
        region[[0, -1]] = False
    solution = oracles.solve(region, f, *oracles.guidance(oracles.imported, g, g))
    return oracles.restored(solution, full, space)


# --- the conclusion, and what the paper points to ---------------------------------------------------


def focus(image: Array, mask: Array, *, amount: float, **variant: Any) -> Array:
    """The conclusion's change of focus."""
    return own(image, mask, then=[scale(amount)], **variant)


def heal(image: Array, mask: Array, *, offset: tuple[int, int], **variant: Any) -> Array:
    """Concealment, Fig. 2: g_p is the picture's value at p + offset."""
    away = (-offset[0], -offset[1])
    return oracles.clone(image, image, mask, offset=away, mask_on="destination", **variant)
