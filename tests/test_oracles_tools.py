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


# --- outliers of the boundary -----------------------------------------------------------------------


def test_the_boundary_is_known_and_beside_the_region():
    region = np.zeros((4, 5), bool)
    region[1, 1:3] = True
    expected = np.zeros((4, 5), int)
    expected[0, 1:3] = expected[2, 1:3] = expected[1, [0, 3]] = 1
    np.testing.assert_array_equal(oracles.boundary(region), expected)


def test_winsorising_by_hand():
    """Distances from the median, 10: 1, 0, 1, 0, 90; their median is 1, and outliers begin at 4.4478."""
    mismatch = np.array([[9.0], [10], [11], [10], [100]])
    np.testing.assert_allclose(oracles.winsorised(mismatch, 1.0).ravel(), [9, 10, 11, 10, 14.4478])
    np.testing.assert_allclose(oracles.winsorised(mismatch, 20.0).ravel(), [9, 10, 11, 10, 30])


def test_winsorising_keeps_the_colour_of_a_mismatch():
    mismatch = np.array([[0.0, 0], [1, 1], [-1, -1], [0, 0], [40, 80]])
    np.testing.assert_allclose(oracles.winsorised(mismatch, 1.0)[-1], [0.5 * 4.4478, 4.4478])


# --- transforms and the tools made of them ----------------------------------------------------------


def test_a_sieve_keeps_pairs_that_touch_an_edge_pixel():
    edges = np.zeros((3, 4), int)
    edges[1, 2] = 7
    across, down = oracles_tools.sieve(edges)
    np.testing.assert_array_equal(across, [[0, 0, 0], [0, 1, 1], [0, 0, 0]])
    np.testing.assert_array_equal(down, [[0, 0, 1, 0], [0, 0, 1, 0]])


@pytest.mark.parametrize("size", [(9, 12, 3), (7, 8), (1, 6), (6, 1), (2, 2), (1, 1), (2, 5, 1)], ids=str)
def test_both_norms_agree(size):
    picture = np.random.default_rng(1).normal(size=size)
    for fast, slow in zip(
        oracles_tools.pair_norms(picture), oracles_tools.pair_norms_by_loops(picture), strict=True
    ):
        np.testing.assert_allclose(fast, slow, atol=1e-14)


@pytest.mark.parametrize("norms", [oracles_tools.pair_norms, oracles_tools.pair_norms_by_loops])
def test_the_norm_of_a_slope_is_the_same_on_every_pair(norms):
    row, col = np.mgrid[:7, :9]
    across, down = norms(3.0 * row - 4.0 * col)
    np.testing.assert_allclose(across, np.full((7, 8), 5))
    np.testing.assert_allclose(down, np.full((6, 9), 5))


def test_attenuation_by_hand():
    """Gradients of 4 and of 1 on a line, all in the region: their mean is 2, and a quarter of it is 1/2."""
    logarithm = np.array([[0.0, 4, 5, 6]])
    across, _ = oracles_tools.attenuation(logarithm, np.ones((1, 4), bool), alpha=0.25, beta=0.5)
    np.testing.assert_allclose(across, [[(0.5 / 4) ** 0.5, 0.5**0.5, 0.5**0.5]])


def test_a_gradient_that_is_as_large_as_a_stays():
    row, _ = np.mgrid[:9, :9]
    logarithm = 0.1 * row
    for factor in oracles_tools.attenuation(logarithm, disk(9, 9), alpha=1, beta=0.7):
        np.testing.assert_allclose(factor, 1)


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
    exact = oracles_tools.recolor(picture, mask, decolor_background=True)
    np.testing.assert_array_equal(exact[~mask], np.rint(oracles.grey(picture))[~mask][:, None].repeat(3, 1))
    assert np.abs(exact[mask] - picture[mask]).max() > 1


def test_a_luminance_that_is_a_half_is_rounded_to_the_even_number():
    colours = np.stack(np.meshgrid(*[np.arange(0, 256, 5, dtype=np.uint8)] * 3), axis=-1).reshape(-1, 3)
    whole, rest = np.divmod(colours.astype(int) @ [2126, 7152, 722], 10000)
    halves = rest == 5000
    assert halves.sum() > 10 and (whole[halves] % 2).any()
    grey = oracles_tools.stored_luminance(colours[halves][None])[0, :, 0]
    np.testing.assert_array_equal(grey, (whole + whole % 2)[halves])


def test_recolouring_turns_and_stretches_in_lab():
    picture = crop("coffee.png", *SMALL, top=150)
    before = color.rgb2lab(picture)
    after = color.rgb2lab(oracles_tools.recolored(picture / 255, (1, 1, 1), 90, 0.5))
    np.testing.assert_allclose(after[..., 0], before[..., 0], atol=0.1)
    np.testing.assert_allclose(after[..., 1], -before[..., 2] / 2, atol=0.1)
    np.testing.assert_allclose(after[..., 2], before[..., 1] / 2, atol=0.1)


def test_recolouring_by_nothing_is_the_picture():
    picture, mask = crop("coffee.png", *SMALL, top=150), lasso(*SMALL)
    np.testing.assert_allclose(oracles_tools.recolor(picture, mask), picture, atol=1e-9)
    np.testing.assert_allclose(oracles_tools.recolored(picture, (1, 1, 1), 360, 1), picture, atol=1e-9)


@pytest.mark.parametrize(
    ("space", "per_channel"),
    [("rgb", False), ("linear", False), ("lab", False), ("rgb", True), ("linear", True)],
)
def test_relighting(space, per_channel):
    """Nothing at beta = 0, also where the picture is black; a weaker contrast above it; colours keep their ratios."""
    picture, mask = crop("coffee.png", *SMALL, top=150).copy(), lasso(*SMALL)
    picture[10:13, 12:15] = 0
    same = oracles_tools.relight(picture, mask, beta=0, per_channel=per_channel, space=space)
    np.testing.assert_allclose(same, picture, atol=1e-9)
    exact = oracles_tools.relight(picture, mask, per_channel=per_channel, space=space)
    np.testing.assert_array_equal(exact[~mask], picture[~mask])
    np.testing.assert_allclose(exact[10:13, 12:15], 0, atol=1e-9)
    assert np.abs(exact - picture).max() > 2
    if space == "rgb" and not per_channel:
        colourful = mask & (picture.min(-1) > 0)
        ratio = exact[colourful] / picture[colourful]
        np.testing.assert_allclose(ratio[:, 1:], ratio[:, :1].repeat(2, 1), rtol=1e-9)


def test_relighting_by_hand():
    """One unknown among four equal neighbours a step s of the log away: its norms are all s, and alpha is 1."""
    picture = np.full((3, 3), 100.0)
    picture[1, 1] = 50
    mask = np.zeros((3, 3), bool)
    mask[1, 1] = True
    np.testing.assert_allclose(oracles_tools.relight(picture / 255, mask, alpha=1, beta=0.3) * 255, picture)
    halfway = oracles_tools.relight(picture / 255, mask, alpha=0.25, beta=0.5) * 255
    np.testing.assert_allclose(halfway[1, 1], 100 * np.sqrt(0.5))


@pytest.mark.parametrize("axis", ["x", "y", "both"])
def test_tiled_sides_are_equal_and_corners_the_mean_of_four(axis):
    picture = crop("coffee.png", 30, 40, top=150) / 255
    exact = oracles_tools.tile(picture, rect=(4, 5, 20, 24), axis=axis)
    g = picture[4:24, 5:29]
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


def test_sides_of_integers_are_integers():
    picture = crop("coffee.png", 30, 40, top=150)
    exact = oracles_tools.tile(picture, space="linear")
    np.testing.assert_array_equal(exact[0], np.rint(exact[0]))
    assert np.abs(exact[0] - (picture[0] / 2 + picture[-1] / 2)).max() > 1  # a mean of light, not of values


def test_what_repeats_already_stays():
    row, col = np.mgrid[:17, :25]
    picture = 100 + 40 * np.cos(2 * np.pi * row / 16) + 30 * np.sin(2 * np.pi * col / 24)
    np.testing.assert_allclose(oracles_tools.tile(picture), picture, atol=1e-9)


# --- into the range ---------------------------------------------------------------------------------


def test_a_colour_that_is_too_bright_fades_by_hand():
    """Luminance 115.2, of which red is 184.8 too far and 139.8 away from the end of the range."""
    colour = np.array([300.0, 65, 69])
    luminance = 0.2126 * 300 + 0.7152 * 65 + 0.0722 * 69
    faded = oracles_tools.desaturated(colour, 255)
    assert faded[0] == pytest.approx(255)
    share = (255 - luminance) / (300 - luminance)
    np.testing.assert_allclose(faded, luminance + share * (colour - luminance))
    assert oracles.grey(faded) == pytest.approx(luminance)


def test_colours_that_fit_stay_and_others_end_at_the_range():
    for colour in np.random.default_rng(0).uniform(-60, 320, (200, 3)):
        faded, luminance = oracles_tools.desaturated(colour, 255), oracles.grey(colour)
        if 0 <= luminance <= 255:
            assert faded.min() >= -1e-9 and faded.max() <= 255 + 1e-9
            inside = colour.min() >= 0 and colour.max() <= 255
            assert inside == np.allclose(faded, colour, atol=1e-9)
            assert inside or min(faded.min(), 255 - faded.max()) == pytest.approx(0, abs=1e-9)
        else:
            np.testing.assert_array_equal(faded, np.full(3, luminance))


def test_a_ramp_is_weakened_until_it_fits():
    region = np.ones((1, 5), bool)
    exact, scale = oracles_tools.fitted(
        lambda s: 100 + s * np.array([[0.0, -50, 200, 310, -100]]), region, 255
    )
    assert scale == pytest.approx(0.5)
    np.testing.assert_allclose(exact, [[100, 75, 200, 255, 50]], atol=1e-5)


# --- tone mapping -----------------------------------------------------------------------------------


def test_halving_and_doubling():
    np.testing.assert_allclose(
        oracles_tools.halved(np.arange(15.0).reshape(3, 5)), [[3, 5, 6.5], [10.5, 12.5, 14]]
    )
    np.testing.assert_allclose(oracles_tools.doubling(2) @ [4.0, 8.0], [4, 5, 7, 8])
    slope = np.add.outer(3.0 * np.arange(12), np.arange(10))
    rows, cols = (oracles_tools.doubling(n) for n in (6, 5))
    again = rows @ oracles_tools.halved(slope) @ cols.T
    np.testing.assert_allclose(again[1:-1, 1:-1], slope[1:-1, 1:-1])


@pytest.mark.parametrize("space", SPACES)
def test_tone_mapping_by_nothing_brings_white_to_white(space):
    picture = crop("rocket.jpg", 70, 75, top=200, left=240)
    picture = np.concatenate([picture, np.full((70, 1, 3), 255, np.uint8)], axis=1)
    same = oracles_tools.tonemap(picture, beta=0, saturation=1, white=100, space=space)
    np.testing.assert_allclose(same, picture, atol=1e-6)


def test_tone_mapping_brings_shadow_and_light_together():
    picture = crop("coffee.png", 100, 110, top=150) / 255
    picture[:, :55] *= 0.1

    def ratio(image):
        return np.median(image[:, 65:]) / np.median(image[:, :45])

    mapped = oracles_tools.tonemap(picture, black=0)
    assert mapped.min() >= 0 and mapped.max() <= 1
    assert ratio(mapped) < 0.7 * ratio(picture)


def test_a_slope_of_one_steepness_is_attenuated_evenly():
    """Far from the edges every norm is the same on every scale, but for the edges' share in the mean."""
    slope = np.add.outer(0.01 * np.arange(128), np.zeros(128))
    factor = oracles_tools.attenuation_on_all_scales(slope, 0.5, 0.3)
    inner = factor[20:-20, 20:-20]
    np.testing.assert_allclose(inner, inner[0, 0], rtol=1e-9)
    means = [
        (n - 1) / n for n in (128, 64, 32)
    ]  # at the first and the last row a central difference is half as large
    np.testing.assert_allclose(inner[0, 0], np.prod([(0.5 * mean) ** 0.3 for mean in means]))
