"""Where a picture has edges: OpenCV's Canny detector (extra `edges`)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.numbers import check_number
from poisson_cli.errors import InputError

LOW = 4.0  # levels per pixel
HIGH = 9.0
SIGMA = 1.0  # pixels

# OpenCV's 3 x 3 Sobel filter, which its Canny uses, gives this many times the gradient.
_SOBEL = 8.0


def find_edges(
    image: NDArray[Any], *, low: float = LOW, high: float = HIGH, sigma: float = SIGMA
) -> NDArray[np.bool_]:
    """Pixels of a picture that lie on an edge, by Canny's detector in OpenCV.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
        Looked at with 8 bits.  Of several channels that with the largest gradient counts.
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
    for name, value in (("low", low), ("high", high), ("sigma", sigma)):
        check_number(name, value, 0)
    if low > high:
        raise InputError(f"low is {low} and high is {high}, but low must not be the larger one")
    try:
        import cv2
    except ImportError as error:
        raise InputError(
            "finding edges needs OpenCV: pip install 'poisson-cli[edges]', or give the edges yourself"
        ) from error
    image = tone.check_picture("image", image)
    tone.check_values("image", image)
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]  # OpenCV knows no other single channel
    levels: NDArray[np.float32] = np.clip(image / tone.level(image.dtype), 0, 255).astype(np.float32)
    if sigma > 0:
        levels[...] = cv2.GaussianBlur(levels, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
    eight_bit = np.rint(levels).astype(np.uint8)
    edges: NDArray[np.bool_] = cv2.Canny(eight_bit, low * _SOBEL, high * _SOBEL, L2gradient=True) != 0
    return edges
