"""Boundary pixels that are unlike the others: who they are, and that they bleed less when they count less."""

import numpy as np
import pytest

from poisson_cli.editing import boundary, clone
from tests.agreement import assert_untouched
from tests.regions import disk


def test_who_lies_far_from_the_median_in_any_channel_is_an_outlier():
    rng = np.random.default_rng(0)
    difference = rng.normal(20, 2, (400, 3))
    difference[::40, 1] = 90
    far = boundary.outlyingness(difference, level=0.1) > 1
    assert far[::40].all()
    assert (
        far.mean() < 0.1 + 0.02
    )  # of a normal distribution .27 % lie beyond three deviations, in each channel


def test_nobody_is_an_outlier_within_a_level():
    difference = np.zeros((50, 1))
    difference[3] = 0.99
    difference[4] = 1.01
    np.testing.assert_array_equal(np.flatnonzero(boundary.outlyingness(difference, level=1.0) > 1), [4])


def test_outliers_are_drawn_to_where_they_begin_and_all_others_stay():
    rng = np.random.default_rng(1)
    difference = rng.normal(-5, 3, (300, 2))
    difference[7] = (200, -40)
    difference[8] = (8, -5)
    far = boundary.outlyingness(difference, level=0.1)
    drawn = boundary.winsorised(difference, level=0.1)
    np.testing.assert_array_equal(drawn[far <= 1], difference[far <= 1])
    middle = np.median(difference, axis=0)
    moved, before = drawn[7] - middle, difference[7] - middle
    np.testing.assert_allclose(moved / before, moved[0] / before[0])  # straight towards the median
    worst = (
        boundary.DEVIATIONS * boundary.DEVIATION_PER_MEDIAN * np.median(np.abs(difference - middle), axis=0)
    )
    assert np.isclose(np.abs(moved / worst).max(), 1)
    assert ((far > 1) & (far < 2)).any()
    assert (np.abs(drawn - middle) <= worst * (1 + 1e-9)).all()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("space", ["rgb", "linear", "lab"])
def test_a_dark_object_at_the_rim_does_not_bleed(dtype, space):
    """A uniform source into a uniform destination that has a dark stripe: it darkens the plain clone only."""
    scale = {np.uint8: 255, np.uint16: 65535}.get(dtype, 1)
    destination = np.full((60, 60, 3), 0.7)
    destination[:, :14] = 0.05
    source = np.full((60, 60, 3), 0.4)
    destination, source = ((scale * picture).astype(dtype) for picture in (destination, source))
    mask = disk(60, 60)
    plain = clone(destination, source, mask, space=space)
    robust = clone(destination, source, mask, space=space, robust=True)
    assert 0 < plain.report.outliers < 0.5
    assert robust.report.outliers == plain.report.outliers
    assert robust.report.boundary_mismatch == plain.report.boundary_mismatch
    assert_untouched(robust.image, destination, mask)
    want = 0.7 * scale
    assert np.abs(plain.image[mask] - want).max() > 0.1 * scale
    # A level of difference is no outlier, and may bleed; in linear light and Lab a level is worth the most near black.
    assert np.abs(robust.image[mask] - want).max() <= 0.011 * scale


def test_where_nothing_is_unlike_nothing_changes():
    rng = np.random.default_rng(0)
    destination, source = (rng.integers(100, 103, (40, 40), dtype=np.uint8) for _ in range(2))
    mask = disk(40, 40)
    plain, robust = (clone(destination, source, mask, robust=robust) for robust in (False, True))
    assert plain.report.outliers == 0
    np.testing.assert_array_equal(plain.image, robust.image)


def test_a_selection_without_a_boundary_has_no_outliers():
    picture = np.random.default_rng(0).integers(0, 255, (20, 21, 3), dtype=np.uint8)
    report = clone(picture, picture[::-1], np.ones((20, 21), bool), robust=True).report
    assert report.outliers is None and report.boundary_mismatch is None
