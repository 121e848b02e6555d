"""What holds for every picture and every mask, for the tools beyond cloning, looked for with hypothesis.

As in `test_editing_properties` the pictures are small, and floats unless rounding is the question.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from poisson_cli import editing
from poisson_cli.editing.transforms import Attenuate, Scale, Sieve
from tests import oracles, oracles_spaces, oracles_tools
from tests.agreement import assert_untouched
from tests.photographs import crop
from tests.regions import SHAPES, lasso

LEVEL = 1 / 255
TOLERANCE = 5e-4  # levels, asked for by name, so that the slack of a comparison is known
SLACK = 2.1 * TOLERANCE * LEVEL
SPACES = ("rgb", "linear", "lab")
DEPTHS = (np.uint8, np.uint16, np.float32, np.float64)

checked = settings(max_examples=25, deadline=None, derandomize=True)


@st.composite
def scenes(draw: st.DrawFn, *, smallest: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """A colour picture with values from .1 to .9, and a mask that selects something."""
    height, width = draw(st.integers(smallest, 16)), draw(st.integers(smallest, 16))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    mask = rng.random((height, width)) < draw(st.sampled_from([0.1, 0.5, 0.97]))
    assume(mask.any())
    return rng.uniform(0.1, 0.9, (height, width, 3)), mask


def of_depth(picture: np.ndarray, dtype: Any) -> np.ndarray:
    """A picture of floats, full scale 1, in another depth."""
    scaled = picture * oracles.full_scale(dtype)
    return scaled.astype(dtype) if np.dtype(dtype).kind == "f" else np.rint(scaled).astype(dtype)


def some_edges(mask: np.ndarray) -> np.ndarray:
    row, col = np.indices(mask.shape)
    return (row + 2 * col) % 5 == 0


def edited(tool: str, picture: np.ndarray, mask: np.ndarray, **options: Any) -> np.ndarray:
    """The tool with options that change the picture."""
    strong: dict[str, Any] = {
        "fill": {},
        "flatten": {"edges": some_edges(mask)},
        "relight": {"beta": 0.5},
        "recolor": {"gain": (1.2, 0.8, 0.6), "hue": 30.0},
        "focus": {"amount": 0.6},
    }[tool]
    return getattr(editing, tool)(picture, mask, **{**strong, **options}).image


IN_PLACE = ("fill", "flatten", "relight", "recolor", "focus")
every_tool = pytest.mark.parametrize("tool", IN_PLACE)
every_space = pytest.mark.parametrize("space", SPACES)
every_depth = pytest.mark.parametrize("dtype", DEPTHS)

# --- what changes nothing ---------------------------------------------------------------------------

NOTHING: dict[str, Any] = {
    "flatten with every edge": lambda picture, mask, **more: editing.flatten(
        picture, mask, edges=np.ones(mask.shape), **more
    ),
    "relight with beta 0": lambda *given, **more: editing.relight(*given, beta=0.0, **more),
    "recolor with gain 1": lambda *given, **more: editing.recolor(*given, gain=(1, 1, 1), **more),
    "focus with amount 1": lambda *given, **more: editing.focus(*given, amount=1.0, **more),
    "clone onto itself": lambda picture, *given, **more: editing.clone(picture, picture, *given, **more),
    "clone onto itself, screened": lambda picture, *given, **more: editing.clone(
        picture, picture, *given, screen=0.1, **more
    ),
    "clone onto itself, robust": lambda picture, *given, **more: editing.clone(
        picture, picture, *given, robust=True, **more
    ),
    "clone onto itself, scaled by 1": lambda picture, *given, **more: editing.clone(
        picture, picture, *given, then=[Scale(1.0), Attenuate(beta=0.0)], **more
    ),
}


@every_depth
@every_space
@pytest.mark.parametrize("how", NOTHING)
@pytest.mark.parametrize("shape", ["lasso", "edge_touching", "everything"])
def test_the_identity_is_the_same_bytes(how, shape, space, dtype):
    picture = of_depth(crop("coffee.png", 40, 50, top=150) / 255, dtype)
    image = NOTHING[how](picture, SHAPES[shape](40, 50), space=space).image
    assert image.dtype == picture.dtype
    assert image.tobytes() == picture.tobytes()


@pytest.mark.parametrize("how", NOTHING)
@checked
@given(scene=scenes(), space=st.sampled_from(SPACES), dtype=st.sampled_from(DEPTHS))
def test_the_identity_whatever_the_picture(how, scene, space, dtype):
    picture, mask = of_depth(scene[0], dtype), scene[1]
    assert NOTHING[how](picture, mask, space=space).image.tobytes() == picture.tobytes()


@pytest.mark.parametrize("tool", ["flatten", "focus"])
@checked
@given(scene=scenes())
def test_without_any_gradient_a_tool_is_the_membrane(tool, scene):
    picture, mask = scene
    none = {"edges": np.zeros(mask.shape)} if tool == "flatten" else {"amount": 0.0}
    image = edited(tool, picture, mask, **none, tolerance=TOLERANCE)
    assert np.abs(image - editing.fill(picture, mask, tolerance=TOLERANCE).image).max() <= SLACK


# --- what stays as it was ---------------------------------------------------------------------------


@every_tool
@checked
@given(scene=scenes(), space=st.sampled_from(SPACES), dtype=st.sampled_from(DEPTHS))
def test_outside_the_selection_not_a_bit_changes(tool, scene, space, dtype):
    picture, mask = of_depth(scene[0], dtype), scene[1]
    before = picture.copy()
    assert_untouched(edited(tool, picture, mask, space=space), picture, mask)
    assert picture.tobytes() == before.tobytes()


@every_depth
@every_space
def test_a_background_without_colour_is_the_luminance_exactly(space, dtype):
    picture, mask = of_depth(crop("coffee.png", 40, 50, top=150) / 255, dtype), lasso(40, 50)
    image = editing.recolor(picture, mask, decolor_background=True, space=space).image
    expected = oracles_tools.stored_luminance(picture)
    if np.dtype(dtype).kind == "u":
        assert_untouched(image, expected, mask)
    else:
        np.testing.assert_array_equal(image[~mask][:, :2], image[~mask][:, 1:])
        np.testing.assert_allclose(image[~mask], expected[~mask], rtol=4 * np.finfo(dtype).eps)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_the_luminance_of_every_colour_is_rounded_right(dtype):
    colours = np.random.default_rng(0).integers(0, np.iinfo(dtype).max + 1, (600, 900, 3)).astype(dtype)
    mask = np.zeros((600, 900), bool)
    mask[0, 0] = True
    image = editing.recolor(colours, mask, decolor_background=True).image
    assert_untouched(image, oracles_tools.stored_luminance(colours), mask)


@pytest.mark.parametrize("beta", [0.2, 0.9, -0.4, -1.0])
@pytest.mark.parametrize("per_channel", [False, True])
@every_depth
def test_relighting_black_stays_black_and_every_value_a_number(dtype, per_channel, beta):
    picture = of_depth(crop("rocket.jpg", 40, 50) / 255, dtype)
    picture[5:30, 10:20] = 0
    with np.errstate(all="raise", under="ignore"):
        image = editing.relight(picture, lasso(40, 50), beta=beta, per_channel=per_channel).image
    assert np.isfinite(image).all()
    assert (image[picture == 0] == 0).all()


def test_relighting_negative_values_gives_numbers():
    picture = crop("rocket.jpg", 40, 50) / 255 - 0.2
    image = editing.relight(picture, lasso(40, 50)).image
    assert np.isfinite(image).all()
    assert_untouched(image, picture, lasso(40, 50))


# --- what commutes ----------------------------------------------------------------------------------


@every_tool
@every_space
@checked
@given(scene=scenes())
def test_flips_and_transposition_commute_with_editing(space, tool, scene):
    picture, mask = scene
    for turn in (np.flipud, np.fliplr, lambda array: np.swapaxes(array, 0, 1)):
        options = {"edges": turn(some_edges(mask))} if tool == "flatten" else {}
        there = edited(tool, turn(picture), turn(mask), space=space, tolerance=TOLERANCE, **options)
        here = turn(edited(tool, picture, mask, space=space, tolerance=TOLERANCE))
        assert np.abs(there - here).max() <= SLACK


@pytest.mark.parametrize("tool", ["flatten", "focus"])
@checked
@given(scene=scenes(), gain=st.floats(0.2, 1.5), shift=st.floats(-1, 1))
def test_a_change_of_exposure_commutes_with_what_is_linear(tool, scene, gain, shift):
    picture, mask = scene
    before = edited(tool, gain * picture + shift, mask, tolerance=TOLERANCE)
    after = gain * edited(tool, picture, mask, tolerance=TOLERANCE) + shift
    assert np.abs(before - after).max() <= (1 + gain) * TOLERANCE * LEVEL * 1.05


@checked
@given(scene=scenes(), amount=st.floats(0, 3))
def test_focus_is_linear_in_its_amount(scene, amount):
    """Of the picture, what is beyond the membrane is multiplied."""
    picture, mask = scene
    assume(not mask.all())
    membrane = editing.fill(picture, mask, tolerance=TOLERANCE).image
    image = editing.focus(picture, mask, amount=amount, tolerance=TOLERANCE).image
    expected = membrane + amount * (picture - membrane)
    assert np.abs(image - expected)[mask].max() <= (2.1 + amount) * TOLERANCE * LEVEL


@checked
@given(scene=scenes(), gain=st.floats(0.3, 1.1))
def test_relighting_does_not_depend_on_the_exposure(scene, gain):
    """A factor adds to the logarithm everywhere, and so to the new one."""
    picture, mask = scene
    before = editing.relight(gain * picture, mask, tolerance=TOLERANCE).image
    after = gain * editing.relight(picture, mask, tolerance=TOLERANCE).image
    assert np.abs(before - after).max() <= (1 + gain) * TOLERANCE * LEVEL * 1.05


@checked
@given(scene=scenes(), gains=st.tuples(*[st.floats(0.3, 1.1)] * 3))
def test_relighting_each_channel_does_not_depend_on_the_balance(scene, gains):
    picture, mask = scene
    before = editing.relight(picture * gains, mask, per_channel=True, tolerance=TOLERANCE).image
    after = gains * editing.relight(picture, mask, per_channel=True, tolerance=TOLERANCE).image
    assert np.abs(before - after).max() <= 2.1 * TOLERANCE * LEVEL * 1.05


@checked
@given(scene=scenes(), screens=st.tuples(st.floats(1e-3, 1), st.floats(2, 9)))
def test_the_stronger_the_screen_the_nearer_the_source(scene, screens):
    picture, mask = scene
    assume(not mask.all())
    source = np.roll(picture, 1, axis=0)[..., ::-1].copy()
    weak, strong = (
        editing.clone(picture, source, mask, screen=screens[0] * factor, tolerance=TOLERANCE).image
        for factor in (1, screens[1])
    )
    far, near = (np.abs(image - source)[mask].max() for image in (weak, strong))
    assert near <= far + SLACK


# --- depths -----------------------------------------------------------------------------------------


@every_tool
@every_space
def test_every_depth_is_the_same_picture(tool, space):
    picture, mask = crop("coffee.png", 40, 50, top=150), lasso(40, 50)
    exact = edited(tool, picture / 255, mask, space=space)
    for dtype in DEPTHS:
        image = edited(tool, of_depth(picture / 255, dtype), mask, space=space)
        full = oracles.full_scale(dtype)
        assert image.dtype == dtype
        rounding = 0.5 / full if np.dtype(dtype).kind == "u" else 0
        expected = np.clip(exact, 0, 1) if rounding else exact
        assert np.abs(image / full - expected).max() <= rounding + 0.01 * LEVEL


# --- chains -----------------------------------------------------------------------------------------


@checked
@given(scene=scenes(), amount=st.floats(0, 3))
def test_editing_the_import_of_itself_is_editing_in_place(scene, amount):
    picture, mask = scene
    edges = some_edges(mask)
    pairs = [
        ([Sieve(edges)], editing.flatten(picture, mask, edges=edges, tolerance=TOLERANCE)),
        ([Scale(amount)], editing.focus(picture, mask, amount=amount, tolerance=TOLERANCE)),
    ]
    for then, expected in pairs:
        image = editing.clone(picture, picture, mask, then=then, tolerance=TOLERANCE).image
        assert np.abs(image - expected.image).max() <= SLACK


@checked
@given(scene=scenes(), first=st.floats(0.2, 2), second=st.floats(0.2, 2))
def test_scales_in_a_chain_multiply_and_the_order_does_not_matter(scene, first, second):
    picture, mask = scene
    source, edges = picture[::-1].copy(), some_edges(mask)
    one = [Scale(first), Sieve(edges), Scale(second)]
    other = [Sieve(edges), Scale(first * second)]
    images = [
        editing.clone(picture, source, mask, then=then, tolerance=TOLERANCE).image for then in (one, other)
    ]
    assert np.abs(images[0] - images[1]).max() <= SLACK


# --- tiling -----------------------------------------------------------------------------------------


@every_space
@every_depth
def test_a_picture_whose_sides_are_equal_already_comes_back_identical(dtype, space):
    picture = of_depth(crop("coffee.png", 40, 50, top=150) / 255, dtype)
    picture[-1], picture[:, -1] = picture[0], picture[:, 0]
    picture[-1, -1] = picture[0, -1] = picture[-1, 0] = picture[0, 0]
    for axis in ("both", "x", "y"):
        image = editing.tile(picture, axis=axis, space=space).image
        assert image.dtype == dtype
        assert image.tobytes() == picture.tobytes()


@checked
@given(scene=scenes(smallest=3), axis=st.sampled_from(["both", "x", "y"]), space=st.sampled_from(SPACES))
def test_a_tile_s_opposite_sides_are_equal_and_tiling_it_again_changes_nothing(scene, axis, space):
    picture = of_depth(scene[0], np.uint8)
    once = editing.tile(picture, axis=axis, space=space).image
    if axis != "y":
        np.testing.assert_array_equal(once[:, 0], once[:, -1])
    if axis != "x":
        np.testing.assert_array_equal(once[0], once[-1])
    np.testing.assert_array_equal(editing.tile(once, axis=axis, space=space).image, once)


@pytest.mark.parametrize("name", ["coffee.png", "chelsea.png", "astronaut.png"])
@every_space
def test_a_seam_is_no_rougher_than_the_interior(space, name):
    """In every row, and every column, as one goes over from the last pixel to the first.

    The pairs beside the seam keep a little of the two sides' difference, where these do not look alike, but less than
    the picture shows that is laid out as it is.
    """
    picture = crop(name, 120, 160)
    image = editing.tile(picture, space=space).image
    for before, after in (
        (picture.astype(float), image.astype(float)),
        (np.swapaxes(picture, 0, 1).astype(float), np.swapaxes(image, 0, 1).astype(float)),
    ):
        interior = np.abs(np.diff(after, axis=1)).mean(axis=(1, 2))
        assert (np.abs(after[:, 0] - after[:, -1]).mean(axis=1) <= 1.2 * interior).all()
        beside = np.abs(np.stack([after[:, 1] - after[:, 0], after[:, -1] - after[:, -2]])).mean()
        assert beside <= 0.5 * np.abs(before[:, 0] - before[:, -1]).mean()


def test_a_rectangle_is_the_crop_tiled():
    picture = crop("coffee.png", 60, 70, top=150)
    image = editing.tile(picture, rect=(7, 9, 40, 50)).image
    np.testing.assert_array_equal(image, editing.tile(picture[7:47, 9:59]).image)


# --- healing ----------------------------------------------------------------------------------------


@checked
@given(offset=st.tuples(st.integers(-8, 8), st.integers(-8, 8)), space=st.sampled_from(SPACES))
def test_healing_from_an_offset_is_a_clone_from_there(offset, space):
    picture = crop("coffee.png", 40, 50, top=150)
    mask = np.zeros((40, 50), bool)
    mask[12:25, 14:33] = lasso(13, 19)
    away = (-offset[0], -offset[1])
    expected = editing.clone(picture, picture, mask, offset=away, mask_on="destination", space=space).image
    np.testing.assert_array_equal(editing.heal(picture, mask, offset=offset, space=space).image, expected)


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize("shift", [0.0, 0.15])
def test_healing_finds_the_one_place_that_fits(dtype, shift):
    """A piece of texture stands in the picture twice, once lighter: nothing else fits as well as the other one."""
    picture = crop("coffee.png", 90, 120, top=150) / 255 * 0.8
    picture[50:80, 70:100] = picture[10:40, 12:42] + shift
    mask = np.zeros((90, 120), bool)
    mask[60:70, 80:90] = True
    truth, damaged = of_depth(picture, dtype), of_depth(picture, dtype)
    damaged[mask] = 0
    edit = editing.heal(damaged, mask)
    assert edit.report.offset == (-40, -58)
    assert np.abs(edit.image.astype(float) - truth).max() <= 2 * oracles.full_scale(dtype) / 255
    assert_untouched(edit.image, damaged, mask)
    again = editing.heal(damaged, mask)
    assert again.report.offset == edit.report.offset and again.image.tobytes() == edit.image.tobytes()


# --- tone mapping -----------------------------------------------------------------------------------


@every_space
@every_depth
def test_tone_mapping_fills_the_range_and_stays_in_it(dtype, space):
    picture = of_depth(crop("rocket.jpg", 70, 81, top=200, left=240) / 255, dtype)
    before = picture.copy()
    image = editing.tonemap(picture, space=space).image
    assert image.dtype == dtype and image.shape == picture.shape
    full = oracles.full_scale(dtype)
    assert 0 <= image.min() <= 0.05 * full
    assert 0.95 * full <= image.max() <= full
    assert picture.tobytes() == before.tobytes()


@pytest.mark.parametrize("exposure", [1e-4, 0.3, 50.0])
@pytest.mark.parametrize("space", ["rgb", "linear"])
def test_tone_mapping_does_not_depend_on_the_exposure_of_floats(space, exposure):
    """A factor on the values as stored, or on the light.  (On L* there is none.)"""
    picture = 0.05 + crop("rocket.jpg", 70, 81, top=200, left=240) / 255
    if space == "rgb":
        image, exposed = (
            editing.tonemap(p, tolerance=TOLERANCE).image for p in (picture, exposure * picture)
        )
    else:
        light = oracles_spaces.linear_of_srgb(picture)
        darker = oracles_spaces.srgb_of_linear(exposure * light)
        image, exposed = (
            editing.tonemap(p, space="linear", tolerance=TOLERANCE).image for p in (picture, darker)
        )
    assert np.abs(image - exposed).max() <= 0.01 * LEVEL


@every_space
def test_tone_mapping_commutes_with_flips_of_sizes_that_can_be_halved(space):
    picture = crop("coffee.png", 64, 128, top=150) / 255
    plain = editing.tonemap(picture, space=space, tolerance=TOLERANCE).image
    for turn in (np.flipud, np.fliplr, lambda array: np.swapaxes(array, 0, 1)):
        turned = editing.tonemap(turn(picture), space=space, tolerance=TOLERANCE).image
        assert np.abs(turned - turn(plain)).max() <= 2 * SLACK


@every_space
def test_tone_mapping_by_nothing_keeps_a_picture_that_has_black_and_white(space):
    picture = crop("coffee.png", 70, 81, top=150) / 255
    picture[3, 4], picture[5, 6] = 0, 1
    nothing = {"beta": 0.0, "saturation": 1.0, "black": 0.0, "white": 100.0, "floor": 1e-7}
    image = editing.tonemap(picture, **nothing, space=space).image
    assert np.abs(image - picture).max() <= 0.01 * LEVEL


def test_one_colour_is_tone_mapped_to_white():
    for value in (1, 100, 255):
        picture = np.full((40, 50, 3), value, np.uint8)
        assert (editing.tonemap(picture).image == 255).all()
