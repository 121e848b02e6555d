"""Shapes on the grid: a pixel is in when its centre is, half-open, as COCO has it."""

import doctest
import importlib
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from poisson_cli.errors import InputError
from poisson_cli.masks import draw_ellipse, draw_polygon, draw_rectangle, grow, scan, show, shrink
from poisson_cli.masks.runs import paint
from poisson_cli.settings import Ellipse, Polygon, Rectangle
from tests import coco_oracle

HEIGHT, WIDTH = 13, 17
SHAPE = (HEIGHT, WIDTH)


def winding_by_hand(points, row: int, col: int) -> tuple[int, int]:
    """How often a closed line goes round a pixel's centre, and is crossed on the way left, in exact fractions."""
    y, x = Fraction(2 * row + 1, 2), Fraction(2 * col + 1, 2)
    turns = crossings = 0
    corners = [(Fraction(r), Fraction(c)) for r, c in points]
    for (y0, x0), (y1, x1) in zip(corners, corners[1:] + corners[:1], strict=True):
        if (y0 <= y) != (y1 <= y) and x0 + (y - y0) * (x1 - x0) / (y1 - y0) <= x:
            turns += 1 if y0 < y1 else -1
            crossings += 1
    return turns, crossings


def drawn_by_hand(polygon: Polygon, shape=SHAPE) -> np.ndarray:
    mask = np.zeros(shape, bool)
    for row in range(shape[0]):
        for col in range(shape[1]):
            turns, crossings = winding_by_hand(polygon.points, row, col)
            mask[row, col] = turns != 0 if polygon.rule == "nonzero" else crossings % 2 == 1
    return mask


# Eighths, so that edges run through centres of pixels more often than not.
eighths = st.integers(-40, 180).map(lambda n: n / 8)
corners = st.lists(st.tuples(eighths, eighths), min_size=3, max_size=9).map(tuple)
rules = st.sampled_from(["even-odd", "nonzero"])


@given(corners, rules)
@settings(max_examples=150, deadline=None)
def test_polygons_are_those_of_the_double_loop(points, rule):
    polygon = Polygon(points, rule)
    np.testing.assert_array_equal(draw_polygon(polygon, SHAPE), drawn_by_hand(polygon))


@given(corners, st.permutations(range(9)), st.booleans())
@settings(max_examples=50, deadline=None)
def test_it_does_not_matter_where_a_polygon_begins_and_which_way_it_goes(points, order, rule):
    rule = "nonzero" if rule else "even-odd"
    first = order[0] % len(points)
    other = points[first:] + points[:first]
    expected = draw_polygon(Polygon(points, rule), SHAPE)
    np.testing.assert_array_equal(draw_polygon(Polygon(other, rule), SHAPE), expected)
    np.testing.assert_array_equal(draw_polygon(Polygon(other[::-1], rule), SHAPE), expected)


floats = st.floats(0.1, 12.9)


@given(st.tuples(floats, floats), st.tuples(floats, floats), st.tuples(floats, floats))
@settings(max_examples=100, deadline=None)
def test_neighbours_share_no_pixel_and_leave_none_out(a, b, c):
    """The picture cut into parts at any three points: even-odd parts that share edges tile what they cover."""
    outer = ((0.0, 0.0), (0.0, 17.0), (13.0, 17.0), (13.0, 0.0))
    fan = [(outer[i], outer[(i + 1) % 4], a) for i in range(4)]
    assert np.array_equal(sum(draw_polygon(Polygon(one), SHAPE).astype(int) for one in fan), np.ones(SHAPE))
    triangle = (a, b, c)
    parts = [draw_polygon(Polygon((*triangle[i:], *triangle[:i])), SHAPE) for i in range(3)]
    assert all(np.array_equal(part, parts[0]) for part in parts)


def test_lines_that_cross_themselves():
    """A five-pointed star: its middle is gone round twice."""
    angles = np.arange(5) * 4 * np.pi / 5
    star = tuple(map(tuple, (20 + 18 * np.column_stack((-np.cos(angles), np.sin(angles)))).tolist()))
    hollow, full = (draw_polygon(Polygon(star, rule), (40, 40)) for rule in ("even-odd", "nonzero"))
    assert not hollow[20, 20] and full[20, 20]
    assert hollow[6, 20] and full[6, 20]
    assert not (hollow & ~full).any()


# COCO's own library


def coco_polygon(points, shape) -> np.ndarray:
    flat = [float(number) for row, col in points for number in (col, row)]
    return coco_oracle.draw([flat], shape)


@pytest.mark.parametrize("box", [(3, 4, 5, 6), (0, 0, 13, 17), (-4, 10, 30, 30), (2.4, 3.6, 4, 5.2)])
def test_boxes_are_cocos(box):
    row, col, height, width = box
    points = ((row, col), (row, col + width), (row + height, col + width), (row + height, col))
    np.testing.assert_array_equal(draw_polygon(Polygon(points), SHAPE), coco_polygon(points, SHAPE))
    if all(isinstance(number, int) for number in box):
        np.testing.assert_array_equal(draw_rectangle(Rectangle(*box), SHAPE), coco_polygon(points, SHAPE))


def test_the_square_of_ten_pixels_has_a_hundred():
    square = ((10, 10), (10, 20), (20, 20), (20, 10))
    assert draw_polygon(Polygon(square), (40, 40)).sum() == coco_polygon(square, (40, 40)).sum() == 100


def distance_to_edges(points, shape) -> np.ndarray:
    rows, cols = np.mgrid[: shape[0], : shape[1]] + 0.5
    nearest = np.full(shape, np.inf)
    for (r0, c0), (r1, c1) in zip(points, (*points[1:], points[0]), strict=True):
        length = max((r1 - r0) ** 2 + (c1 - c0) ** 2, 1e-12)
        along = np.clip(((rows - r0) * (r1 - r0) + (cols - c0) * (c1 - c0)) / length, 0, 1)
        nearest = np.minimum(nearest, np.hypot(rows - r0 - along * (r1 - r0), cols - c0 - along * (c1 - c0)))
    return nearest


@pytest.mark.parametrize("seed", range(60))
def test_polygons_are_cocos_but_for_what_it_rounds(seed):
    """COCO's library rounds corners to fifths of a pixel and walks along edges in such steps."""
    rng = np.random.default_rng(seed)
    shape = (60, 70)
    angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 12)))
    radii = rng.uniform(5, 40, angles.size)
    points = tuple(
        (float(30 + r * np.sin(a)), float(35 + r * np.cos(a))) for r, a in zip(radii, angles, strict=True)
    )
    ours, theirs = draw_polygon(Polygon(points), shape), coco_polygon(points, shape)
    assert (distance_to_edges(points, shape)[ours != theirs] <= 0.2).all()


# Others


@pytest.mark.parametrize("seed", range(100))
def test_ellipses(seed):
    rng = np.random.default_rng(seed)
    (row, col), (height, width) = rng.integers(-10, 20, 2).tolist(), rng.integers(1, 40, 2).tolist()
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    y, x = 2 * (y - row) + 1 - height, 2 * (x - col) + 1 - width
    expected = (x * height) ** 2 + (y * width) ** 2 < (width * height) ** 2
    ellipse = Ellipse(Rectangle(row, col, height, width))
    np.testing.assert_array_equal(draw_ellipse(ellipse, SHAPE), expected)


def test_a_large_ellipse_is_exact():
    """Half a side of 999,999,999: its square has more digits than a float."""
    huge = Ellipse(Rectangle(-499_999_990, 3, 999_999_999, 999_999_999))
    mask = draw_ellipse(huge, (20, 5))
    np.testing.assert_array_equal(mask[9], [False, False, False, True, True])
    assert draw_ellipse(Ellipse(Rectangle(0, 0, 13, 17)), SHAPE).any(axis=1).all()


@given(st.lists(st.tuples(st.integers(0, 30), st.integers(0, 30)).map(sorted), max_size=12))
def test_runs_are_joined(runs):
    expected = np.zeros(30, bool)
    for start, end in runs:
        expected[start:end] = True
    starts, ends = np.array(runs, np.int64).reshape(-1, 2).T
    np.testing.assert_array_equal(paint(starts, ends, 30), expected)


@pytest.mark.parametrize("seed", range(80))
def test_growing_and_shrinking_are_euclidean(seed):
    rng = np.random.default_rng(seed)
    mask = rng.random(rng.integers(1, 40, 2)) < rng.choice([0.01, 0.1, 0.9, 0.99])
    by = int(rng.integers(0, 30))
    before = mask.copy()
    near = ndimage.distance_transform_edt(~mask) <= by + 1e-9 if mask.any() else mask
    np.testing.assert_array_equal(grow(mask, by), near)
    far = ndimage.distance_transform_edt(mask) > by + 1e-9 if not mask.all() else mask
    np.testing.assert_array_equal(shrink(mask, by), far)
    np.testing.assert_array_equal(mask, before)


@pytest.mark.parametrize("by", [10**4, 10**9])
def test_growing_beyond_the_picture(by):
    one = np.zeros(SHAPE, bool)
    one[3, 5] = True
    assert grow(one, by).all()
    assert not shrink(~one, by).any()


def test_growing_in_bands(monkeypatch):
    monkeypatch.setattr("poisson_cli.masks.growth._BAND", 7)
    mask = np.random.default_rng(1).random((30, 40)) < 0.02
    np.testing.assert_array_equal(grow(mask, 4), ndimage.distance_transform_edt(~mask) <= 4)


# Limits


def test_too_intricate_a_polygon_is_refused_before_it_is_drawn(monkeypatch):
    zigzag = tuple((float(1e9 * (n % 2)), float(n)) for n in range(100))
    monkeypatch.setattr(scan, "MOST_CUTS", 100 * HEIGHT - 1)
    with pytest.raises(InputError, match="too intricate: their edges pass 1,300 rows"):
        draw_polygon(Polygon(zigzag), SHAPE)
    monkeypatch.setattr(scan, "MOST_CUTS", 100 * HEIGHT)
    assert draw_polygon(Polygon(zigzag), SHAPE).shape == SHAPE


def test_huge_coordinates():
    far = 1e9
    around = Polygon(((-far, -far), (-far, far), (far, far), (far, -far)))
    assert draw_polygon(around, SHAPE).all()
    beside = Polygon(((-far, 20.0), (-far, far), (far, far), (far, 20.0)))
    assert not draw_polygon(beside, SHAPE).any()


def test_showing_changes_no_selected_pixel():
    rng = np.random.default_rng(5)
    mask = rng.random((30, 40)) < 0.3
    for pixels in (rng.integers(0, 256, (30, 40), np.uint8), rng.integers(0, 256, (30, 40, 3), np.uint8)):
        shown = show(pixels, mask)
        colours = pixels if pixels.ndim == 3 else np.dstack([pixels] * 3)
        assert shown.shape == (30, 40, 3) and shown.dtype == np.uint8
        np.testing.assert_array_equal(shown[mask], colours[mask])
        line = ndimage.binary_dilation(mask) & ~mask
        np.testing.assert_array_equal(shown[line], np.broadcast_to([255, 214, 10], (line.sum(), 3)))
        rest = ~mask & ~line
        np.testing.assert_array_equal(shown[rest], colours[rest] // 3)
    assert np.array_equal(show(pixels, np.ones((30, 40), bool)), pixels)


@pytest.mark.parametrize(
    "module",
    ["growth", "overlay", "plan", "points", "raster", "runs", "shapes", "annotations.rle"],
)
def test_examples_in_docstrings(module):
    tried = doctest.testmod(importlib.import_module(f"poisson_cli.masks.{module}"))
    assert tried.attempted > 0
    assert tried.failed == 0
