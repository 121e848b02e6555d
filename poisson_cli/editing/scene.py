"""What an edit is made of: the picture, what is laid on it, and where."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing.guidance import Role
from poisson_cli.editing.layers import Layer, Look
from poisson_cli.editing.placement import Placement
from poisson_cli.editing.spaces import Space


class Scene(NamedTuple):
    """The pictures of an edit, whole.

    Attributes
    ----------
    destination : (H, W) or (H, W, C) array
        f*.
    placement : Placement
    source : (H, W) or (H, W, C) array, optional
        g.
    look : callable, optional
        What is shown of the source instead of its stored values.
    """

    destination: NDArray[Any]
    placement: Placement
    source: NDArray[Any] | None = None
    look: Look | None = None

    @property
    def channels(self) -> int | None:
        """The destination's; None if it is (H, W)."""
        return self.destination.shape[2] if self.destination.ndim == 3 else None

    def picture(self, role: Role) -> NDArray[Any]:
        """One of the pictures."""
        picture = self.source if role == "source" else self.destination
        assert picture is not None, "a field that needs a source was given none"
        return picture

    def layer(self, role: Role, space: Space) -> Layer:
        """What lies of one of the pictures under the window, in a space."""
        picture = self.picture(role)
        if role == "destination":
            return Layer.of_destination(picture, self.placement, space)
        return Layer.of_source(picture, self.placement, self.channels, look=self.look, space=space)

    def under_window(self, role: Role, per_pixel: NDArray[Any]) -> NDArray[Any]:
        """(h, w) part of what is given for each pixel of one of the pictures; beyond it, its edge continues."""
        if role == "destination":
            return self.placement.on_destination(per_pixel)
        rows, cols, padding = self.placement.source_window()
        return np.pad(per_pixel[rows, cols], padding, mode="edge")
