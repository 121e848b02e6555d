"""The paper's guidance fields v, on pixel pairs.

A field is told as a picture a, whose gradient it imports, and what it has beyond that gradient, w = v - grad a.  The
solution is then sought as f = a + u, and all that remains to be solved for is u, with guidance w and known values
f* - a: smoother and smaller than f, and most fields have no w at all.

Both are made of the destination f* and the source g in a band of rows of the window, (n, w, c) working floats.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from poisson_cli.editing.layers import Band
from solvers import Guidance
from solvers.canvas import Values

Gradients = Literal["source", "average"]


@dataclass(frozen=True)
class Field:
    """A guidance field.

    Attributes
    ----------
    base : callable
        Makes a; it may be f* or g itself.
    beyond : callable or None
        Makes w; None for zero.
    """

    base: Callable[[Band], Values]
    beyond: Callable[[Band], Guidance] | None = None


def _stronger_gradients_of_the_destination(band: Band) -> Guidance:
    """What to add to the source's gradient to have the destination's where that is stronger."""

    def choose(f: Values, g: Values) -> Values:
        stronger = np.abs(f) > np.abs(g)
        f -= g
        f *= stronger
        return f

    f, g = Guidance.of(band.destination), Guidance.of(band.source)
    return Guidance(choose(f.across, g.across), choose(f.down, g.down))


# v_pq = g_p - g_q (eq. 11).
imported = Field(lambda band: band.source)

# The mean of both gradients: the linear combination of section 3, which washes textures out (Fig. 6c).
averaged = Field(lambda band: (band.destination + band.source) / 2)

# The stronger gradient of the two, pair by pair and channel by channel; the source's in a draw (eq. 13).
mixed = Field(lambda band: band.source, _stronger_gradients_of_the_destination)

# v = 0 (eq. 2).  What lies under the selection does not matter then, not even in the last bit.
membrane = Field(lambda band: np.zeros_like(band.destination))

# What clone's `gradients` option offers.
GRADIENTS: dict[Gradients, Field] = {"source": imported, "average": averaged}
