"""Where a picture has edges: OpenCV's Canny detector (extra `edges`)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

LOW = 6.0  # levels per pixel
HIGH = 12.0
SIGMA = 1.0  # pixels


def find_edges(
    image: NDArray[Any], *, low: float = LOW, high: float = HIGH, sigma: float = SIGMA
) -> NDArray[np.bool_]:
    """Pixels of a picture that lie on an edge, by Canny's detector in OpenCV.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
    low, high : float
        Canny's two thresholds for the norm of the gradient, in levels per pixel: a ridge is an edge where it exceeds
        `low`, if it exceeds `high` somewhere.  (OpenCV's own thresholds, for its 3 x 3 Sobel filter, are 8 times that.)
    sigma : float
        Of the Gaussian that smoothes the picture before, in pixels; 0 for none.

    Returns
    -------
    (H, W) bool

    Raises
    ------
    InputError
        If OpenCV is missing, or a parameter makes no sense.
    """
    raise NotImplementedError
