"""The spaces that the equations can be solved in.

A space turns stored values into working values and back.  Working values are what a guidance field is a gradient of and
what the solver returns; the spaces' own docstrings tell their units.
"""

from collections.abc import Callable
from typing import Any, Literal, Protocol, get_args

import numpy as np

from poisson_cli.editing import colour, tone
from poisson_cli.errors import InputError
from solvers.canvas import Values

SpaceName = Literal["rgb", "linear", "lab"]

# How much a stored value (full scale 1) can change per unit of L*, a*, b*, if the three of them may change by that much
# at once: the largest sum of a row of the Jacobian anywhere in the gamut is .356, near dark cyan.
LAB_SLOPE = 0.36
# The same per unit of u where L*, a*, b* are multiplied by exp(u): 1.393, at cyan.
LAB_EXPANSION = 1.4


class Space(Protocol):
    """A space, for pictures of one depth.

    Attributes
    ----------
    name : str
    full : float
        Full scale of the stored values.
    dtype : float32 or float64
        Of working values.
    level : float
        An error of this size in every working value of a pixel is at most one level in its stored values.
    expansion : float
        If all working values of a pixel are multiplied by exp(u), its stored values (full scale 1) change at most by
        this times u.
    """

    name: str
    full: float
    dtype: np.dtype[Any]
    level: float
    expansion: float

    def check(self, name: str, channels: int) -> None:
        """InputError, naming the picture, if one of so many channels has no place in this space."""

    def channels(self, stored: int) -> int:
        """How many working values a pixel of so many stored values has."""

    def to_working(self, stored: Values) -> Values:
        """(..., C) stored values as working values; possibly in the same memory."""

    def to_stored(
        self, working: Values, before: Values | None = None, stored: Values | None = None
    ) -> Values:
        """Working values as stored ones, neither rounded nor clipped.

        Where they are still equal to `before`, the working values of the picture `stored`, the result is `stored`: a
        value that an edit leaves alone comes back as the same bits.
        """

    def brightness(self, working: Values) -> Values:
        """(..., 1) what stands for luminance here."""


class AsStored:
    """The values as they are stored, the paper's RGB: 0..255 for 8 bit, 0..65535 for 16 bit, 0..1 for floats."""

    name = "rgb"
    expansion = 1.0

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.full = tone.FULL_SCALE[dtype.type]
        self.dtype = tone.working_dtype(dtype)
        self.level = tone.level(dtype)

    def check(self, name: str, channels: int) -> None:
        """All pictures have a place."""

    def channels(self, stored: int) -> int:
        """As many."""
        return stored

    def to_working(self, stored: Values) -> Values:
        """The same array."""
        return stored

    def to_stored(
        self, working: Values, before: Values | None = None, stored: Values | None = None
    ) -> Values:
        """The same array."""
        return working

    def brightness(self, working: Values) -> Values:
        """Luminance of the stored values, luma."""
        return colour.luminance(working)


class Linear:
    """Linear light, 0..1: sRGB's curve undone, channel by channel.  Light adds up here as it does in the world."""

    name = "linear"
    expansion = 1.0  # .44 times a stored value

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.full = tone.FULL_SCALE[dtype.type]
        self.dtype = tone.working_dtype(dtype)
        self.level = 1 / (255 * colour.SLOPE)  # sRGB's curve is steepest at black

    def check(self, name: str, channels: int) -> None:
        """All pictures have a place."""

    def channels(self, stored: int) -> int:
        """As many."""
        return stored

    def to_working(self, stored: Values) -> Values:
        """Light."""
        return colour.decode_srgb(stored / stored.dtype.type(self.full))

    def to_stored(
        self, working: Values, before: Values | None = None, stored: Values | None = None
    ) -> Values:
        """See `Space`; each channel is looked at alone."""
        encoded = colour.encode_srgb(working)
        encoded *= encoded.dtype.type(self.full)
        return _kept(encoded, working == before, stored)

    def brightness(self, working: Values) -> Values:
        """Luminance Y, 0..1."""
        return colour.luminance(working)


class Lab:
    """CIE-Lab, white D65: L* in 0..100, a* and b*.  Equal distances look about equally large."""

    name = "lab"
    level = 1 / (255 * LAB_SLOPE)
    expansion = LAB_EXPANSION

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.full = tone.FULL_SCALE[dtype.type]
        # float32 would lose the last bit of 16.
        self.dtype = np.dtype(np.float32 if dtype == np.uint8 else np.float64)

    def check(self, name: str, channels: int) -> None:
        """Red, green and blue are needed."""
        if channels != 3:
            plural = "" if channels == 1 else "s"
            raise InputError(
                f"CIE-Lab needs red, green and blue, but the {name} has {channels} channel{plural}: "
                "use another space"
            )

    def channels(self, stored: int) -> int:
        """Three."""
        return 3

    def to_working(self, stored: Values) -> Values:
        """L*, a*, b*."""
        return colour.lab_of(stored.astype(self.dtype) / self.dtype.type(self.full))

    def to_stored(
        self, working: Values, before: Values | None = None, stored: Values | None = None
    ) -> Values:
        """See `Space`."""
        encoded = colour.srgb_of(working)
        encoded *= encoded.dtype.type(self.full)
        same = None if before is None else (working == before).all(-1, keepdims=True)
        return _kept(encoded, same, stored)

    def brightness(self, working: Values) -> Values:
        """Lightness L*, 0..100."""
        return working[..., :1]


class Fitted:
    """Another space, whose colours lose as much saturation as they must to lie in low ... high when they are stored."""

    def __init__(self, space: Space, low: float, high: float) -> None:
        self.name, self.full, self.dtype = space.name, space.full, space.dtype
        self.level, self.expansion = space.level, space.expansion
        self.check, self.channels, self.to_working = space.check, space.channels, space.to_working
        self.brightness = space.brightness
        self._space, self._range = space, (low, high)

    def to_stored(
        self, working: Values, before: Values | None = None, stored: Values | None = None
    ) -> Values:
        """See `Space`."""
        return colour.drawn_into(self._space.to_stored(working, before, stored), *self._range)


def _kept(encoded: Values, same: Any, stored: Values | None) -> Values:
    if stored is not None:
        np.copyto(encoded, stored, where=same)
    return encoded


_SPACES: dict[str, Callable[[np.dtype[Any]], Space]] = {
    "rgb": AsStored,
    "linear": Linear,
    "lab": Lab,
}


def named(name: SpaceName, dtype: np.dtype[Any]) -> Space:
    """The space of that name, for pictures of a depth; InputError if there is none."""
    if name not in _SPACES:
        raise InputError(f"space is {name!r}, but must be one of {', '.join(map(repr, get_args(SpaceName)))}")
    return _SPACES[name](dtype)
