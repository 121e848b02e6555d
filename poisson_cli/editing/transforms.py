"""What can be done to a guidance field before it is integrated: section 4's changes, as factors on pixel pairs.

Each of them multiplies v_pq by a factor of the pair's own, and so they can be chained, and put behind an import
(the paper's conclusion): ``clone(..., then=[Sieve(), Scale(1.5)])``.

A `Sieve` and an `Attenuate` look at the pictures that the gradients come from: the picture itself when it is edited in
place, the source for `clone`, and both of them for `mix` and for averaged gradients, taken together.
"""

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from poisson_cli.editing.edges import HIGH, LOW, SIGMA

ALPHA = 0.2
BETA = 0.2


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


@dataclass(frozen=True)
class Scale:
    """Multiplies v by `amount`: more contrast above 1, less below it, none at 0 (the membrane)."""

    amount: float


@dataclass(frozen=True)
class Attenuate:
    """Makes large gradients smaller and small ones larger: v' = a^beta |grad L|^-beta v (eq. 16).

    L is the log luminance of the picture that the gradients come from, whatever v is a gradient of, and a is `alpha`
    times the mean of |grad L| over the pixel pairs of Omega.  See `relight` for the norm, and for why an import is
    not solved in the log domain.  With two pictures |grad L| is the larger one of both.

    Attributes
    ----------
    alpha : float
        Positive.
    beta : float
        At most 1; 0 changes nothing, and a negative one does the reverse.
    """

    alpha: float = ALPHA
    beta: float = BETA


Transform = Sieve | Scale | Attenuate
