"""The paper's guidance fields v, on pixel pairs.

Every function takes the destination f* and the source g under the same window, (h, w) or (h, w, c) working floats, and
returns v for each horizontal and each vertical pair of neighbours, channel by channel.
"""

from collections.abc import Callable
from typing import Literal

import numpy as np

from solvers import Guidance
from solvers.problem import Values

Field = Callable[[Values, Values], Guidance]
Gradients = Literal["source", "average"]


def imported(destination: Values, source: Values) -> Guidance:
    """v_pq = g_p - g_q (eq. 11)."""
    return Guidance.of(source)


def averaged(destination: Values, source: Values) -> Guidance:
    """The mean of both gradients: the linear combination of section 3, which washes textures out (Fig. 6c)."""
    return _by_pair(lambda f, g: (f + g) / 2, destination, source)


def mixed(destination: Values, source: Values) -> Guidance:
    """The stronger gradient of the two, pair by pair and channel by channel; the source's in a draw (eq. 13)."""
    return _by_pair(_stronger, destination, source)


def _stronger(f: Values, g: Values) -> Values:
    np.copyto(g, f, where=np.abs(f) > np.abs(g))
    return g


def _by_pair(choose: Callable[[Values, Values], Values], destination: Values, source: Values) -> Guidance:
    """A field chosen from both gradients; `choose` may write into its arguments."""
    f, g = Guidance.of(destination), Guidance.of(source)
    return Guidance(choose(f.across, g.across), choose(f.down, g.down))


# What clone's `gradients` option offers.
GRADIENTS: dict[Gradients, Field] = {"source": imported, "average": averaged}
