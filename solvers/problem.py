"""The equations to solve: what every solver takes, validated once."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from solvers.canvas import Arrays, Canvas, Values, gather

# Sums of a few values must stay far from float32's largest number, 3.4e38.
LARGEST_VALUE = 1e30

# Beyond, nothing of the neighbours is seen in float32 any more.
LARGEST_SCREENING = 1e6


class OptionError(ValueError):
    """An option of a solver makes no sense."""


class Guidance(NamedTuple):
    """A guidance field v, given on pixel pairs; v_qp = -v_pq.

    Attributes
    ----------
    across : (H, W - 1[, C]) float
        v_pq for p = (row, col) and q = (row, col + 1).
    down : (H - 1, W[, C]) float
        v_pq for p = (row, col) and q = (row + 1, col).

    Examples
    --------
    >>> import numpy as np
    >>> Guidance.of(np.array([[1.0, 4.0]])).across
    array([[-3.]])
    """

    across: Values
    down: Values

    @classmethod
    def of(cls, image: Values) -> "Guidance":
        """The gradient of an image, v_pq = g_p - g_q (eq. 11); `image` is (H, W[, C])."""
        return cls(image[:, :-1] - image[:, 1:], image[:-1] - image[1:])

    @classmethod
    def zero(cls, shape: tuple[int, ...]) -> "Guidance":
        """The field of the membrane (eq. 2), for values of `shape` (H, W[, C])."""
        height, width, *channels = shape
        return cls(np.zeros((height, width - 1, *channels)), np.zeros((height - 1, width, *channels)))


@dataclass(frozen=True, init=False, eq=False)
class PoissonProblem:
    """Eq. (7) of Perez et al. 2003 for an image of one or more channels.

    For every unknown pixel p, with N_p its 4-neighbours inside the image,

        |N_p| f_p - sum over unknown q of f_q = sum over known q of f*_q + sum over all q of v_pq

    and, with `screening` s, s f_p more on the left and s h_p more on the right, h being the first guess.

    The edge of the arrays is the edge of the image: a pixel there has fewer neighbours, a natural condition.  A crop
    must therefore keep one ring of known pixels around the region wherever the image goes on.

    Parameters
    ----------
    region : (H, W) bool
        True = unknown.  If all pixels are unknown (and nothing is screened) the solution keeps the mean of the first
        guess, per channel.
    values : (H, W) or (H, W, C) float32 or float64
        Known values f* where `region` is False, first guess where it is True.  Never modified.
    guidance : Guidance, optional
        v on pixel pairs; none means v = 0, the membrane.
    rhs : (H, W[, C]) float, optional
        Instead of `guidance`: the sum over q in N_p of v_pq, read where `region` is True.
    level : float
        The size of one level, 1/255 of full scale, in the units of `values`: 1 for 8 bit, 257 for 16 bit.
    screening : float
        s >= 0, per square pixel: how strongly every unknown is drawn to its first guess.  An influence from outside
        fades over about 1 / sqrt(s) pixels.  It is rounded so that float32 holds 4 + s, which below s = 4 means to a
        multiple of 5e-7; the attribute says what was taken.

    Attributes
    ----------
    canvas : Canvas
        The same numbers in the form in which solvers take them.

    Raises
    ------
    ValueError
        If shapes do not fit, no pixel is unknown, a value is not finite or above 1e30, or `screening` is negative.
    """

    region: NDArray[np.bool_]
    level: float
    screening: float
    canvas: Canvas

    def __init__(
        self,
        region: ArrayLike,
        values: Values,
        guidance: Guidance | None = None,
        *,
        rhs: Values | None = None,
        level: float = 1.0,
        screening: float = 0.0,
    ) -> None:
        set_ = object.__setattr__  # the way a frozen dataclass sets its own fields
        region, values = _region(region), _floats("values", values)
        height, width = region.shape
        if values.ndim not in (2, 3) or values.shape[:2] != (height, width) or values.size == 0:
            raise ValueError(f"values of shape {values.shape} do not fit a region of shape {(height, width)}")
        if guidance is not None and rhs is not None:
            raise ValueError("give guidance or rhs, not both")
        channels = values.shape[2:]
        if guidance is not None:
            guidance = Guidance(
                _floats("guidance.across", guidance.across, (height, width - 1, *channels)),
                _floats("guidance.down", guidance.down, (height - 1, width, *channels)),
            )
        rhs = None if rhs is None else _floats("rhs", rhs, values.shape)
        # With a natural condition all round there is a solution only if the right-hand side sums to zero.
        singular = screening == 0 and region.all()
        balanced = rhs - rhs.mean((0, 1)) if rhs is not None and singular else rhs
        across, down = (None, None) if guidance is None else (guidance.across, guidance.down)
        set_(self, "region", region)
        set_(self, "level", _level(level))
        set_(self, "screening", _screening(screening))
        set_(self, "canvas", Arrays(values, across, down, balanced))

    @classmethod
    def on_canvas(
        cls,
        region: ArrayLike,
        canvas: Canvas,
        *,
        level: float = 1.0,
        screening: float = 0.0,
        unknowns: int | None = None,
    ) -> "PoissonProblem":
        """A problem whose numbers are never held all at once: the canvas hands them out in bands of rows.

        Parameters
        ----------
        region : (H, W) bool
            True = unknown.
        canvas : Canvas
            Of the region's height and width.  It vouches for its numbers: finite, and below 1e30.  A solver's result
            has as its `solution` what the canvas painted.
        level, screening : float
            As above.
        unknowns : int, optional
            How many pixels of the region are True, if that is known: it is not counted again.
        """
        problem = cls.__new__(cls)
        region = _region(region)
        if canvas.shape[:2] != region.shape:
            raise ValueError(
                f"a canvas of shape {canvas.shape} does not fit a region of shape {region.shape}"
            )
        object.__setattr__(problem, "region", region)
        object.__setattr__(problem, "level", _level(level))
        object.__setattr__(problem, "screening", _screening(screening))
        object.__setattr__(problem, "canvas", canvas)
        if unknowns is not None:
            object.__setattr__(problem, "unknowns", unknowns)
        return problem

    @property
    def values(self) -> Values:
        """Known values and first guess, (H, W[, C]).  On another canvas than arrays it is gathered each time."""
        return gather(self.canvas).values

    @property
    def guidance(self) -> Guidance | None:
        """v on pixel pairs; None for v = 0."""
        whole = gather(self.canvas)
        return None if whole.across is None or whole.down is None else Guidance(whole.across, whole.down)

    @property
    def rhs(self) -> Values | None:
        """What stands for the guidance, if it was given; of mean zero if no pixel is known."""
        return gather(self.canvas).rhs

    @cached_property
    def channels(self) -> int:
        """Number of channels, 1 for (H, W) values."""
        return self.canvas.shape[2]

    @cached_property
    def unknowns(self) -> int:
        """Number of unknown pixels."""
        return int(np.count_nonzero(self.region))

    @cached_property
    def floating(self) -> bool:
        """True where no pixel is known and nothing draws to the first guess: all but a constant is determined.

        Only then: the image's pixels are connected, so a part of the region that touches no known pixel is the image.
        """
        return self.screening == 0 and self.unknowns == self.region.size


def _region(region: ArrayLike) -> NDArray[np.bool_]:
    array = np.ascontiguousarray(region)
    if array.dtype != np.bool_ or array.ndim != 2:
        raise ValueError(f"region must be a 2-d bool array, not {array.ndim}-d {array.dtype}")
    if not array.any():
        raise ValueError("region is empty: no pixel is unknown")
    return array


def _level(level: float) -> float:
    if not 0 < level < math.inf:
        raise ValueError(f"level is {level}, but must be a positive number")
    return float(level)


def _screening(screening: float) -> float:
    if not 0 <= screening < LARGEST_SCREENING:
        raise ValueError(f"screening is {screening}, but must be a number from 0 to {LARGEST_SCREENING:g}")
    return float(np.float32(4 + screening)) - 4  # the diagonal, 1 + s ... 4 + s, is then exact in float32


def _floats(name: str, values: Any, shape: tuple[int, ...] | None = None) -> Values:
    array = np.ascontiguousarray(values)  # what the kernels are compiled for
    if array.dtype not in (np.float32, np.float64):
        raise ValueError(f"{name} must be float32 or float64, not {array.dtype}")
    if shape is not None and array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}, but {shape} is needed")
    # One pass without a temporary array: NaN and infinities come through min and max.
    if array.size and not (-LARGEST_VALUE < array.min() <= array.max() < LARGEST_VALUE):
        raise ValueError(f"{name} must be finite and below {LARGEST_VALUE:g}")
    return array
