"""The spaces that can be edited in: their formulas, what comes back from them, and what an error in them may do."""

import numpy as np
import pytest
from skimage import color

from poisson_cli.editing import colour, spaces
from poisson_cli.editing.logarithm import LogChannels, LogLuminance
from poisson_cli.errors import InputError

DEPTHS = [np.uint8, np.uint16, np.float32, np.float64]


def colours(number: int, seed: int = 0) -> np.ndarray:
    """Colours of full scale 1 from all of the cube, its corners, edges and greys among them."""
    rng = np.random.default_rng(seed)
    inside, ramp = rng.random((number, 3)), np.linspace(0, 1, number)
    greys = np.repeat(ramp[:, None], 3, axis=1)
    corners = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T.astype(float)
    edges = [np.insert(rng.integers(0, 2, (number, 2)).astype(float), i, ramp, axis=1) for i in range(3)]
    return np.concatenate([inside, greys, corners, *edges])


def test_srgb_is_that_of_scikit_image():
    values = np.linspace(0, 1, 10001)
    # It has no function for the curve alone, but XYZ of grey is the light times that of white.
    grey = np.repeat(values[:, None], 3, axis=1)
    light = color.rgb2xyz(grey)[:, 1] / color.rgb2xyz(np.ones(3))[1]
    np.testing.assert_allclose(colour.decode_srgb(values), light, rtol=0, atol=1e-12)
    np.testing.assert_allclose(colour.encode_srgb(light), values, rtol=0, atol=1e-7)


def test_lab_is_that_of_scikit_image():
    """But for the fourth digit of the primaries and of the white, which scikit-image rounds otherwise."""
    rgb = colours(5000)
    np.testing.assert_allclose(colour.lab_of(rgb), color.rgb2lab(rgb), rtol=0, atol=0.03)


def test_grey_is_neutral_and_white_is_100():
    grey = np.repeat(np.linspace(0, 1, 256)[:, None], 3, axis=1)
    lab = colour.lab_of(grey)
    assert np.abs(lab[:, 1:]).max() < 1e-12
    np.testing.assert_allclose(lab[[0, -1], 0], [0, 100], atol=1e-12)


@pytest.mark.parametrize("values", [np.linspace(-3, 5, 4001), np.array([0.04045, -0.04045])])
def test_the_curve_goes_on_beyond_its_range(values):
    np.testing.assert_allclose(colour.encode_srgb(colour.decode_srgb(values)), values, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(colour.decode_srgb(-values), -colour.decode_srgb(values))
    assert (np.diff(colour.decode_srgb(np.sort(values))) > 0).all()


def test_lab_goes_on_beyond_its_range():
    rgb = np.random.default_rng(0).uniform(-1, 3, (5000, 3))
    np.testing.assert_allclose(colour.srgb_of(colour.lab_of(rgb)), rgb, rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", ["rgb", "linear", "lab"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_every_integer_comes_back(name, dtype):
    """Each value in each channel, beside each corner of the other two, and among others at random."""
    full = np.iinfo(dtype).max
    ramp = np.arange(full + 1)
    pictures = [
        np.stack([ramp, ramp, ramp], axis=1),
        np.random.default_rng(0).integers(0, full + 1, (300_000, 3)),
    ]
    pictures += [
        np.insert(np.tile(others, (full + 1, 1)), channel, ramp, axis=1)
        for channel in range(3)
        for others in ((0, 0), (0, full), (full, 0), (full, full))
    ]
    stored = np.concatenate(pictures)
    space = spaces.named(name, np.dtype(dtype))
    working = space.to_working(stored.astype(np.float32))
    assert working.dtype == space.dtype
    assert np.abs(space.to_stored(working) - stored).max() < 0.25


@pytest.mark.parametrize("name", ["rgb", "linear", "lab"])
@pytest.mark.parametrize("dtype", DEPTHS)
def test_what_is_left_alone_comes_back_to_the_last_bit(name, dtype):
    space = spaces.named(name, np.dtype(dtype))
    stored = (
        (colours(500) * space.full * 1.5 - space.full / 4)
        .astype(dtype)
        .astype(np.result_type(dtype, np.float32))
    )
    before = space.to_working(stored.copy())
    np.testing.assert_array_equal(space.to_stored(before.copy(), before, stored), stored)


@pytest.mark.parametrize("make", [LogLuminance, LogChannels])
@pytest.mark.parametrize("name", ["rgb", "linear", "lab"])
@pytest.mark.parametrize("dtype", DEPTHS)
def test_an_unchanged_logarithm_leaves_the_last_bit(make, name, dtype):
    space = make(spaces.named(name, np.dtype(dtype)))
    stored = (colours(500) * space.full).astype(dtype).astype(np.result_type(dtype, np.float32))
    before = space.to_working(stored.copy())
    assert np.isfinite(before).all()
    np.testing.assert_array_equal(space.to_stored(before.copy(), before, stored), stored)


@pytest.mark.parametrize("name", ["linear", "lab"])
def test_an_error_of_a_level_there_is_at_most_a_level_here(name):
    """In all working values of a pixel at once, with any signs; and the bound is not generous by more than a fifth."""
    space = spaces.named(name, np.dtype(np.float64))
    rgb = colours(30_000)
    working = space.to_working(rgb)
    share = 1e-3  # so small that the curves are straight
    worst = 0.0
    for signs in np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T:
        moved = space.to_stored(working + share * space.level * signs)
        worst = max(worst, np.abs(moved - rgb).max() * 255 / share)
    assert 0.8 < worst <= 1 + 1e-9


@pytest.mark.parametrize("name", ["rgb", "linear", "lab"])
@pytest.mark.parametrize("make", [LogLuminance, LogChannels])
def test_an_error_of_a_level_of_a_logarithm_is_at_most_a_level_here(name, make):
    space = make(spaces.named(name, np.dtype(np.float64)))
    rgb = colours(30_000)
    logs = space.to_working(rgb)
    share = 1e-3
    for sign in (-1, 1):
        moved = space.to_stored(logs + sign * share * space.level, logs, rgb)
        assert np.abs(moved - rgb).max() * 255 <= share * (1 + 2 * share)


def test_a_logarithm_does_not_change_below_half_a_level():
    space = LogLuminance(spaces.named("rgb", np.dtype(np.uint8)))
    grey = np.array([-3.0, 0, 0.3, 0.5, 1], np.float32)[:, None, None] * np.ones(3, np.float32)
    np.testing.assert_allclose(space.to_working(grey).ravel(), np.log([0.5, 0.5, 0.5, 0.5, 1]), atol=1e-6)


def test_spaces_that_make_no_sense_are_refused():
    with pytest.raises(InputError, match="'rgb', 'linear', 'lab'"):
        spaces.named("hsv", np.dtype(np.uint8))
    with pytest.raises(InputError, match="the source has 2 channels"):
        spaces.named("lab", np.dtype(np.uint8)).check("source", 2)
    with pytest.raises(InputError, match="per_channel"):
        LogChannels(spaces.named("lab", np.dtype(np.uint8))).check("destination", 3)
    with pytest.raises(InputError, match="luminance"):
        LogLuminance(spaces.named("rgb", np.dtype(np.uint8))).check("destination", 4)
