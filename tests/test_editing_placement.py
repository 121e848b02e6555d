"""Where the source lies: offsets, overhang, masks up to an edge, masks of any size, on either picture."""

import numpy as np
import pytest

from poisson_cli.editing import clone, fill, mix
from tests import oracles
from tests.agreement import assert_rounded_right, assert_untouched
from tests.photographs import crop
from tests.regions import SHAPES, disk, lasso
from tests.tools import TOOLS, WITH_SOURCE

DESTINATION = crop("coffee.png", 60, 75, top=150)
SOURCE = crop("astronaut.png", 41, 52)

SIDES = {
    "above": (-20, 10),
    "below": (40, 10),
    "left": (10, -25),
    "right": (10, 50),
    "above left": (-20, -25),
    "above right": (-20, 50),
    "below left": (40, -25),
    "below right": (40, 50),
}


def region_on_destination(mask, offset, mask_on="source", source=SOURCE) -> np.ndarray:
    return oracles.region_of(mask, offset, DESTINATION.shape, mask_on, source.shape)


def assert_as_the_oracle(tool: str, mask: np.ndarray, source: np.ndarray = SOURCE, **placement) -> np.ndarray:
    exact = TOOLS[tool].exact(DESTINATION, source, mask, **placement)
    region = region_on_destination(
        mask, placement.get("offset", (0, 0)), placement.get("mask_on", "source"), source
    )
    image = TOOLS[tool].edit(DESTINATION, source, mask, **placement).image
    assert_rounded_right(image, DESTINATION, exact, region)
    return image


# --- the source on the destination ------------------------------------------------------------------


@pytest.mark.parametrize("tool", WITH_SOURCE)
@pytest.mark.parametrize("offset", [(0, 0), (7, 11), (8, 12), (19, 23), (1, 0), (0, 1)], ids=str)
def test_offsets_inside(tool, offset):
    assert_as_the_oracle(tool, lasso(41, 52), offset=offset)


@pytest.mark.parametrize("tool", WITH_SOURCE)
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("shape", ["disk", "everything", "noise"])
def test_overhang_is_clipped(tool, side, shape):
    assert_as_the_oracle(tool, SHAPES[shape](41, 52), offset=SIDES[side])


@pytest.mark.parametrize("tool", WITH_SOURCE)
def test_a_source_larger_than_the_destination_on_all_four_sides(tool):
    source = crop("astronaut.png", 120, 140)
    assert_as_the_oracle(tool, disk(120, 140), source, offset=(-30, -32))
    assert_as_the_oracle(tool, np.ones((120, 140), bool), source, offset=(-30, -32))


@pytest.mark.parametrize("tool", WITH_SOURCE)
def test_one_pixel_of_overlap(tool):
    for offset in ((-40, -51), (-40, 74), (59, -51), (59, 74)):
        mask = np.ones((41, 52), bool)
        assert region_on_destination(mask, offset).sum() == 1
        assert_as_the_oracle(tool, mask, offset=offset)


@pytest.mark.parametrize("height", [8, 9])
@pytest.mark.parametrize("width", [10, 11])
def test_an_odd_or_even_box_shifts_nothing(height, width):
    """Only the pixels selected may differ, and a source equal to the destination lands where it belongs."""
    source = DESTINATION[13 : 13 + height + 4, 17 : 17 + width + 4]
    mask = np.zeros(source.shape[:2], bool)
    mask[2:-2, 2:-2] = True
    image = clone(DESTINATION, source, mask, offset=(13, 17)).image
    np.testing.assert_array_equal(image, DESTINATION)
    report = clone(DESTINATION, source, mask, offset=(13, 17)).report
    assert report.rectangle == (15, 19, height, width)


def test_the_offset_may_be_any_kind_of_integer():
    mask = lasso(41, 52)
    expected = clone(DESTINATION, SOURCE, mask, offset=(3, -4)).image
    same = clone(DESTINATION, SOURCE, mask, offset=(np.int64(3), np.int32(-4))).image
    np.testing.assert_array_equal(same, expected)


# --- the mask up to the edges -----------------------------------------------------------------------


@pytest.mark.parametrize("tool", WITH_SOURCE)
@pytest.mark.parametrize("offset", [(0, 0), (9, 11), (19, 23), (-5, 30)], ids=str)
def test_the_whole_source_selected(tool, offset):
    """Pairs that leave the source have no source gradient; they count as zero."""
    assert_as_the_oracle(tool, np.ones((41, 52), bool), offset=offset)


@pytest.mark.parametrize("tool", WITH_SOURCE)
@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_of_mask_on_a_source_that_is_smaller(tool, shape):
    assert_as_the_oracle(tool, SHAPES[shape](41, 52), offset=(9, 11))


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("size", [(1, 1), (6, 6), (1, 9), (9, 1), (2, 2), (3, 3)], ids=str)
@pytest.mark.parametrize("corner", [(20, 20), (0, 0), (0, 30)], ids=["inside", "corner", "edge"])
def test_tiny_masks(tool, size, corner):
    """None is eroded away: every pixel selected is solved for."""
    source = crop("astronaut.png", 60, 75)
    mask = np.zeros((60, 75), bool)
    mask[corner[0] : corner[0] + size[0], corner[1] : corner[1] + size[1]] = True
    assert_as_the_oracle(tool, mask, source)
    report = TOOLS[tool].edit(DESTINATION, source, mask).report
    assert report.unknowns == size[0] * size[1]
    assert report.rectangle == (*corner, *size)


@pytest.mark.parametrize("tool", TOOLS)
def test_the_full_frame(tool):
    """Nothing is known: the gradients are the tool's, the mean stays the destination's, and the report says so."""
    source = crop("astronaut.png", 60, 75)
    mask = np.ones((60, 75), bool)
    assert_as_the_oracle(tool, mask, source)
    edit = TOOLS[tool].edit(DESTINATION / 255, source / 255, mask)
    assert edit.report.floating
    np.testing.assert_allclose(edit.image.mean((0, 1)), DESTINATION.mean((0, 1)) / 255, atol=2e-6)


def test_filling_everything_gives_the_mean():
    image = fill(DESTINATION, np.ones((60, 75), bool)).image
    exact = DESTINATION.mean((0, 1))
    assert np.abs(image - exact).max() <= 0.51


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("size", [(1, 30), (30, 1), (2, 30), (30, 2), (1, 2)], ids=str)
def test_pictures_one_or_two_pixels_wide(tool, size):
    destination, source = crop("coffee.png", *size, top=150), crop("astronaut.png", *size)
    mask = np.ones(size, bool)
    mask[0, 0] = False
    exact = TOOLS[tool].exact(destination, source, mask)
    assert_rounded_right(TOOLS[tool].edit(destination, source, mask).image, destination, exact, mask)


# --- the mask itself --------------------------------------------------------------------------------


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("dtype", [bool, np.uint8, np.int32, np.float64])
def test_a_mask_selects_where_it_is_not_zero(tool, dtype):
    source = crop("astronaut.png", 60, 75)
    selected = lasso(60, 75)
    mask = selected.astype(dtype) * dtype(1)
    if dtype is not bool:
        mask[selected] += (
            np.arange(selected.sum()).astype(np.uint8).astype(dtype) % 3
        )  # 1, 2 and 3: all of them select
    expected = TOOLS[tool].edit(DESTINATION, source, selected).image
    np.testing.assert_array_equal(TOOLS[tool].edit(DESTINATION, source, mask).image, expected)


@pytest.mark.parametrize("tool", WITH_SOURCE)
@pytest.mark.parametrize("offset", [(0, 0), (9, 11), (-10, 30)], ids=str)
def test_a_mask_that_lies_on_the_destination(tool, offset):
    """The same selection, given on the one picture or on the other, gives the same bytes."""
    mask = lasso(41, 52)
    on_destination = region_on_destination(mask, offset)
    image = assert_as_the_oracle(tool, on_destination, offset=offset, mask_on="destination")
    same = TOOLS[tool].edit(DESTINATION, SOURCE, mask, offset=offset).image
    np.testing.assert_array_equal(image, same)


@pytest.mark.parametrize("tool", WITH_SOURCE)
def test_a_mask_on_the_destination_is_not_moved_by_the_offset(tool):
    mask = np.zeros((60, 75), bool)
    mask[20:30, 25:45] = True
    for offset in ((9, 11), (12, 15)):
        report = TOOLS[tool].edit(DESTINATION, SOURCE, mask, offset=offset, mask_on="destination").report
        assert report.rectangle == (20, 25, 10, 20)


# --- the caller's arrays ----------------------------------------------------------------------------


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_no_argument_is_modified(tool, dtype):
    scale = oracles.full_scale(dtype) / 255
    arrays = [(crop(name, 60, 75) * scale).astype(dtype) for name in ("coffee.png", "astronaut.png")]
    arrays.append(lasso(60, 75).astype(np.uint8) * 255)
    originals = [array.copy() for array in arrays]
    placement = {"offset": (2, 3)} if TOOLS[tool].takes_source else {}
    image = TOOLS[tool].edit(*arrays, **placement).image
    for array, original in zip(arrays, originals, strict=True):
        np.testing.assert_array_equal(array, original)
        assert not np.shares_memory(image, array)


@pytest.mark.parametrize("tool", TOOLS)
def test_arrays_of_any_layout_are_taken(tool):
    destination, source, mask = DESTINATION, crop("astronaut.png", 60, 75), lasso(60, 75)
    expected = TOOLS[tool].edit(destination, source, mask).image
    for layout in (
        np.asfortranarray,
        lambda a: a[::-1].copy()[::-1],
        lambda a: np.repeat(a, 2, axis=1)[:, ::2],
    ):
        image = TOOLS[tool].edit(layout(destination), layout(source), layout(mask)).image
        np.testing.assert_array_equal(image, expected)


# --- onto itself ------------------------------------------------------------------------------------


@pytest.mark.parametrize("tool", ["clone", "average", "mix"])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_picture_put_onto_itself_is_the_same_bytes(tool, shape):
    picture = crop("chelsea.png", 60, 75)
    image = TOOLS[tool].edit(picture, picture, SHAPES[shape](60, 75)).image
    assert image.tobytes() == picture.tobytes()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("solver", ["multigrid", "sor"])
def test_onto_itself_with_every_solver_and_integer_type(dtype, solver):
    picture = (crop("rocket.jpg", 60, 75) * (oracles.full_scale(dtype) / 255)).astype(dtype)
    image = clone(picture, picture, lasso(60, 75), solver=solver).image
    assert image.tobytes() == picture.tobytes()


def test_onto_itself_over_a_whole_photograph():
    picture = crop("astronaut.png", 400, 400)
    assert clone(picture, picture, disk(400, 400)).image.tobytes() == picture.tobytes()
    assert mix(picture, picture, disk(400, 400)).image.tobytes() == picture.tobytes()


def test_a_clone_of_a_clone_is_the_clone():
    """What lay under the selection has no say: only the boundary has, and that is still the same."""
    source = crop("astronaut.png", 60, 75) // 2 + 64
    destination = crop("coffee.png", 60, 75, top=150) // 2 + 64
    once = clone(destination, source, lasso(60, 75)).image
    twice = clone(once, source, lasso(60, 75)).image
    np.testing.assert_array_equal(once, twice)
    assert_untouched(twice, destination, lasso(60, 75))
