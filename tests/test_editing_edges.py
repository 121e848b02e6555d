"""Edges: where they are found, in which units, and what is said when they cannot be."""

import sys

import numpy as np
import pytest

from poisson_cli.editing import Sieve, clone, find_edges, flatten
from poisson_cli.errors import InputError
from tests.photographs import crop
from tests.regions import lasso

DEPTHS = {np.uint8: 1.0, np.uint16: 257.0, np.float32: 1 / 255, np.float64: 1 / 255}


def ramp(slope: float) -> np.ndarray:
    """A soft step in the middle, (40, 60), at most so many levels per pixel."""
    return np.tile(100 + 8 * slope * np.tanh((np.arange(60) - 29.5) / 8), (40, 1))


@pytest.mark.parametrize("dtype", DEPTHS)
def test_thresholds_are_levels_per_pixel(dtype):
    picture = (np.rint(ramp(8.0)) * DEPTHS[dtype]).astype(dtype)
    assert find_edges(picture, low=2, high=6.5, sigma=0).any()
    assert not find_edges(picture, low=2, high=9.5, sigma=0).any()
    columns = np.flatnonzero(find_edges(picture, low=6.5, high=6.5, sigma=0).any(0))
    assert 25 <= columns.min() <= columns.max() <= 34


def test_a_single_channel_may_have_an_axis_of_its_own():
    picture = crop("coins.png", 90, 101)
    edges = find_edges(picture)
    assert edges.any()
    np.testing.assert_array_equal(find_edges(picture[:, :, np.newaxis]), edges)


def test_colours_of_one_luminance_have_edges():
    picture = np.zeros((30, 30, 3), np.uint8)
    picture[:, :15, 0], picture[:, 15:, 1] = 200, 60
    assert find_edges(picture).any()


def test_a_blur_takes_small_edges_away():
    picture = crop("coffee.png", 90, 101, top=150)
    shares = [find_edges(picture, sigma=sigma).mean() for sigma in (0, 1, 2, 4)]
    assert shares == sorted(shares, reverse=True) and shares[0] > 2 * shares[-1] > 0


def test_the_outline_of_the_selection_is_no_edge():
    """Edges are those of the whole picture: the same inside whatever is selected."""
    picture, mask = crop("coffee.png", 90, 101, top=150), lasso(90, 101)
    given = flatten(picture, mask, edges=find_edges(picture))
    found = flatten(picture, mask)
    np.testing.assert_array_equal(found.image, given.image)
    assert found.report.edge_share == given.report.edge_share == find_edges(picture)[mask].mean()
    assert [*found.report.seconds] == ["edges", *given.report.seconds]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"low": -1}, "low is -1"),
        ({"high": np.nan}, "high is nan"),
        ({"sigma": np.inf}, "sigma is inf"),
        ({"low": 20, "high": 10}, "low must not be the larger"),
    ],
)
def test_parameters_that_make_no_sense(parameters, message):
    with pytest.raises(InputError, match=message):
        find_edges(crop("coffee.png", 40, 50), **parameters)


def test_edges_of_another_size_are_refused():
    picture = crop("coffee.png", 40, 50)
    with pytest.raises(InputError, match=r"edges have shape \(50, 40\).*image has \(40, 50\)"):
        flatten(picture, lasso(40, 50), edges=np.ones((50, 40)))
    with pytest.raises(InputError, match="source"):
        clone(picture, picture, lasso(40, 50), then=[Sieve(np.ones((40, 50, 3)))])


def test_without_opencv_the_error_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    picture, mask = crop("coffee.png", 40, 50), lasso(40, 50)
    with pytest.raises(InputError, match=r"pip install 'poisson-cli\[edges\]'"):
        flatten(picture, mask)
    flatten(picture, mask, edges=mask)  # needs none
