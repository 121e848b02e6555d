"""The oracles of section 4 and of the colour spaces: against sums done by hand, closed forms, and scikit-image."""

import numpy as np
import pytest
from skimage import color

from tests import oracles, oracles_spaces, oracles_tools
from tests.oracles_spaces import SPACES
from tests.photographs import crop
from tests.regions import SHAPES, SMALL, disk, lasso

# --- colour spaces ----------------------------------------------------------------------------------


def every_colour() -> np.ndarray:
    """A lattice of colours with every 8-bit grey, (n, 3) in 0...1."""
    steps = np.linspace(0, 1, 18)
    lattice = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(-1, 3)
    return np.concatenate([lattice, np.repeat(np.arange(256)[:, None] / 255, 3, axis=1)])


@pytest.mark.parametrize("space", SPACES)
def test_there_and_back_is_the_identity(space):
    work, store = SPACES[space]
    np.testing.assert_allclose(store(work(every_colour())), every_colour(), atol=1e-12)


@pytest.mark.parametrize("space", SPACES)
def test_values_out_of_range_come_back_too(space):
    work, store = SPACES[space]
    beyond = 1.6 * every_colour() - 0.3
    np.testing.assert_allclose(store(work(beyond)), beyond, atol=1e-12)


def test_light_of_middle_grey_and_near_black():
    """sRGB 188 is close to half the light of white; below .04045 the curve is a line of slope 1 / 12.92."""
    np.testing.assert_allclose(oracles_spaces.linear_of_srgb(np.array(187.516 / 255)), 0.5, atol=1e-5)
    np.testing.assert_allclose(oracles_spaces.linear_of_srgb(np.array(0.03)), 0.03 / 12.92)


def test_lab_is_scikit_images():
    """Which has the matrix to six digits and not to four."""
    np.testing.assert_allclose(
        oracles_spaces.lab_of_srgb(every_colour()), color.rgb2lab(every_colour()), atol=0.03
    )


def test_white_black_and_grey_in_lab():
    lab = oracles_spaces.lab_of_srgb(np.array([[1, 1, 1], [0, 0, 0], [0.5, 0.5, 0.5]], float))
    np.testing.assert_allclose(lab, [[100, 0, 0], [0, 0, 0], [53.389, 0, 0]], atol=1e-3)


@pytest.mark.parametrize("space", SPACES)
def test_an_edit_in_any_space_leaves_the_outside_and_keeps_a_clone_onto_itself(space):
    picture, other = crop("chelsea.png", *SMALL), crop("coffee.png", *SMALL, top=150)
    mask = lasso(*SMALL)
    np.testing.assert_array_equal(oracles.clone(picture, other, mask, space=space)[~mask], picture[~mask])
    np.testing.assert_allclose(oracles.clone(picture, picture, mask, space=space), picture, atol=1e-9)


def test_a_fill_in_linear_light_is_a_fill_of_the_light():
    picture = crop("chelsea.png", *SMALL)
    light = oracles_spaces.linear_of_srgb(picture / 255)
    filled = oracles.fill(picture, disk(*SMALL), space="linear")
    np.testing.assert_allclose(
        oracles_spaces.linear_of_srgb(filled / 255), oracles.fill(light, disk(*SMALL)), atol=1e-12
    )


# --- screening --------------------------------------------------------------------------------------


def test_one_screened_unknown_by_hand():
    values = np.array([[9, 1, 9], [2, 0, 3], [9, 6, 9]], float)
    region = np.zeros((3, 3), bool)
    region[1, 1] = True
    zero = oracles.guidance(oracles.zero, values, values)
    towards = np.full((3, 3), 50.0)
    for by_loops in (False, True):
        solution = oracles.solve(region, values, *zero, screen=0.5, towards=towards, by_loops=by_loops)
        assert solution[1, 1] == pytest.approx((1 + 2 + 3 + 6 + 0.5 * 50) / 4.5)


@pytest.mark.parametrize("shape", ["lasso", "edge_touching", "everything"])
def test_a_weak_screen_is_none_and_a_strong_one_is_the_source(shape):
    destination, source = crop("coffee.png", *SMALL, top=150), crop("astronaut.png", *SMALL)
    mask = SHAPES[shape](*SMALL)
    if shape != "everything":
        weak = oracles.clone(destination, source, mask, screen=1e-9)
        np.testing.assert_allclose(weak, oracles.clone(destination, source, mask), atol=1e-4)
    strong = oracles.clone(destination, source, mask, screen=1e9)
    np.testing.assert_allclose(strong[mask], source[mask], atol=1e-4)


def test_a_screen_lets_the_mismatch_decay_from_the_rim():
    """On a line f - g falls by the factor t with t + 1/t = 2 + screen from one pixel to the next."""
    height, width, screen = 1, 80, 0.25
    mask = np.ones((height, width), bool)
    mask[:, 0] = False
    mismatch = oracles.clone(np.full((height, width), 40.0), np.zeros((height, width)), mask, screen=screen)
    factor = 1 + screen / 2 - np.sqrt((1 + screen / 2) ** 2 - 1)
    np.testing.assert_allclose(mismatch[0, :20], 40 * factor ** np.arange(20), rtol=1e-9)


# --- transforms and the tools made of them ----------------------------------------------------------


def test_a_sieve_keeps_pairs_that_touch_an_edge_pixel():
    edges = np.zeros((3, 4), int)
    edges[1, 2] = 7
    across, down = oracles_tools.sieve(edges)((np.ones((3, 3)), np.ones((2, 4))))
    np.testing.assert_array_equal(across, [[0, 0, 0], [0, 1, 1], [0, 0, 0]])
    np.testing.assert_array_equal(down, [[0, 0, 1, 0], [0, 0, 1, 0]])


@pytest.mark.parametrize("shape", ["lasso", "noise", "edge_touching"])
def test_flattening_between_all_and_nothing(shape):
    picture, mask = crop("coffee.png", *SMALL, top=150), SHAPES[shape](*SMALL)
    everywhere = oracles_tools.flatten(picture, mask, edges=np.ones(SMALL))
    np.testing.assert_allclose(everywhere, picture, atol=1e-9)
    nowhere = oracles_tools.flatten(picture, mask, edges=np.zeros(SMALL))
    np.testing.assert_allclose(nowhere, oracles.fill(picture, mask), atol=1e-9)


def test_a_flattened_step_keeps_its_height_where_the_edge_is():
    picture = np.array([[10, 11, 12, 50, 51, 52.0]])
    mask = np.array([[False, True, True, True, True, True]])
    flat = oracles_tools.flatten(picture, mask, edges=picture == 50)
    np.testing.assert_allclose(flat, [[10, 10, 10, 48, 49, 49]])


@pytest.mark.parametrize("amount", [0, 0.4, 1, 2.5])
def test_focus_is_the_membrane_and_so_many_times_what_is_beyond_it(amount):
    picture, mask = crop("chelsea.png", *SMALL), lasso(*SMALL)
    membrane = oracles.fill(picture, mask)
    exact = oracles_tools.focus(picture, mask, amount=amount)
    np.testing.assert_allclose(exact, membrane + amount * (picture - membrane), atol=1e-9)


def test_healing_takes_the_pixels_at_the_offset():
    rng = np.random.default_rng(0)
    picture = rng.uniform(0, 255, (12, 14))
    picture[6:, :] = picture[:6, :] + 30  # the lower half is the upper one, brighter
    mask = np.zeros((12, 14), bool)
    mask[2:4, 3:9] = True
    damaged = np.where(mask, 0, picture)
    np.testing.assert_allclose(oracles_tools.heal(damaged, mask, offset=(6, 0)), picture, atol=1e-9)


def test_a_background_without_colour_is_grey_and_rounded():
    picture, mask = crop("coffee.png", *SMALL, top=150), lasso(*SMALL)
    exact = oracles_tools.decolored(picture, mask)
    np.testing.assert_array_equal(exact[~mask], np.rint(oracles.grey(picture))[~mask][:, None].repeat(3, 1))
    assert np.abs(exact[mask] - picture[mask]).max() > 1


@pytest.mark.parametrize("axis", ["x", "y", "both"])
def test_tiled_sides_are_equal_and_corners_the_mean_of_four(axis):
    picture = crop("coffee.png", 30, 40, top=150)
    exact = oracles_tools.tile(picture, rect=(4, 5, 20, 24), axis=axis)
    g = picture[4:24, 5:29].astype(float)
    assert exact.shape == g.shape
    if axis != "y":
        np.testing.assert_array_equal(exact[:, 0], exact[:, -1])
        np.testing.assert_allclose(exact[5, 0], (g[5, 0] + g[5, -1]) / 2)
    if axis != "x":
        np.testing.assert_array_equal(exact[0], exact[-1])
    if axis == "both":
        np.testing.assert_allclose(exact[0, 0], (g[0, 0] + g[0, -1] + g[-1, 0] + g[-1, -1]) / 4)


def test_a_ramp_that_is_tiled_along_x_is_level():
    """Its sides meet in the middle, and what is left of the gradient is a line down: the sum of both is constant."""
    ramp = np.tile(np.arange(9.0), (4, 1))
    exact = oracles_tools.tile(ramp, axis="x")
    np.testing.assert_allclose(exact, np.full((4, 9), 4.0), atol=1e-12)


def test_what_repeats_already_stays():
    row, col = np.mgrid[:17, :25]
    picture = 100 + 40 * np.cos(2 * np.pi * row / 16) + 30 * np.sin(2 * np.pi * col / 24)
    np.testing.assert_allclose(oracles_tools.tile(picture), picture, atol=1e-9)
