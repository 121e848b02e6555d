"""What lets several threads look at one window: bands of their own, and time that is counted once."""

import numpy as np
import pytest

import solvers.canvas
from poisson_cli.editing import stopwatch
from poisson_cli.editing.guidance import averaged, imported, mixed
from poisson_cli.editing.layers import Layer
from poisson_cli.editing.placement import place
from poisson_cli.editing.stopwatch import Stopwatch
from poisson_cli.editing.window import Window
from tests.oracles import neighbours
from tests.photographs import crop
from tests.regions import SHAPES


@pytest.fixture(autouse=True)
def narrow_bands(monkeypatch):
    """Bands of two rows."""
    monkeypatch.setattr(solvers.canvas, "BAND", 1)
    monkeypatch.setattr(solvers.canvas, "FEWEST_ROWS", 2)


@pytest.mark.parametrize("field", [imported, averaged, mixed], ids=["imported", "averaged", "mixed"])
def test_bands_asked_for_in_turn_do_not_disturb_each_other(field):
    destination, source = crop("coffee.png", 40, 30), crop("chelsea.png", 40, 30)
    placement = place(destination.shape, source.shape, SHAPES["disk"](40, 30))
    window = Window(destination, placement, Layer.of_source(source, placement, 3), field)
    half = len(placement.region) // 4 * 2
    ranges = (0, half), (half, 2 * half)

    def copied(band):
        arrays = (band.values, band.across, band.down)
        return band.first, band.end, *(None if array is None else array.copy() for array in arrays)

    expected = [[copied(band) for band in window.equations(*rows)] for rows in ranges]
    # Both bands of a pair are looked at when both have been made.
    pairs = (
        [copied(band) for band in pair] for pair in zip(*(window.equations(*r) for r in ranges), strict=False)
    )
    assert min(map(len, expected)) > 5
    for k, pair in enumerate(pairs):
        for band, side in zip(pair, expected, strict=True):
            for part, right in zip(band, side[k], strict=True):
                assert np.array_equal(part, right)


@pytest.mark.parametrize("offset", [(0, 0), (3, 2), (-3, 2), (2, -5), (-4, -4)])
@pytest.mark.parametrize("shape", ["disk", "noise", "edge_touching", "everything"])
def test_the_boundary_on_the_source(shape, offset):
    mask = SHAPES[shape](21, 18)
    placement = place((25, 23, 3), mask.shape, mask, offset=offset)
    region = placement.region
    expected = []
    for p in np.ndindex(region.shape):
        row, col = (n + at - o for n, at, o in zip(p, (placement.top, placement.left), offset, strict=True))
        on_source = 0 <= row < mask.shape[0] and 0 <= col < mask.shape[1]
        if on_source and not region[p] and any(region[q] for q in neighbours(p, region.shape)):
            expected.append(p)
    assert list(zip(*placement.boundary_on_source(), strict=True)) == expected


def test_a_stopwatch_counts_time_once(monkeypatch):
    now = 0.0
    monkeypatch.setattr(stopwatch, "perf_counter", lambda: now)
    watch = Stopwatch()
    with watch:
        now = 1.0
        with watch:  # another thread, say
            now = 3.0
        now = 4.0
    now = 10.0
    with watch:
        now = 10.5
    assert watch.seconds == 4.5
