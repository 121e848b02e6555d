"""The tools on photographs, 8 bit, against the oracle: the picture a direct solver gives, and nothing else.

Three checks for each answer: no value outside the region differs by a bit; no value is further than .01 level
from the exact one before rounding; of the rounded values at least 99.99 % are the exact ones rounded.
"""

import numpy as np
import pytest

from poisson_cli.editing import clone, fill, mix
from tests import oracles
from tests.agreement import (
    LARGEST_ERROR,
    assert_rounded_right,
    assert_untouched,
    count_different,
    largest_error,
)
from tests.photographs import crop
from tests.regions import LARGE, SHAPES, disk, lasso
from tests.tools import TOOLS, WITH_SOURCE

PAIRS = {
    "astronaut on coffee": (("coffee.png", 150), ("astronaut.png", 60)),
    "cat on rocket": (("rocket.jpg", 60), ("chelsea.png", 60)),
    "coffee on cat": (("chelsea.png", 60), ("coffee.png", 150)),
    "moon on camera": (("camera.png", 60), ("moon.png", 200)),
}
COLOUR_PAIRS = tuple(pair for pair in PAIRS if pair != "moon on camera")


def pictures(pair: str, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Destination and source."""
    (destination, top), (source, source_top) = PAIRS[pair]
    return crop(destination, height, width, top=top), crop(source, height, width, top=source_top)


def as_float(picture: np.ndarray) -> np.ndarray:
    """The same picture where full scale is 1, so that nothing is rounded on the way out."""
    return picture.astype(np.float64) / 255


# --- every shape, every tool ------------------------------------------------------------------------


@pytest.mark.parametrize("tool", ["clone", "mix", "fill"])
@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape(tool, shape):
    destination, source = pictures("astronaut on coffee", *LARGE)
    mask = SHAPES[shape](*LARGE)
    exact = TOOLS[tool].exact(destination, source, mask)
    assert_rounded_right(TOOLS[tool].edit(destination, source, mask).image, destination, exact, mask)


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("tool", TOOLS)
def test_every_tool_on_every_pair_of_photographs(tool, pair):
    destination, source = pictures(pair, 150, 171)
    mask = lasso(150, 171)
    exact = TOOLS[tool].exact(destination, source, mask)
    assert_rounded_right(TOOLS[tool].edit(destination, source, mask).image, destination, exact, mask)


@pytest.mark.parametrize("tool", ["clone", "mix", "fill"])
def test_at_least_9999_of_10000_values_over_all_shapes_together(tool):
    """The share itself, not rounded up to one value a picture."""
    different = values = 0
    for pair in COLOUR_PAIRS:
        destination, source = pictures(pair, 120, 131)
        for make in SHAPES.values():
            mask = make(120, 131)
            image = TOOLS[tool].edit(destination, source, mask).image
            different += count_different(image, TOOLS[tool].exact(destination, source, mask), mask)
            values += 3 * int(mask.sum())
    assert different <= 1e-4 * values


@pytest.mark.parametrize("solver", ["multigrid", "sor"])
@pytest.mark.parametrize("tool", ["clone", "mix", "fill"])
@pytest.mark.parametrize(
    "shape", ["disk", "pins", "noise", "edge_touching", "all_but_one_pixel", "everything"]
)
def test_largest_error_before_rounding(tool, shape, solver):
    """Floats are not rounded, so the error shows as it is."""
    destination, source = (as_float(picture) for picture in pictures("astronaut on coffee", *LARGE))
    mask = SHAPES[shape](*LARGE)
    image = TOOLS[tool].edit(destination, source, mask, solver=solver).image
    exact = TOOLS[tool].exact(destination, source, mask)
    assert_untouched(image, destination, mask)
    assert largest_error(image, exact, mask, 1 / 255) <= LARGEST_ERROR


# --- the paper's size -------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", ["multigrid", "sor"])
@pytest.mark.parametrize("tool", ["clone", "mix", "fill"])
def test_the_papers_disk_of_60000_pixels(tool, solver):
    destination, source = pictures("coffee on cat", 230, 340)
    row, col = np.mgrid[:230, :340]
    mask = np.hypot((row - 114.5) / 114, (col - 169.5) / 168) < 1
    assert abs(int(mask.sum()) - 60000) < 300
    exact = TOOLS[tool].exact(destination, source, mask)
    image = TOOLS[tool].edit(destination, source, mask, solver=solver).image
    assert_rounded_right(image, destination, exact, mask)


# --- solvers and cycles -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "choice", [{"cycle": "W"}, {"cycle": "V"}, {"solver": "sor"}, {"threads": 2}], ids=str
)
@pytest.mark.parametrize("shape", ["disk", "cracks", "left_half"])
@pytest.mark.parametrize("tool", TOOLS)
def test_every_choice_of_solver_gives_the_same_picture(tool, shape, choice):
    destination, source = pictures("astronaut on coffee", 100, 121)
    mask = SHAPES[shape](100, 121)
    exact = TOOLS[tool].exact(destination, source, mask)
    image = TOOLS[tool].edit(destination, source, mask, **choice).image
    assert_rounded_right(image, destination, exact, mask)


@pytest.mark.parametrize("tool", TOOLS)
def test_any_number_of_threads_gives_the_same_bytes(tool):
    destination, source = pictures("astronaut on coffee", *LARGE)
    mask = disk(*LARGE)
    one, two, free = (
        TOOLS[tool].edit(destination, source, mask, threads=threads) for threads in (1, 2, None)
    )
    assert one.image.tobytes() == two.image.tobytes() == free.image.tobytes()


# --- mixing and averaging, the definitions ----------------------------------------------------------


def stronger_over_channels(difference, source_difference):
    """Not eq. (13): all channels follow the one variation that is stronger in colour space."""
    norms = (np.linalg.norm(d, axis=-1, keepdims=True) for d in (difference, source_difference))
    return np.where(np.greater(*norms), difference, source_difference)


def stronger_per_pixel(destination, source):
    """Not eq. (13) either: both pairs of a pixel follow the picture with the larger gradient there."""
    fields = [oracles.guidance(oracles.imported, destination, picture) for picture in (destination, source)]
    f, g = (np.abs(across[:-1]) + np.abs(down[:, :-1]) for across, down in fields)
    choice = [np.pad(f > g, [(0, pad), (0, 1 - pad), (0, 0)], mode="edge") for pad in (1, 0)]
    return tuple(np.where(c, a, b) for c, a, b in zip(choice, *fields, strict=True))


def test_mix_chooses_per_pair_and_channel():
    """On pictures where coarser rules give something else."""
    destination, source = pictures("cat on rocket", 60, 61)
    mask = lasso(60, 61)
    exact = oracles.mix(destination, source, mask)
    per_pair = oracles.guidance(stronger_over_channels, destination, source)
    for field in (per_pair, stronger_per_pixel(destination, source)):
        assert np.abs(oracles.solve(mask, destination, *field) - exact).max() > 1
    assert_rounded_right(mix(destination, source, mask).image, destination, exact, mask)


def test_mixing_with_a_flat_source_keeps_the_destination():
    destination, source = pictures("cat on rocket", 60, 61)
    image = mix(destination, np.full_like(source, 90), lasso(60, 61)).image
    np.testing.assert_array_equal(image, destination)


def test_mixing_into_a_flat_destination_is_cloning():
    destination, source = pictures("cat on rocket", 60, 61)
    flat, mask = np.full_like(destination, 128), lasso(60, 61)
    np.testing.assert_array_equal(mix(flat, source, mask).image, clone(flat, source, mask).image)


def test_averaging_is_halfway_between_the_destination_and_the_clone():
    destination, source = (as_float(picture) * 0.5 + 0.25 for picture in pictures("coffee on cat", 60, 61))
    mask = lasso(60, 61)
    average = clone(destination, source, mask, gradients="average").image
    halfway = (destination + clone(destination, source, mask).image) / 2
    np.testing.assert_allclose(average, halfway, atol=2e-3 / 255)


# --- colour and grey --------------------------------------------------------------------------------


def test_monochrome_takes_the_pattern_of_the_source_not_its_colour():
    """Cloned into flat grey, a monochrome source leaves every pixel grey."""
    _, source = pictures("astronaut on coffee", 90, 101)
    image = clone(np.full_like(source, 128), source, lasso(90, 101), monochrome=True).image
    assert np.ptp(image, axis=2).max() == 0
    assert image.std() > 10


@pytest.mark.parametrize("tool", ["monochrome", "monochrome average"])
def test_a_monochrome_source_may_go_into_a_grey_destination(tool):
    destination, source = crop("camera.png", 90, 101), crop("astronaut.png", 90, 101)
    mask = lasso(90, 101)
    exact = TOOLS[tool].exact(destination, source, mask)
    assert_rounded_right(TOOLS[tool].edit(destination, source, mask).image, destination, exact, mask)


@pytest.mark.parametrize("tool", WITH_SOURCE)
def test_a_grey_source_is_spread_over_the_channels(tool):
    destination, source = crop("astronaut.png", 90, 101), crop("camera.png", 90, 101)
    mask = lasso(90, 101)
    exact = TOOLS[tool].exact(destination, source, mask)
    assert_rounded_right(TOOLS[tool].edit(destination, source, mask).image, destination, exact, mask)


def test_channels_do_not_speak_to_each_other():
    destination, source = pictures("cat on rocket", 60, 61)
    mask = lasso(60, 61)
    together = mix(destination, source, mask).image
    for channel in range(3):
        alone = mix(destination[..., channel].copy(), source[..., channel].copy(), mask).image
        off = np.abs(together[..., channel].astype(int) - alone)
        assert off.max() <= 1 and (off > 0).sum() <= 1  # a value next to a tie


# --- what the report says ---------------------------------------------------------------------------


def test_the_report_of_a_clone():
    destination, source = pictures("astronaut on coffee", 60, 80)
    mask = np.zeros((60, 80), bool)
    mask[10:25, 30:70] = True
    report = clone(destination, source, mask, offset=(5, -3)).report
    assert report.tool == "clone"
    assert report.rectangle == (15, 27, 15, 40)
    assert report.unknowns == 15 * 40
    assert report.solver == "multigrid" and report.cycle == "F"
    assert 0 < report.iterations < 15
    assert report.error_estimate <= report.tolerance
    assert not report.floating
    assert report.seconds and all(seconds >= 0 for seconds in report.seconds.values())


def test_the_boundary_mismatch_is_the_mean_difference_along_the_boundary():
    destination, source = pictures("astronaut on coffee", 40, 50)
    region = lasso(40, 50)
    boundary = np.zeros_like(region)
    for p in np.argwhere(~region):
        boundary[tuple(p)] = any(region[q] for q in oracles.neighbours((int(p[0]), int(p[1])), region.shape))
    expected = np.abs(destination.astype(float) - source)[boundary].mean(0)
    np.testing.assert_allclose(clone(destination, source, region).report.boundary_mismatch, expected)


def test_a_fill_has_no_boundary_mismatch():
    image, _ = pictures("astronaut on coffee", 40, 50)
    assert fill(image, lasso(40, 50)).report.boundary_mismatch is None


def test_clipped_values_are_counted():
    destination = np.full((20, 20), 250, np.uint8)
    source = np.zeros((20, 20), np.uint8)
    source[8:12, 8:12] = 200
    mask = np.zeros((20, 20), bool)
    mask[5:15, 5:15] = True
    exact = oracles.clone(destination, source, mask)
    edit = clone(destination, source, mask)
    assert 0 < int((exact > 255.5).sum()) <= edit.report.clipped <= int((exact > 255).sum())
    assert edit.image.max() == 255


def test_nothing_is_clipped_when_nothing_leaves_the_range():
    image, _ = pictures("astronaut on coffee", 40, 50)
    assert fill(image, lasso(40, 50)).report.clipped == 0


def test_a_selection_of_everything_is_reported_as_floating():
    destination, source = pictures("astronaut on coffee", 40, 50)
    assert clone(destination, source, np.ones((40, 50), bool)).report.floating
