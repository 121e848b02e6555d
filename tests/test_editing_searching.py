"""Where `heal` takes its patch from."""

import numpy as np
import pytest

import poisson_cli.editing.searching as searching
from poisson_cli.editing import heal
from poisson_cli.editing.placement import place
from poisson_cli.errors import InputError
from tests.photographs import crop
from tests.regions import disk, lasso


def search(image, mask, reach=None):
    return searching.best_offset(image, place(image.shape, image.shape, mask), reach)


def ring(mask: np.ndarray, width: int) -> np.ndarray:
    """Pixels that are at most so many steps to a neighbour away from the mask, and not in it."""
    rows, cols = np.nonzero(mask)
    grid = np.stack(np.meshgrid(*map(np.arange, mask.shape), indexing="ij"), -1)
    steps = np.abs(grid[:, :, None, :] - np.stack([rows, cols], -1)).sum(-1).min(-1)
    return (steps > 0) & (steps <= width)


def costs(image: np.ndarray, mask: np.ndarray) -> dict[tuple[int, int], float]:
    """The cost of every offset that there may be, by its definition."""
    f = image.reshape(*image.shape[:2], -1).astype(float)
    rim = ring(mask, searching.RIM)
    needed, (rows, cols) = np.argwhere(mask | rim), np.nonzero(rim)
    inside = np.nonzero(mask)
    height, width = mask.shape
    found = {}
    for offset in np.ndindex(2 * height - 1, 2 * width - 1):
        row, col = offset[0] - height + 1, offset[1] - width + 1
        there = needed + np.array([row, col])
        if (there < 0).any() or (there >= (height, width)).any() or mask[tuple(there.T)].any():
            continue
        difference = f[rows, cols] - f[rows + row, cols + col]
        patch = f[inside[0] + row, inside[1] + col]
        found[row, col] = (difference.var(0) + difference.mean(0) ** 2 / 4 + patch.var(0) / 4).sum()
    return found


@pytest.mark.parametrize("picture", ["coffee.png", "camera.png"])
@pytest.mark.parametrize("at", [(0, 0), (14, 20), (27, 38)])
def test_it_is_the_offset_that_costs_least(picture, at):
    image = crop(picture, 36, 48)
    mask = np.zeros((36, 48), bool)
    mask[at[0] : at[0] + 9, at[1] : at[1] + 10] = disk(9, 10)
    every = costs(image, mask)
    found = search(image, mask)
    assert found in every
    assert every[found] <= min(every.values()) * (1 + 2e-6) + 2e-5


@pytest.mark.parametrize("light", [0, 12, -30])
def test_a_place_of_another_colour_is_worse_than_one_in_another_light(light):
    """Cloth is never the same twice; a wall is flat, but grey."""
    rng = np.random.default_rng(0)
    image = np.empty((60, 90, 3))
    image[:, :60] = np.array([200, 90, 60]) + rng.normal(0, 12, (60, 60, 1))
    image[:, 30:60] += light
    image[:, 60:] = 180
    image = np.round(image).astype(np.uint8)
    mask = np.zeros((60, 90), bool)
    mask[20:36, 6:20] = disk(16, 14)
    _, col = search(image, mask)
    assert 20 + col + searching.RIM <= 60


def test_a_tight_loop_around_a_badge_is_mended_with_cloth():
    image = crop("astronaut.png", 512, 512, top=0, left=0)
    rows, cols = np.mgrid[:512, :512]
    mask = ((cols - 174) / 46) ** 2 + ((rows - 386) / 50) ** 2 <= 1
    assert max(heal(image, mask).report.boundary_mismatch) < 40


def test_what_the_selection_hides_has_no_say():
    image = crop("coffee.png", 60, 80)
    mask = np.zeros((60, 80), bool)
    mask[20:32, 30:45] = lasso(12, 15)
    other = image.copy()
    other[mask] = np.random.default_rng(0).integers(0, 255, (mask.sum(), 3))
    assert search(image, mask) == search(other, mask)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_the_nearest_of_equals_is_taken(dtype):
    """In a picture that repeats itself."""
    tile = np.random.default_rng(0).integers(0, 255, (13, 17))
    image = (np.tile(tile, (5, 5)) * {np.uint8: 1, np.uint16: 257}.get(dtype, 1 / 255)).astype(dtype)
    mask = np.zeros(image.shape, bool)
    mask[26:30, 34:39] = True
    assert search(image, mask) in {(0, 17), (0, -17), (13, 0), (-13, 0)}
    assert search(image, mask) == (-13, 0)
    assert search(np.ones((40, 50), dtype), mask[:40, 10:60])[1] == 0


def test_a_reach_is_kept():
    image = crop("coffee.png", 80, 90)
    mask = np.zeros((80, 90), bool)
    mask[30:40, 40:50] = True
    for reach in (16, 20, 25):
        assert max(map(abs, search(image, mask, reach))) <= reach
    with pytest.raises(InputError, match="no room"):
        search(image, mask, 9)
    with pytest.raises(InputError, match="reach is 0"):
        heal(image, mask, reach=0)


@pytest.mark.parametrize("size", [(160, 200), (163, 205)])
def test_a_large_picture_is_searched_at_a_reduced_size(size, monkeypatch):
    """There is one place that is the same but for a constant, at no multiple of the reduction."""
    monkeypatch.setattr(searching, "SEARCHED", 160 * 200 // 16)
    rng = np.random.default_rng(0)
    image = np.cumsum(np.cumsum(rng.normal(size=size), 0), 1)
    image = np.round(100 + 50 * image / np.abs(image).max()).astype(np.uint8)
    image[95:130, 101:141] = image[20:55, 30:70] + 2
    mask = np.zeros(size, bool)
    mask[30:45, 40:60] = disk(15, 20)
    assert search(image, mask) == (75, 71)


def test_there_must_be_room():
    image = crop("coffee.png", 40, 50)
    for mask in (np.ones((40, 50), bool), disk(40, 50)):
        with pytest.raises(InputError, match="no room in the picture|no room for a patch"):
            search(image, mask)


def test_the_time_of_a_search_counts():
    image, mask = crop("coffee.png", 60, 70, top=150), np.zeros((60, 70), bool)
    mask[20:30, 20:30] = disk(10, 10)
    found = heal(image, mask).report
    assert list(found.seconds) == ["search", "guidance", "solve", "paste"]
    assert found.seconds["search"] > 0
    assert found.offset is not None
    assert list(heal(image, mask, offset=found.offset).report.seconds) == ["guidance", "solve", "paste"]
