"""Parameters of the tools that make no sense are refused with a message that says which, and what they may be."""

import numpy as np
import pytest

from poisson_cli.editing import (
    Attenuate,
    Scale,
    clone,
    fill,
    flatten,
    focus,
    heal,
    mix,
    recolor,
    relight,
    tile,
    tonemap,
)
from poisson_cli.errors import InputError
from tests.photographs import crop
from tests.regions import disk, lasso

PICTURE = crop("coffee.png", 40, 50, top=150)
GREY = crop("camera.png", 40, 50)
TWO = PICTURE[:, :, :2]
MASK = lasso(40, 50)
SMALL = np.zeros((40, 50), bool)
SMALL[20:30, 20:30] = disk(10, 10)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: clone(PICTURE, PICTURE, MASK, screen=-1.0), "screen is -1"),
        (lambda: mix(PICTURE, PICTURE, MASK, screen=np.nan), "screen is nan"),
        (lambda: heal(PICTURE, SMALL, screen=np.inf), "screen is inf"),
        (lambda: clone(PICTURE, PICTURE, MASK, then=[Scale(-0.5)]), "amount is -0.5"),
        (lambda: clone(PICTURE, PICTURE, MASK, then=[Attenuate(alpha=0)]), "alpha is 0"),
        (lambda: focus(PICTURE, MASK, amount=np.inf), "amount is inf"),
        (lambda: relight(PICTURE, MASK, alpha=-0.2), "alpha is -0.2"),
        (lambda: relight(PICTURE, MASK, beta=1.5), "beta is 1.5.*from -1 to 1"),
        (lambda: relight(PICTURE, MASK, beta=-1.5), "beta is -1.5.*from -1 to 1"),
        (lambda: relight(PICTURE, MASK, alpha=1e4), "alpha is 10000.*above 0 and at most 1000"),
        (lambda: focus(PICTURE, MASK, amount=1e6), "amount is 1000000.*from 0 to 1000"),
        (lambda: relight(PICTURE, MASK, per_channel=True, space="lab"), "per_channel needs"),
        (lambda: clone(GREY, GREY, MASK, then=[Attenuate()], space="lab"), "CIE-Lab.*1 channel:"),
        (lambda: mix(TWO, TWO, MASK, then=[Attenuate()]), "luminance needs.*2 channels"),
        (lambda: relight(PICTURE[:, :, :2], MASK), "2 channels"),
        (lambda: recolor(PICTURE, MASK, gain=(1, 1)), "gain is .* three numbers"),
        (lambda: recolor(PICTURE, MASK, gain=(1, -1, 1)), "gain is"),
        (lambda: recolor(PICTURE, MASK, gain=(1, 1001, 1)), "gain is .* from 0 to 1000"),
        (lambda: recolor(PICTURE, MASK, gain=(1, np.nan, 1)), "gain is"),
        (lambda: recolor(PICTURE, MASK, hue=np.nan), "hue is nan"),
        (lambda: recolor(PICTURE, MASK, saturation=-1), "saturation is -1"),
        (lambda: recolor(GREY, MASK), "red, green and blue.*1 channel$"),
        (lambda: recolor(PICTURE[:, :, :2], MASK), "2 channels$"),
        (lambda: fill(GREY, MASK, space="lab"), "CIE-Lab.*1 channel:"),
        (lambda: clone(PICTURE, PICTURE, MASK, space="hsv"), "space is 'hsv'"),
        (lambda: tile(PICTURE, axis="z"), "axis is 'z'"),
        (lambda: tile(PICTURE, rect=(0, 0, 2, 20)), "20x2.*at least 3"),
        (lambda: tile(PICTURE, rect=(0, 0, 20, 2), axis="x"), "2x20.*at least 3"),
        (lambda: tile(PICTURE, rect=(30, 5, 20, 20)), "20x20 at 5,30 does not lie inside.*50x40"),
        (lambda: tile(PICTURE, rect=(-1, 0, 20, 20)), "does not lie inside"),
        (lambda: tile(PICTURE, rect=(0, 0, 0, 20)), "has pixels|pixels"),
        (lambda: tile(PICTURE, rect=(0, 0, 5.5, 20)), "four whole numbers"),
        (lambda: tile(GREY, space="lab"), "CIE-Lab"),
        (lambda: heal(PICTURE, SMALL, offset=(0, 25)), "10x10 at 45,20 leaves the picture.*50x40"),
        (lambda: heal(PICTURE, SMALL, offset=(0.5, 0)), "two whole numbers"),
        (lambda: heal(PICTURE, MASK), "no room for a patch"),
        (lambda: tonemap(PICTURE, alpha=0), "alpha is 0.*above 0"),
        (lambda: tonemap(PICTURE, beta=1.1), "beta is 1.1.*from 0 to 1"),
        (lambda: tonemap(PICTURE, saturation=11), "saturation is 11.*from 0 to 10"),
        (lambda: tonemap(PICTURE, black=99, white=50), "black is 99 and white 50"),
        (lambda: tonemap(PICTURE, floor=0), "floor is 0"),
        (lambda: tonemap(PICTURE, gamma=0), "gamma is 0"),
        (lambda: tonemap(np.where(GREY > 100, np.nan, 1.0)), "NaN"),
        (lambda: flatten(PICTURE, MASK[:20], edges=MASK), "mask is 50x20"),
    ],
)
def test_nonsense(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_a_tile_may_be_as_short_as_it_likes_along_an_axis_that_does_not_repeat():
    assert tile(PICTURE, rect=(0, 0, 1, 20), axis="x").image.shape == (1, 20, 3)
    assert tile(PICTURE, rect=(0, 0, 20, 1), axis="y").image.shape == (20, 1, 3)


def test_a_patch_may_touch_the_edge_of_the_picture():
    assert heal(PICTURE, SMALL, offset=(10, 20)).report.offset == (10, 20)
    assert heal(PICTURE, SMALL, offset=(-20, -20)).report.offset == (-20, -20)


@pytest.mark.parametrize("space", ["rgb", "linear"])
@pytest.mark.parametrize("dtype", [np.uint8, np.float64])
def test_rescaling_takes_the_largest_scale_that_fits(space, dtype):
    """With a little more something leaves the range; the scale is that of the gradients."""
    picture = PICTURE[..., 0] // 2 + 64 if dtype is np.uint8 else PICTURE[..., 0] / 510 + 0.25
    plain = focus(picture, MASK, amount=6.0, space=space)
    assert plain.report.overshoot > 1 and plain.report.scale == 1
    fitted = focus(picture, MASK, amount=6.0, space=space, rescale=True)
    scale = fitted.report.scale
    assert 0 < scale < 1 and fitted.report.overshoot == fitted.report.clipped == 0
    again = focus(picture, MASK, amount=6.0 * scale, space=space)
    # Their solutions agree within the tolerance, so that the second may leave the range by that.
    assert again.report.overshoot < 1e-3
    assert np.abs(again.image.astype(float) - fitted.image).max() <= (1 if dtype is np.uint8 else 1e-5)
    more = focus(picture, MASK, amount=6.0 * (scale + 0.01), space=space)
    assert more.report.overshoot > 1e-3


@pytest.mark.parametrize("space", ["rgb", "linear", "lab"])
def test_colours_that_rescaling_fits_keep_their_luminance_and_hue(space):
    picture = crop("astronaut.png", 40, 50, top=300, left=120) / 255
    fitted = focus(picture, MASK, amount=6.0, space=space, rescale=True)
    assert fitted.image.min() >= 0 and fitted.image.max() <= 1
    plain = focus(picture, MASK, amount=6.0 * fitted.report.scale, space=space).image
    weights = np.array([0.2126, 0.7152, 0.0722])
    luminance = plain @ weights
    could_be_larger = luminance.min() > 1e-3 and luminance.max() < 1 - 1e-3
    assert fitted.report.scale == 1 or not could_be_larger
    np.testing.assert_allclose(fitted.image @ weights, luminance, atol=1e-5)
    fits = ((plain >= 0) & (plain <= 1)).all(-1)
    assert 0.1 < fits[MASK].mean() < 0.99
    np.testing.assert_allclose(fitted.image[fits], plain[fits], atol=1e-5)
    colour, faded = (image - (image @ weights)[..., None] for image in (plain, fitted.image))
    lengths = np.linalg.norm(colour, axis=-1) * np.linalg.norm(faded, axis=-1)
    np.testing.assert_allclose((colour * faded).sum(-1), lengths, atol=1e-4)


def test_rescaling_leaves_no_ghost_of_a_saturated_picture():
    """A single channel at its end takes no contrast away: red made to glow stays where it is."""
    picture = np.full((40, 50, 3), (250, 60, 60), np.uint8)
    picture[15:25, 20:30] = (255, 30, 30)
    edit = focus(picture, MASK, amount=1.5, rescale=True)
    assert edit.report.scale == 1 and edit.report.clipped == 0
    assert focus(picture, MASK, amount=1.5).report.clipped > 0


@pytest.mark.parametrize("space", ["rgb", "linear", "lab"])
def test_rescaling_a_screened_recolouring_clips_nothing(space):
    """Its source leaves the range, and so does the screened solution for no gradients at all: the membrane does not."""
    edit = recolor(PICTURE, MASK, gain=(3, 0.5, 0.5), screen=0.1, space=space)
    assert edit.report.clipped > 100
    fitted = recolor(PICTURE, MASK, gain=(3, 0.5, 0.5), screen=0.1, space=space, rescale=True)
    assert fitted.report.clipped == 0 and fitted.report.scale > 0.3


def test_no_argument_is_modified():
    arguments = [PICTURE.copy(), PICTURE[::-1].copy(), MASK.copy()]
    before = [argument.tobytes() for argument in arguments]
    f, g, m = arguments
    clone(f, g, m, then=[Scale(2), Attenuate()], screen=0.01, robust=True, rescale=True, space="lab")
    recolor(f, m, hue=30, decolor_background=True)
    relight(f, m)
    tile(f)
    tonemap(f)
    heal(f, SMALL)
    assert [argument.tobytes() for argument in arguments] == before
