"""The equations to solve: what every solver takes, validated once."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Values = NDArray[np.float32] | NDArray[np.float64]

# Sums of a few values must stay far from float32's largest number, 3.4e38.
LARGEST_VALUE = 1e30


class OptionError(ValueError):
    """An option of a solver makes no sense."""


@dataclass(frozen=True)
class Guidance:
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


@dataclass(frozen=True, init=False)
class PoissonProblem:
    """Eq. (7) of Perez et al. 2003 for an image of one or more channels.

    For every unknown pixel p, with N_p its 4-neighbours inside the image,

        |N_p| f_p - sum over unknown q of f_q = sum over known q of f*_q + sum over all q of v_pq

    The edge of the arrays is the edge of the image: a pixel there has fewer neighbours, a natural condition.  A crop
    must therefore keep one ring of known pixels around the region wherever the image goes on.

    Parameters
    ----------
    region : (H, W) bool
        True = unknown.  If all pixels are unknown the solution keeps the mean of the first guess, per channel.
    values : (H, W) or (H, W, C) float32 or float64
        Known values f* where `region` is False, first guess where it is True.  Never modified.
    guidance : Guidance, optional
        v on pixel pairs; none means v = 0, the membrane.
    rhs : (H, W[, C]) float, optional
        Instead of `guidance`: the sum over q in N_p of v_pq, read where `region` is True.
    level : float
        The size of one level, 1/255 of full scale, in the units of `values`: 1 for 8 bit, 257 for 16 bit.

    Raises
    ------
    ValueError
        If shapes do not fit, no pixel is unknown, or a value is not finite or above 1e30.
    """

    region: NDArray[np.bool_]
    values: Values
    guidance: Guidance | None = None
    rhs: Values | None = field(default=None)
    level: float = 1.0

    def __init__(
        self,
        region: ArrayLike,
        values: Values,
        guidance: Guidance | None = None,
        *,
        rhs: Values | None = None,
        level: float = 1.0,
    ) -> None:
        set_ = object.__setattr__  # the way a frozen dataclass sets its own fields
        set_(self, "region", _region(region))
        set_(self, "values", _floats("values", values))
        height, width = self.region.shape
        if (
            self.values.ndim not in (2, 3)
            or self.values.shape[:2] != (height, width)
            or self.values.size == 0
        ):
            raise ValueError(
                f"values of shape {self.values.shape} do not fit a region of shape {(height, width)}"
            )
        if guidance is not None and rhs is not None:
            raise ValueError("give guidance or rhs, not both")
        channels = self.values.shape[2:]
        if guidance is not None:
            guidance = Guidance(
                _floats("guidance.across", guidance.across, (height, width - 1, *channels)),
                _floats("guidance.down", guidance.down, (height - 1, width, *channels)),
            )
        set_(self, "guidance", guidance)
        set_(self, "rhs", None if rhs is None else _floats("rhs", rhs, self.values.shape))
        if not (np.isfinite(level) and level > 0):
            raise ValueError(f"level is {level}, but must be a positive number")
        set_(self, "level", float(level))

    @property
    def channels(self) -> int:
        """Number of channels, 1 for (H, W) values."""
        return 1 if self.values.ndim == 2 else self.values.shape[2]

    @property
    def unknowns(self) -> int:
        """Number of unknown pixels."""
        return int(np.count_nonzero(self.region))

    @property
    def floating(self) -> bool:
        """True where no pixel is known.

        Only then: the image's pixels are connected, so a part of the region that touches no known pixel is the image.
        """
        return bool(self.region.all())


def _region(region: ArrayLike) -> NDArray[np.bool_]:
    array = np.ascontiguousarray(region)
    if array.dtype != np.bool_ or array.ndim != 2:
        raise ValueError(f"region must be a 2-d bool array, not {array.ndim}-d {array.dtype}")
    if not array.any():
        raise ValueError("region is empty: no pixel is unknown")
    return array


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
