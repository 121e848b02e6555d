"""The log domain of eq. (16): spaces whose working values are logarithms.

What is solved for is u, the change of the logarithm, and the picture is multiplied by exp(u): black stays black, and
values below zero stay below it, however they came there.
"""

import numpy as np

from poisson_cli.editing import tone
from poisson_cli.editing.spaces import Space
from poisson_cli.errors import InputError
from solvers.canvas import Values

# Nothing becomes more than exp(this) times as bright, which is black made white many times over; in Lab, where that is
# cubed, float32 can hold no more.
LARGEST_CHANGE = 20.0


class LogLuminance:
    """The log of the luminance of another space (of its `brightness`): one channel, by which all others change alike.

    Luminance below that of a grey of half a level counts as that.
    """

    def __init__(self, space: Space) -> None:
        self.space = space
        self.name = space.name
        self.full = space.full
        self.dtype = space.dtype
        self.level = 1 / (255 * space.expansion)
        self.expansion = space.expansion
        grey = np.full((1, 3), space.full / 510, space.dtype)
        self._least = space.brightness(space.to_working(grey)).item()

    def check(self, name: str, channels: int) -> None:
        """Luminance must mean something."""
        self.space.check(name, channels)
        tone.check_luminance(name, channels)

    def channels(self, stored: int) -> int:
        """One."""
        return 1

    def to_working(self, stored: Values) -> Values:
        """(..., 1) logs."""
        brightness = self.space.brightness(self.space.to_working(stored))
        logs: Values = np.log(np.maximum(brightness, self._least))
        return logs

    def to_stored(
        self, working: Values, before: Values | None = None, stored: Values | None = None
    ) -> Values:
        """The picture `stored`, every working value of it multiplied by exp(working - before)."""
        assert before is not None
        assert stored is not None
        inner = self.space.to_working(stored.astype(self.dtype))
        change = np.minimum(working - before, working.dtype.type(LARGEST_CHANGE))
        return self.space.to_stored(inner * np.exp(change), inner, stored)

    def brightness(self, working: Values) -> Values:
        """Itself."""
        return working


class LogChannels(LogLuminance):
    """The log of each channel of another space by itself; values below half a level count as that."""

    def check(self, name: str, channels: int) -> None:
        """Logarithms of a* and b* make no sense."""
        if self.space.name == "lab":
            raise InputError(
                "per_channel needs the space 'rgb' or 'linear': colours in CIE-Lab are no intensities"
            )

    def channels(self, stored: int) -> int:
        """As many."""
        return stored

    def to_working(self, stored: Values) -> Values:
        """(..., C) logs."""
        logs: Values = np.log(np.maximum(self.space.to_working(stored), self._least))
        return logs
