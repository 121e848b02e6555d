"""16 bit stays 16 bit, floats stay floats, any number of channels; the tolerance is in levels for all of them."""

import numpy as np
import pytest

from poisson_cli.editing import clone
from tests import oracles
from tests.agreement import LARGEST_ERROR, assert_rounded_right, assert_untouched, largest_error
from tests.photographs import crop
from tests.regions import SHAPES, lasso
from tests.tools import TOOLS

SIZE = (90, 101)
PIECES = (("coffee.png", 150), ("astronaut.png", 60))


def deep(name: str, top: int) -> np.ndarray:
    """A 16-bit picture that uses its lower byte too.

    That also keeps variations in two pictures from being equal but for their rounding, where `mix` may take either.
    """
    picture = crop(name, *SIZE, top=top).astype(np.uint16) * 257
    low = np.random.default_rng(top).integers(0, 256, picture.shape, dtype=np.uint16)
    return picture - np.minimum(picture, low)


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("shape", ["lasso", "edge_touching", "noise", "everything"])
def test_16_bit(tool, shape):
    """A level is 257 of its units: the picture is right within .01 level, about 2.6 units, not to the unit."""
    destination, source, mask = deep(*PIECES[0]), deep(*PIECES[1]), SHAPES[shape](*SIZE)
    image = TOOLS[tool].edit(destination, source, mask).image
    assert_untouched(image, destination, mask)
    exact = np.clip(TOOLS[tool].exact(destination, source, mask), 0, 65535)
    assert largest_error(image, exact, mask, 257.0) <= LARGEST_ERROR
    assert (image[mask] % 257 != 0).any()  # no 8-bit picture in disguise


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("dtype", [np.uint16, np.float32, np.float64])
def test_the_byte_order_of_a_picture_does_not_matter(tool, dtype):
    """FITS, TIFF and PNG hold the high byte first; who reads them by hand may leave it at that."""
    pictures = [(deep(*piece) / (1 if dtype == np.uint16 else 65535)).astype(dtype) for piece in PIECES]
    swapped = [picture.astype(picture.dtype.newbyteorder()) for picture in pictures]
    mask = SHAPES["lasso"](*SIZE)
    image = TOOLS[tool].edit(*swapped, mask).image
    assert image.dtype == dtype
    assert np.array_equal(image, TOOLS[tool].edit(*pictures, mask).image)


@pytest.mark.parametrize("tool", TOOLS)
def test_16_bit_with_a_tighter_tolerance_is_right_to_the_unit(tool):
    destination, source, mask = deep(*PIECES[0]), deep(*PIECES[1]), lasso(*SIZE)
    image = TOOLS[tool].edit(destination, source, mask, tolerance=1e-6).image
    assert_untouched(image, destination, mask)
    exact = np.clip(TOOLS[tool].exact(destination, source, mask), 0, 65535)
    assert largest_error(image, exact, mask, 1.0) <= 0.52


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", ["lasso", "edge_touching", "noise", "everything"])
def test_floats(tool, dtype, shape):
    destination, source = (deep(*piece).astype(dtype) / dtype(65535) for piece in PIECES)
    mask = SHAPES[shape](*SIZE)
    image = TOOLS[tool].edit(destination, source, mask).image
    assert_untouched(image, destination, mask)
    exact = TOOLS[tool].exact(destination, source, mask)
    assert largest_error(image, exact, mask, 1 / 255) <= LARGEST_ERROR


@pytest.mark.parametrize("tolerance", [1.0, 0.1, 1e-3, 1e-6])
@pytest.mark.parametrize("solver", ["multigrid", "sor"])
def test_the_tolerance_asked_for_is_kept(solver, tolerance):
    destination, source, mask = (
        crop("coffee.png", *SIZE) / 510 + 0.25,
        crop("chelsea.png", *SIZE) / 510,
        lasso(*SIZE),
    )
    edit = clone(destination, source, mask, solver=solver, tolerance=tolerance)
    exact = oracles.clone(destination, source, mask)
    assert largest_error(edit.image, exact, mask, 1 / 255) <= tolerance
    assert edit.report.tolerance == tolerance
    assert edit.report.error_estimate <= tolerance


@pytest.mark.parametrize("tool", ["clone", "average", "mix", "fill"])
@pytest.mark.parametrize("channels", [1, 2, 4, 6])
@pytest.mark.parametrize("dtype", [np.uint8, np.float64])
def test_any_number_of_channels(tool, channels, dtype):
    scale = oracles.full_scale(dtype) / 255
    rng = np.random.default_rng(channels)
    destination, source = (
        (scale * rng.integers(60, 190, (31, 34, channels))).astype(dtype) for _ in range(2)
    )
    mask = lasso(31, 34)
    image = TOOLS[tool].edit(destination, source, mask).image
    exact = TOOLS[tool].exact(destination, source, mask)
    if dtype is np.uint8:
        assert_rounded_right(image, destination, exact, mask)
    else:
        assert_untouched(image, destination, mask)
        assert largest_error(image, exact, mask, 1 / 255) <= LARGEST_ERROR


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_overshoot_is_clipped_never_wrapped(dtype):
    full = np.iinfo(dtype).max
    bright = np.full((21, 21), full, dtype)
    spot = np.zeros((21, 21), dtype)
    spot[8:13, 8:13] = full
    mask = np.zeros((21, 21), bool)
    mask[4:17, 4:17] = True
    assert clone(bright, spot, mask).image.min() == full
    assert clone(np.zeros_like(bright), full - spot, mask).image.max() == 0


def test_float_values_outside_the_region_may_be_anything_finite():
    """They are copied, whatever they are: beyond full scale, negative zero, denormal."""
    destination = crop("camera.png", 40, 40) / 255
    destination[0, :4] = (-0.0, 5.0, -3.0, 5e-324)
    mask = np.zeros((40, 40), bool)
    mask[10:30, 10:30] = True
    assert_untouched(TOOLS["fill"].edit(destination, destination, mask).image, destination, mask)
