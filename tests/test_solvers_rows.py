"""The finest level row by row: the bits of the wave of segments that it stands for, on any region."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from solvers import build_hierarchy
from solvers.cycles import DOWN, OPERATIONS, TURN, UP
from solvers.hierarchy import Hierarchy
from solvers.kernels import cycle as kernels
from solvers.layout import FIRST_SEGMENT, LANES, OFFSET, QUARTER, aligned_zeros, field_size
from tests.regions import LARGE, SHAPES

CHANGES = (2, 3)


def fields(hierarchy: Hierarchy, channels: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Any x and b on all levels, zero outside the region."""
    rng = np.random.default_rng(seed)
    x, b = (aligned_zeros(field_size(hierarchy.table, channels)) for _ in range(2))
    for line in hierarchy.table[:-1]:
        size, offset = int(line[QUARTER]), int(line[OFFSET])
        inside = hierarchy.weight[offset : offset + 4 * size] > 0
        for field in (x, b):
            here = field[channels * offset : channels * (offset + 4 * size)].reshape(channels, -1)
            here[:] = rng.normal(0, 100, here.shape) * inside
    return x, b


def visit(
    kind: str, hierarchy: Hierarchy, x: np.ndarray, b: np.ndarray, channels: int, end: int
) -> np.ndarray:
    """One visit to the finest level, in place; `end` is that of each operation's range.  Returns the changes."""
    ranges = np.zeros((kernels.COLUMNS - kernels.PROLONG) // 2 * 2, np.int64)
    for operation in OPERATIONS[kind]:
        ranges[2 * operation + 1] = end
    steps = np.array([[kernels.TURN if kind == TURN else kernels.SWEEP, 0, 0, *ranges]], np.int64)
    h = hierarchy
    scratch = aligned_zeros(max(channels, 2) * (h.longest_segment + 3 * LANES))
    changes = np.zeros(CHANGES, np.int32)
    kernels.run_steps(
        changes, x, b, h.weight, h.diagonal, h.share, h.edge_e, h.edge_s, h.coarsest.band, h.coarsest.cells, scratch,
        np.zeros(len(h.coarsest.band)), h.runs, h.segments, h.table, steps, channels,
    )  # fmt: skip
    return changes


def assert_same(region: np.ndarray, channels: int) -> None:
    hierarchy = build_hierarchy(region)
    if hierarchy.n_levels == 1:
        return
    # What right-hand sides hold outside the region means nothing.
    inside = np.concatenate(
        [
            np.tile(hierarchy.weight[line[OFFSET] : line[OFFSET] + 4 * line[QUARTER]] > 0, channels)
            for line in hierarchy.table[:-1]
        ]
    )
    for kind in (DOWN, TURN, UP):
        in_rows, in_waves = fields(hierarchy, channels), fields(hierarchy, channels)
        told = visit(kind, hierarchy, *in_rows, channels, kernels.WHOLE)
        segments = int(hierarchy.table[1, FIRST_SEGMENT])
        assert np.array_equal(told, visit(kind, hierarchy, *in_waves, channels, segments)), kind
        for one, other in zip(in_rows, in_waves, strict=True):
            assert np.array_equal(one.view(np.int32)[inside], other.view(np.int32)[inside]), kind
        assert not in_rows[0][~inside].any(), kind


def pays(region: np.ndarray) -> bool:
    h = build_hierarchy(region)
    return bool(kernels.rows_pay(h.runs, h.segments, h.table))


@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_bits_of_the_wave(shape, channels):
    assert_same(SHAPES[shape](*LARGE), channels)


@settings(max_examples=25, deadline=None)
@given(data=st.data(), height=st.integers(1, 24), width=st.integers(1, 40), channels=st.sampled_from([1, 3]))
def test_the_bits_of_the_wave_on_any_region(data, height, width, channels):
    """Whatever it costs, and not compiled: constants of compiled kernels cannot be changed."""
    region = data.draw(arrays(np.bool_, (height, width)))
    region[0, 0] = False
    if not region.any():
        return
    with pytest.MonkeyPatch.context() as patch, np.errstate(over="ignore"):  # places are counted modulo 2^64
        patch.setattr(kernels, "run_steps", kernels.run_steps.plain)
        patch.setattr(kernels, "rows_pay", lambda *_: True)
        assert_same(region, channels)


def test_it_is_what_large_simple_regions_get():
    assert pays(SHAPES["disk"](*LARGE))
    tall = np.ones((400, 10), np.bool_)  # its rows are too short
    tall[0] = False
    assert not pays(tall)
    scattered = np.zeros((100, 400), np.bool_)  # its rows would be visited for nothing
    scattered[1::8, 1:9] = True
    scattered[1::8, 300:350] = True
    assert not pays(scattered)
    assert not pays(np.zeros((50, 50), np.bool_))
