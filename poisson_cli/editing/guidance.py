"""The paper's guidance fields v, on pixel pairs.

A field is told as a picture a, whose gradient it imports, and what it has beyond that gradient, w = v - grad a.  The
solution is then sought as f = a + u, and all that remains to be solved for is u, with guidance w and known values
f* - a: smoother and smaller than f, and most fields have no w at all.

Both are made of the destination f* and the source g in a band of rows of the window, (n, w, c) working values.
"""

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from poisson_cli.editing.layers import Band
from solvers import Guidance
from solvers.canvas import Values

Gradients = Literal["source", "average"]
Role = Literal["destination", "source"]

# A factor for each pixel pair, for the rows of a band; broadcast over channels.
Factors = Callable[[Band], Guidance]


class Field(NamedTuple):
    """A guidance field.

    Attributes
    ----------
    a : {"destination", "source"} or callable
        The picture that a is, or what makes it.
    beyond : callable or None
        Makes w; None for zero.
    of : tuple of {"destination", "source"}
        The pictures whose gradients v is made of.
    small : bool
        Whether a and w are integers, or halves of integers, where f* and g are integers.
    """

    a: Role | Callable[[Band], Values]
    beyond: Callable[[Band], Guidance] | None = None
    of: tuple[Role, ...] = ("source",)
    small: bool = True

    def base(self, band: Band) -> Values:
        """The picture a; it may be f* or g itself."""
        if callable(self.a):
            return self.a(band)
        return band.source if self.a == "source" else band.destination

    @property
    def picture(self) -> Role | None:
        """Which picture a is; None if none."""
        return None if callable(self.a) else self.a

    def then(self, factors: Factors) -> "Field":
        """The same a, with each v_pq multiplied by a factor s: w' = s w + (s - 1) grad a.

        So that s = 1 leaves w as it is, to the last bit.
        """

        def scaled(band: Band) -> Guidance:
            s, gradient = factors(band), Guidance.of(self.base(band))
            across, down = (s.across - 1) * gradient.across, (s.down - 1) * gradient.down
            if self.beyond is not None:
                w = self.beyond(band)
                across += s.across * w.across
                down += s.down * w.down
            return Guidance(across, down)

        return self._replace(beyond=scaled, small=False)


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
imported = Field("source")

# The same of the destination itself: nothing changes, until a transform does something to it (section 4).
own = Field("destination", of=("destination",))

# The mean of both gradients: the linear combination of section 3, which washes textures out (Fig. 6c).
averaged = Field(lambda band: (band.destination + band.source) / 2, of=("source", "destination"))

# The stronger gradient of the two, pair by pair and channel by channel; the source's in a draw (eq. 13).
mixed = Field("source", _stronger_gradients_of_the_destination, of=("source", "destination"))

# v = 0 (eq. 2).  What lies under the selection does not matter then, not even in the last bit.
membrane = Field(lambda band: np.zeros_like(band.destination), of=())

# What clone's `gradients` option offers.
GRADIENTS: dict[Gradients, Field] = {"source": imported, "average": averaged}
