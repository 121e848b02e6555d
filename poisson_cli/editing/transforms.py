"""What can be done to a guidance field before it is integrated: section 4's changes, as factors on pixel pairs.

Each of them multiplies v_pq by a factor of the pair's own, and so they can be chained, and put behind an import
(the paper's conclusion): ``clone(..., then=[Sieve(), Scale(1.5)])``.

A `Sieve` and an `Attenuate` look at the pictures that the gradients come from: the picture itself when it is edited in
place, the source for `clone`, and both of them for `mix` and for averaged gradients, taken together.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing.attenuation import attenuating
from poisson_cli.editing.edges import HIGH, LOW, SIGMA, find_edges
from poisson_cli.editing.guidance import Factors, Role
from poisson_cli.editing.layers import Band
from poisson_cli.editing.logarithm import LogLuminance
from poisson_cli.editing.numbers import LARGEST_FACTOR, check_number
from poisson_cli.editing.scene import Scene
from poisson_cli.editing.spaces import Space
from poisson_cli.errors import InputError
from solvers import Guidance

ALPHA = 0.2
BETA = 0.2
# The colours of an import may change where its luminance does not: norms below this times a count as that.
LEAST_NORM = 0.1


@dataclass(frozen=True, eq=False)
class Sieve:
    """Keeps v_pq where an edge lies between p and q, and makes it zero elsewhere (eqs. 14-15).

    An edge lies between p and q if one of them, or both, is an edge pixel.

    Attributes
    ----------
    edges : (H, W) array or None
        Non-zero = edge; of the size of the picture whose gradients are sieved (of the source, for an import).  None:
        those that `find_edges` finds in the whole picture; in either picture, for `mix` and for averaged gradients.
    low, high, sigma : float
        See `find_edges`; of no effect if edges are given.
    """

    edges: NDArray[Any] | None = None
    low: float = LOW
    high: float = HIGH
    sigma: float = SIGMA

    def on(self, scene: Scene, of: Sequence[Role], space: Space) -> Factors:
        """1 where an edge lies between the pixels of a pair, else 0."""
        edges = self._under_window(scene, of)
        across, down = edges[:, 1:] | edges[:, :-1], edges[1:] | edges[:-1]

        def factors(band: Band) -> Guidance:
            first, end = band.rows
            parts = across[first:end], down[first : end - 1]
            return Guidance(*(part[:, :, np.newaxis].astype(space.dtype) for part in parts))

        return factors

    def _under_window(self, scene: Scene, of: Sequence[Role]) -> NDArray[np.bool_]:
        if self.edges is not None:
            size = scene.picture(of[0]).shape[:2]
            return scene.under_window(of[0], check_edges(self.edges, size, of[0]))
        found = [
            scene.under_window(
                role, find_edges(scene.picture(role), low=self.low, high=self.high, sigma=self.sigma)
            )
            for role in of
        ]
        return np.asarray(np.logical_or.reduce(found))


@dataclass(frozen=True)
class Scale:
    """Multiplies v by `amount`: more contrast above 1, less below it, none at 0 (the membrane)."""

    amount: float

    def on(self, scene: Scene, of: Sequence[Role], space: Space) -> Factors:
        """The same factor everywhere."""
        check_number("amount", self.amount, 0, LARGEST_FACTOR)
        factor = np.full((1, 1, 1), self.amount, space.dtype)
        return lambda band: Guidance(factor, factor)


@dataclass(frozen=True)
class Attenuate:
    """Makes large gradients smaller and small ones larger: v' = a^beta |grad L|^-beta v (eq. 16).

    L is the log luminance of the picture that the gradients come from, whatever v is a gradient of, and a is `alpha`
    times the mean of |grad L| over the pixel pairs of Omega.  See `relight` for the norm, and for why an import is
    not solved in the log domain.  With two pictures |grad L| is the larger one of both.
    An import's colours may change where its luminance does not: |grad L| below a tenth of a counts as that.

    Attributes
    ----------
    alpha : float
        Positive, at most 1000.
    beta : float
        From -1 to 1; 0 changes nothing, and a negative one does the reverse.
    """

    alpha: float = ALPHA
    beta: float = BETA

    def on(self, scene: Scene, of: Sequence[Role], space: Space) -> Factors:
        """(a / |grad L|)^beta."""
        logs = LogLuminance(space)
        logs.check("destination", scene.channels or 1)  # the source has as many here, or one
        layers = [scene.layer(role, logs) for role in of]
        region = scene.placement.region
        return attenuating(layers, region, alpha=self.alpha, beta=self.beta, least=LEAST_NORM)


Transform = Sieve | Scale | Attenuate


def check_edges(edges: Any, size: tuple[int, ...], name: str) -> NDArray[np.bool_]:
    """Edges as an (H, W) bool array; InputError if they are not of that size."""
    array = np.asarray(edges)
    if array.shape != size:
        raise InputError(
            f"the edges have shape {array.shape}, but the {name} has {size}: give one value for each pixel"
        )
    return array if array.dtype == np.bool_ else array != 0
