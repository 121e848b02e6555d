"""Single pixels of integer pictures, straight from where they are stored: the same as by indexing."""

import numpy as np
import pytest

from poisson_cli.editing import tone
from poisson_cli.editing.layers import Layer
from poisson_cli.editing.placement import place

DEPTHS = pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
CHANNELS = pytest.mark.parametrize("channels", [None, 1, 2, 3, 4])


def picture(seed: int, height: int, width: int, channels: int | None, dtype) -> np.ndarray:
    shape = (height, width) if channels is None else (height, width, channels)
    return np.random.default_rng(seed).integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)


@DEPTHS
@CHANNELS
def test_differences(dtype, channels):
    one, other = picture(1, 30, 23, channels, dtype), picture(2, 41, 37, channels, dtype)
    rows, cols = np.random.default_rng(3).integers(0, 17, (2, 500))
    got = tone.subtract(tone.Stored.of(one, (4, 5)), tone.Stored.of(other, (11, 0)), rows, cols)
    expected = one[rows + 4, cols + 5].astype(int) - other[rows + 11, cols].astype(int)
    assert got.dtype == np.float32
    assert np.array_equal(got, expected.reshape(500, -1))


def test_no_differences():
    stored = tone.Stored.of(picture(1, 5, 5, 3, np.uint8), (0, 0))
    assert tone.subtract(stored, stored, np.empty(0, int), np.empty(0, int)).shape == (0, 3)


@DEPTHS
@CHANNELS
def test_rounding_and_clipping(dtype, channels):
    """Halves go to even numbers; what leaves the range is clipped and counted, as where it is done row by row."""
    base, before = picture(4, 28, 31, channels, dtype), picture(5, 35, 26, channels, dtype)
    width, random = 19, np.random.default_rng(6)
    at = np.sort(random.choice(22 * width, 150, replace=False))
    correction = random.integers(-400, 400, (150, channels or 1)) * (np.iinfo(dtype).max / 255) // 1 / 2
    painted = before.copy()
    clipped, overshoot = tone.paste_at(
        tone.Stored.of(painted, (13, 7)), tone.Stored.of(base, (6, 12)), correction, at, width
    )
    row, col = at // width, at % width
    exact = base[row + 6, col + 12].reshape(150, -1) + correction
    largest = np.iinfo(dtype).max
    expected = before.copy()
    expected[row + 13, col + 7] = np.clip(np.rint(exact), 0, largest).reshape(expected[row, col].shape)
    assert np.array_equal(painted, expected)
    assert clipped == np.count_nonzero((exact < -0.5) | (exact > largest + 0.5)) > 0
    assert overshoot == pytest.approx(max(-exact.min(), exact.max() - largest) / tone.level(np.dtype(dtype)))


def test_what_is_not_stored_like_that():
    whole = picture(1, 6, 8, 3, np.uint8)
    assert tone.Stored.of(whole[:, ::2], (0, 0)) is None
    assert tone.Stored.of(whole.astype(np.float32), (0, 0)) is None
    inner = np.zeros((6, 8), bool)
    inner[2:4, 2:5] = True
    placement = place((20, 20, 3), (6, 8), inner, offset=(3, 4))
    assert Layer.of_source(whole, placement, 3).whole is not None
    assert Layer.of_source(whole[..., 0].copy(), placement, 3).whole is None  # spread over three channels
    assert Layer.of_source(whole, placement, 3, look=lambda values: values).whole is None
    overhanging = place((20, 20, 3), (6, 8), np.ones((6, 8), bool))
    assert Layer.of_source(whole, overhanging, 3).whole is None  # the window is larger than the source
