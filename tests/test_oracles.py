"""The oracles themselves: loops against slices, and both against sums done by hand."""

import numpy as np
import pytest

from tests import oracles
from tests.photographs import crop
from tests.regions import SHAPES, SMALL, THIN

GUIDANCE_RULES = (oracles.imported, oracles.averaged, oracles.mixed, oracles.zero)


def random_pictures(height: int, width: int, channels: int = 2) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(height * 1000 + width)
    return rng.uniform(0, 255, (height, width, channels)), rng.uniform(0, 255, (height, width, channels))


# --- by hand ----------------------------------------------------------------------------------------


def test_one_unknown_is_the_mean_of_its_neighbours_plus_the_mean_of_v():
    values = np.array([[9, 1, 9], [2, 0, 3], [9, 6, 9]], float)
    source = np.array([[0, 10, 0], [20, 70, 30], [0, 40, 0]], float)
    region = np.zeros((3, 3), bool)
    region[1, 1] = True
    solution = oracles.solve(region, values, *oracles.guidance(oracles.imported, values, source))
    assert solution[1, 1] == pytest.approx(
        (1 + 2 + 3 + 6) / 4 + ((70 - 10) + (70 - 20) + (70 - 30) + (70 - 40)) / 4
    )


def test_a_corner_has_two_neighbours():
    values = np.array([[0, 10], [20, 77]], float)
    region = np.array([[True, False], [False, False]])
    zero = oracles.guidance(oracles.zero, values, values)
    assert oracles.solve(region, values, *zero)[0, 0] == pytest.approx((10 + 20) / 2)


def test_the_membrane_of_a_line_is_linear():
    values = np.array([[10, 0, 0, 0, 50]], float)
    region = np.array([[False, True, True, True, False]])
    zero = oracles.guidance(oracles.zero, values, values)
    np.testing.assert_allclose(oracles.solve(region, values, *zero), [[10, 20, 30, 40, 50]])


def test_the_membrane_of_an_open_end_is_flat():
    values = np.array([[10, 0, 0, 0]], float)
    region = np.array([[False, True, True, True]])
    zero = oracles.guidance(oracles.zero, values, values)
    np.testing.assert_allclose(oracles.solve(region, values, *zero), [[10, 10, 10, 10]])


def test_without_a_known_pixel_the_mean_is_kept():
    values, source = random_pictures(6, 7)
    field = oracles.guidance(oracles.imported, values, source)
    solution = oracles.solve(np.ones((6, 7), bool), values, *field)
    expected = source - source.mean((0, 1)) + values.mean((0, 1))
    np.testing.assert_allclose(solution, expected, atol=1e-10)


def test_mixed_guidance_takes_the_stronger_variation_per_pair_and_channel():
    destination = np.array([[[5, 5], [1, 1]]], float)  # differences 4, 4
    source = np.array([[[0, 9], [3, 0]]], float)  # differences -3, 9
    across, down = oracles.guidance(oracles.mixed, destination, source)
    np.testing.assert_array_equal(across, [[[4, 9]]])
    assert down.shape == (0, 2, 2)


def test_mixed_guidance_takes_the_source_at_a_draw():
    destination, source = np.array([[4.0, 0.0]]), np.array([[0.0, 4.0]])
    np.testing.assert_array_equal(oracles.guidance(oracles.mixed, destination, source)[0], [[-4]])


def test_a_pair_that_leaves_the_source_has_no_source_gradient():
    destination, source = np.array([[1.0, 2.0, 4.0, 8.0]]), np.array([[50.0, 90.0]])
    across, _ = oracles.guidance(oracles.imported, destination, source, (0, 1))
    np.testing.assert_array_equal(across, [[0, -40, 0]])
    across, _ = oracles.guidance(oracles.mixed, destination, source, (0, 1))
    np.testing.assert_array_equal(across, [[-1, -40, -4]])


def test_cloning_a_source_that_differs_by_a_constant_gives_the_destination():
    destination = crop("chelsea.png", 20, 20).astype(float)
    solution = oracles.clone(destination, destination + 40, np.ones((20, 20)) * (np.arange(20) > 0))
    np.testing.assert_allclose(solution, destination, atol=1e-10)


def test_rounding_goes_to_the_nearest_and_clips():
    exact = np.array([-3.0, 0.4, 0.6, 254.6, 300.0])
    np.testing.assert_array_equal(oracles.stored(exact, np.uint8), [0, 0, 1, 255, 255])
    distance = oracles.distance_to_tie(np.array([0.5, 1.0, 7.49, 300.0]), np.uint8)
    np.testing.assert_allclose(distance, [0, 0.5, 0.01, 0.5])


# --- loops against slices ---------------------------------------------------------------------------


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("size", [SMALL, (7, 12), (2, 9), (9, 1), (1, 1)], ids=str)
def test_both_assemblies_give_the_same_equations(shape, size):
    region = SHAPES[shape](*size)
    values, source = random_pictures(*size)
    field = oracles.guidance(oracles.mixed, values, source)
    matrix, b = oracles.equations_by_loops(region, values, *field)
    same_matrix, same_b = oracles.equations(region, values, *field)
    np.testing.assert_array_equal(same_matrix.toarray(), matrix.toarray())
    np.testing.assert_allclose(same_b, b, atol=1e-10)


@pytest.mark.parametrize("rule", GUIDANCE_RULES, ids=lambda rule: rule.__name__)
@pytest.mark.parametrize("offset", [(0, 0), (3, -4), (-2, 5), (40, 0), (0, -40), (-9, -11)], ids=str)
@pytest.mark.parametrize(
    "channels", [(None, None), (3, 3), (3, None)], ids=["grey", "colour", "grey into colour"]
)
def test_both_guidances_agree(rule, offset, channels):
    rng = np.random.default_rng(3)
    destination, source = (
        rng.integers(0, 256, size if count is None else (*size, count), dtype=np.uint8)
        for size, count in zip([(9, 11), (8, 13)], channels, strict=True)
    )
    for fast, slow in zip(
        oracles.guidance(rule, destination, source, offset),
        oracles.guidance_by_loops(rule, destination, source, offset),
        strict=True,
    ):
        np.testing.assert_array_equal(fast, slow)


@pytest.mark.parametrize("tool", [oracles.clone, oracles.mix])
@pytest.mark.parametrize("offset", [(0, 0), (5, 7), (-6, -3), (9, -8)], ids=str)
def test_both_ways_to_a_picture_agree(tool, offset):
    destination, source = crop("coffee.png", 16, 18, top=100), crop("astronaut.png", 15, 14)
    mask = SHAPES["lasso"](15, 14)
    np.testing.assert_allclose(
        tool(destination, source, mask, offset=offset),
        tool(destination, source, mask, offset=offset, by_loops=True),
        atol=1e-9,
    )


# --- the solution -----------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", SHAPES)
def test_the_solution_satisfies_the_equations_and_keeps_the_known(shape):
    region = SHAPES[shape](*SMALL)
    values, source = random_pictures(*SMALL)
    field = oracles.guidance(oracles.mixed, values, source)
    solution = oracles.solve(region, values, *field)
    matrix, b = oracles.equations_by_loops(region, values, *field)
    np.testing.assert_allclose(matrix @ solution[region], b, atol=1e-9)
    np.testing.assert_array_equal(solution[~region], values[~region])


@pytest.mark.parametrize("shape", ["disk", "noise", "edge_touching", "everything"])
def test_the_solution_has_the_least_energy(shape):
    """Eq. (7) is where eq. (6) is least: whichever way the unknowns move, the sum of squares grows."""
    region, rng = SHAPES[shape](*SMALL), np.random.default_rng(0)
    values, source = random_pictures(*SMALL)
    field = oracles.guidance(oracles.mixed, values, source)
    solution = oracles.solve(region, values, *field)
    least = oracles.energy(solution, region, *field)
    for _ in range(20):
        step = np.where(region[..., None], rng.normal(size=solution.shape), 0)
        assert oracles.energy(solution + step, region, *field) > least
        assert oracles.energy(solution - step, region, *field) > least


@pytest.mark.parametrize("size", [SMALL, *THIN], ids=str)
def test_every_shape_is_the_same_region_twice(size):
    for make in SHAPES.values():
        region = make(*size)
        assert region.shape == size and region.dtype == bool
        np.testing.assert_array_equal(region, make(*size))


def test_no_shape_is_empty_where_it_is_used():
    for make in SHAPES.values():
        assert make(*SMALL).any()
