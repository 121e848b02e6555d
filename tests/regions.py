"""The region shapes that every solver and every tool must get right.

Each is a function of (height, width) that returns an (H, W) bool array, True where a pixel is unknown;
the same arguments always give the same region.  `SHAPES` has them all by name.
"""

from collections.abc import Callable

import numpy as np

Region = np.ndarray
Shape = Callable[[int, int], Region]


def _centred(height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Row and column of every pixel, counted from the centre of the picture."""
    row, col = np.mgrid[:height, :width]
    return row - (height - 1) / 2, col - (width - 1) / 2


def _reach(height: int, width: int) -> float:
    """Radius of the largest disk that leaves a rim of known pixels."""
    return max(0.5, 0.47 * min(height, width))


def disk(height: int, width: int) -> Region:
    row, col = _centred(height, width)
    return np.hypot(row, col) < _reach(height, width)


def ring(height: int, width: int) -> Region:
    row, col = _centred(height, width)
    return disk(height, width) & (np.hypot(row, col) > 0.4 * _reach(height, width))


def lasso(height: int, width: int) -> Region:
    """What a hand draws: round, with bays and lobes."""
    row, col = _centred(height, width)
    angle = np.arctan2(row, col)
    wobble = 0.7 + 0.18 * np.sin(3 * angle + 1) + 0.1 * np.sin(7 * angle)
    return np.hypot(row, col) < _reach(height, width) * wobble


def one_pixel(height: int, width: int) -> Region:
    region = np.zeros((height, width), bool)
    region[height // 2, width // 2] = True
    return region


def _strokes(height: int, width: int, thickness: int) -> Region:
    """A wave from left to right, one from top to bottom, and a diagonal."""
    row, col = np.mgrid[:height, :width]
    wave = np.rint(height / 2 + height / 4 * np.sin(7 * col / width))
    fall = np.rint(width / 3 + width / 5 * np.sin(5 * row / height))
    diagonal = np.rint(row * width / height)
    return (
        ((row >= wave) & (row < wave + thickness))
        | ((col >= fall) & (col < fall + thickness))
        | ((col >= diagonal) & (col < diagonal + thickness))
    )


def strokes_of_1_pixel(height: int, width: int) -> Region:
    return _strokes(height, width, 1)


def strokes_of_2_pixels(height: int, width: int) -> Region:
    return _strokes(height, width, 2)


def strokes_of_3_pixels(height: int, width: int) -> Region:
    return _strokes(height, width, 3)


def noise(height: int, width: int) -> Region:
    return np.random.default_rng(11).random((height, width)) < 0.5


def checkerboard(height: int, width: int) -> Region:
    row, col = np.mgrid[:height, :width]
    return (row + col) % 2 == 0


def islands(height: int, width: int) -> Region:
    """Squares of 1 to 6 pixels, one in every 8 x 8 tile, none touching another."""
    row, col = np.mgrid[:height, :width]
    side = 1 + (3 * (row // 8) + 5 * (col // 8)) % 6
    return (row % 8 < side) & (col % 8 < side)


def spiral(height: int, width: int) -> Region:
    """One long corridor, six pixels wide, between walls of known pixels, that winds to the centre."""
    row, col = _centred(height, width)
    turns = np.hypot(row, col) / 8 - np.arctan2(row, col) / (2 * np.pi)
    return disk(height, width) & (turns % 1 > 0.2)


def spiral_wall(height: int, width: int) -> Region:
    """The other way round: a thin spiral of known pixels in a picture otherwise unknown."""
    row, col = _centred(height, width)
    turns = np.hypot(row, col) / 24 - np.arctan2(row, col) / (2 * np.pi)
    return (turns % 1 > 1 / 24) | (np.hypot(row, col) > _reach(height, width))


def pins(height: int, width: int) -> Region:
    """Holes: single known pixels far apart, the hardest case for a coarse grid."""
    region = known_frame(height, width)
    rng = np.random.default_rng(5)
    count = max(2, height * width // 1000)
    region[rng.integers(height, size=count), rng.integers(width, size=count)] = False
    return region


def cracks(height: int, width: int) -> Region:
    """Known lines one pixel wide that cut the region here and there, but not into pieces."""
    region = known_frame(height, width)
    rng = np.random.default_rng(8)
    for start_row, start_col, angle in rng.random((9, 3)):
        step = np.arange(0, 0.5 * max(height, width), 0.5)
        row = np.rint(start_row * height + step * np.sin(7 * angle)).astype(int)
        col = np.rint(start_col * width + step * np.cos(7 * angle)).astype(int)
        inside = (row >= 0) & (row < height) & (col >= 0) & (col < width)
        region[row[inside], col[inside]] = False
    return region


def known_frame(height: int, width: int) -> Region:
    """Everything but the picture's outermost pixels."""
    region = np.zeros((height, width), bool)
    region[1:-1, 1:-1] = True
    return region


def unknown_frame(height: int, width: int) -> Region:
    """Only the picture's outermost pixels: every unknown has a truncated neighbourhood."""
    return ~known_frame(height, width)


def edge_touching(height: int, width: int) -> Region:
    """Half a disk against the top edge, half an ellipse against the right one."""
    row, col = np.mgrid[:height, :width]
    top = np.hypot(row, col - width / 3) < 0.3 * min(height, width)
    right = np.hypot((row - 0.6 * height) / 2, width - 1 - col) < 0.17 * min(height, width)
    return top | right


def corner_touching(height: int, width: int) -> Region:
    row, col = np.mgrid[:height, :width]
    return np.hypot(height - 1 - row, width - 1 - col) < 0.7 * min(height, width)


def left_half(height: int, width: int) -> Region:
    """Touches three edges; known pixels on one side only."""
    region = np.zeros((height, width), bool)
    region[:, : (width + 1) // 2] = True
    return region


def all_but_one_pixel(height: int, width: int) -> Region:
    region = np.ones((height, width), bool)
    region[int(0.55 * height), int(0.43 * width)] = False
    return region


def one_known_corner(height: int, width: int) -> Region:
    region = np.ones((height, width), bool)
    region[0, 0] = False
    return region


def everything(height: int, width: int) -> Region:
    """No pixel is known: the picture is fixed up to its mean."""
    return np.ones((height, width), bool)


SHAPES: dict[str, Shape] = {
    shape.__name__: shape
    for shape in (
        disk,
        ring,
        lasso,
        one_pixel,
        strokes_of_1_pixel,
        strokes_of_2_pixels,
        strokes_of_3_pixels,
        noise,
        checkerboard,
        islands,
        spiral,
        spiral_wall,
        pins,
        cracks,
        known_frame,
        unknown_frame,
        edge_touching,
        corner_touching,
        left_half,
        all_but_one_pixel,
        one_known_corner,
        everything,
    )
}

NEAR_SINGULAR = ("all_but_one_pixel", "one_known_corner", "everything")
"""Hardly anything ties these down, so that multigrid is allowed to contract more slowly."""

SMALL = (23, 30)
"""Height and width where the double-loop oracle is quick; one odd, one even."""

LARGE = (161, 161)
"""Height and width for accuracy and convergence."""

THIN = ((1, 1), (1, 2), (1, 64), (64, 1), (2, 61), (60, 2), (3, 40), (1, 801))
"""Pictures so thin that there is nothing to coarsen in one direction, or in both."""
