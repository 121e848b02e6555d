"""Arguments that make no sense are refused with a message that says which, and why."""

import numpy as np
import pytest

from poisson_cli.editing import clone, fill, mix
from poisson_cli.errors import InputError, NotConverged, PoissonError
from tests.photographs import crop
from tests.regions import disk, lasso
from tests.tools import TOOLS, WITH_SOURCE

DESTINATION = crop("coffee.png", 40, 50, top=150)
SOURCE = crop("astronaut.png", 40, 50)
MASK = lasso(40, 50)


def test_an_input_error_is_a_value_error_too():
    assert issubclass(InputError, ValueError)
    assert issubclass(InputError, PoissonError) and InputError.exit_code == 3
    assert issubclass(NotConverged, PoissonError) and NotConverged.exit_code == 5


@pytest.mark.parametrize("tool", TOOLS)
def test_an_empty_mask(tool):
    with pytest.raises(InputError, match="empty|no pixel|selects nothing"):
        TOOLS[tool].edit(DESTINATION, SOURCE, np.zeros((40, 50), bool))


@pytest.mark.parametrize("tool", WITH_SOURCE)
@pytest.mark.parametrize("offset", [(-40, 0), (40, 0), (0, -50), (0, 50), (1000, -1000)], ids=str)
def test_a_mask_wholly_outside_the_destination(tool, offset):
    with pytest.raises(InputError, match="outside"):
        TOOLS[tool].edit(DESTINATION, SOURCE, MASK, offset=offset)


def test_a_mask_whose_selected_part_lies_outside():
    """The source overlaps the destination, what was selected of it does not."""
    mask = np.zeros((40, 50), bool)
    mask[:5] = True
    with pytest.raises(InputError, match="outside"):
        clone(DESTINATION, SOURCE, mask, offset=(-10, 0))


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("size", [(40, 49), (39, 50), (50, 40), (1, 1)], ids=str)
def test_a_mask_of_another_size_names_both_sizes(tool, size):
    with pytest.raises(InputError) as error:
        TOOLS[tool].edit(DESTINATION, SOURCE, np.ones(size, bool))
    for number in (*size, 40, 50):
        assert str(number) in str(error.value)


def test_a_mask_of_the_destinations_size_is_told_the_way_out():
    with pytest.raises(InputError, match="mask_on|mask-on"):
        clone(DESTINATION, SOURCE[:20, :20], MASK)


def test_a_mask_on_the_destination_must_have_its_size():
    with pytest.raises(InputError, match="destination"):
        clone(DESTINATION, SOURCE[:20, :20], MASK[:20, :20], mask_on="destination")


@pytest.mark.parametrize("tool", TOOLS)
def test_a_mask_that_is_a_colour_picture(tool):
    with pytest.raises(InputError, match="mask"):
        TOOLS[tool].edit(DESTINATION, SOURCE, np.ones((40, 50, 3), np.uint8))


@pytest.mark.parametrize("tool", TOOLS)
def test_a_mask_with_nan(tool):
    mask = MASK.astype(float)
    mask[0, 0] = np.nan
    with pytest.raises(InputError, match="mask"):
        TOOLS[tool].edit(DESTINATION, SOURCE, mask)


@pytest.mark.parametrize("tool", WITH_SOURCE)
@pytest.mark.parametrize("dtype", [np.uint16, np.float32, np.float64])
def test_pictures_of_different_depth(tool, dtype):
    with pytest.raises(InputError, match="uint8"):
        TOOLS[tool].edit(DESTINATION, SOURCE.astype(dtype), MASK)


@pytest.mark.parametrize(
    "dtype", [bool, np.int8, np.int16, np.int32, np.int64, np.uint32, np.float16, complex, object]
)
def test_depths_that_are_not_taken(dtype):
    with pytest.raises(InputError, match="uint8"):
        fill((DESTINATION // 64).astype(dtype), MASK)


@pytest.mark.parametrize("tool", ["clone", "average", "mix"])
def test_channels_that_do_not_fit(tool):
    with pytest.raises(InputError, match="channel"):
        TOOLS[tool].edit(DESTINATION, SOURCE[..., :2], MASK)
    with pytest.raises(InputError, match="channel"):
        TOOLS[tool].edit(DESTINATION[..., 0], SOURCE, MASK)


def test_a_colour_source_into_grey_is_told_about_monochrome():
    with pytest.raises(InputError, match="monochrome"):
        clone(DESTINATION[..., 0], SOURCE, MASK)


@pytest.mark.parametrize(
    "wrong", [SOURCE[0, :, 0], SOURCE[None], np.uint8(3), SOURCE[:0], SOURCE[:, :0], SOURCE[..., :0]]
)
def test_arrays_that_are_no_pictures(wrong):
    with pytest.raises(InputError):
        fill(wrong, MASK)
    with pytest.raises(InputError):
        clone(DESTINATION, wrong, MASK)
    with pytest.raises(InputError):
        clone(wrong, SOURCE, MASK)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("tool", ["clone", "mix"])
def test_pictures_that_are_not_finite(tool, dtype, bad):
    good, wrong = DESTINATION.astype(dtype) / 255, SOURCE.astype(dtype) / 255
    wrong[20, 25, 1] = bad
    for destination, source in ((wrong, good), (good, wrong)):
        with pytest.raises(InputError, match="(?i)finite|nan"):
            TOOLS[tool].edit(destination, source, MASK)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_fill_beside_a_value_that_is_not_finite(bad):
    image = DESTINATION / 255
    mask = np.zeros((40, 50), bool)
    mask[10:20, 10:20] = True
    image[9, 15, 0] = bad
    with pytest.raises(InputError, match="(?i)finite|nan"):
        fill(image, mask)


@pytest.mark.parametrize(
    ("option", "value"),
    [("gradients", "both"), ("mask_on", "nowhere"), ("solver", "jacobi"), ("cycle", "X")],
)
def test_a_choice_that_does_not_exist_is_named(option, value):
    with pytest.raises(ValueError, match=value):
        clone(DESTINATION, SOURCE, MASK, **{option: value})


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, np.inf])
@pytest.mark.parametrize("tool", TOOLS)
def test_a_tolerance_that_cannot_be_met(tool, tolerance):
    with pytest.raises(ValueError, match="tolerance"):
        TOOLS[tool].edit(DESTINATION, SOURCE, MASK, tolerance=tolerance)


@pytest.mark.parametrize("option", ["max_iterations", "threads"])
@pytest.mark.parametrize("value", [0, -1])
def test_counts_below_one(option, value):
    with pytest.raises(ValueError, match=option):
        clone(DESTINATION, SOURCE, MASK, **{option: value})


@pytest.mark.parametrize("offset", [(1,), (1, 2, 3), (1.5, 0), ("1", "2"), 7])
def test_an_offset_that_is_no_pair_of_integers(offset):
    with pytest.raises((ValueError, TypeError)):
        clone(DESTINATION, SOURCE, MASK, offset=offset)


@pytest.mark.parametrize("solver", ["multigrid", "sor"])
@pytest.mark.parametrize("tool", TOOLS)
def test_not_converged_is_an_error_and_no_picture(tool, solver):
    destination, source = crop("coffee.png", 150, 150), crop("astronaut.png", 150, 150)
    with pytest.raises(NotConverged, match="1 "):
        TOOLS[tool].edit(destination, source, disk(150, 150), solver=solver, max_iterations=1, tolerance=1e-7)


def test_mix_and_fill_take_no_options_of_clone():
    with pytest.raises(TypeError):
        mix(DESTINATION, SOURCE, MASK, gradients="average")
    with pytest.raises(TypeError):
        fill(DESTINATION, MASK, offset=(1, 1))
