"""What holds for every picture and every mask, looked for with hypothesis.

The pictures are small floats, which are neither rounded nor clipped: the only slack that a comparison of two
answers needs is the tolerance of each.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from poisson_cli.editing import clone, fill, mix
from solvers import PoissonProblem, solve_multigrid
from tests import oracles
from tests.agreement import assert_untouched
from tests.tools import TOOLS

LEVEL = 1 / 255
TOLERANCE = 5e-4  # levels, asked for by name in every call, so that the slack is known
SLACK = 2.1 * TOLERANCE * LEVEL

checked = settings(max_examples=30, deadline=None, derandomize=True)


@st.composite
def scenes(draw: st.DrawFn, *, square: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Destination, source and mask of one size; the mask selects something."""
    height = draw(st.integers(1, 18))
    width = height if square else draw(st.integers(1, 18))
    channels = draw(st.sampled_from([(), (1,), (3,)]))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    destination, source = (rng.uniform(0, 1, (height, width, *channels)) for _ in range(2))
    kind = draw(st.sampled_from(["sparse", "half", "dense", "drawn"]))
    if kind == "drawn":
        mask = draw(arrays.arrays(bool, (height, width)))
    else:
        mask = rng.random((height, width)) < {"sparse": 0.1, "half": 0.5, "dense": 0.97}[kind]
    assume(mask.any())
    return destination, source, mask


offsets = st.tuples(st.integers(-12, 12), st.integers(-12, 12))


def edited(tool: str, scene: tuple[np.ndarray, np.ndarray, np.ndarray], **options: Any) -> np.ndarray:
    return TOOLS[tool].edit(*scene, tolerance=TOLERANCE, **options).image


def every_tool(*names: str) -> Any:
    return pytest.mark.parametrize("tool", names or ("clone", "average", "mix", "fill"))


@every_tool()
@checked
@given(scene=scenes())
def test_agrees_with_the_oracle(tool, scene):
    exact = TOOLS[tool].exact(*scene, by_loops=True)
    np.testing.assert_allclose(edited(tool, scene), exact, rtol=0, atol=TOLERANCE * LEVEL)


@every_tool("clone", "average", "mix")
@checked
@given(scene=scenes(), offset=offsets)
def test_agrees_with_the_oracle_wherever_the_source_lies(tool, scene, offset):
    destination, _, mask = scene
    region = oracles.region_of(mask, offset, mask.shape, "source", mask.shape)
    assume(region.any())
    image = edited(tool, scene, offset=offset)
    assert_untouched(image, destination, region)
    exact = TOOLS[tool].exact(*scene, offset=offset, by_loops=True)
    np.testing.assert_allclose(image, exact, rtol=0, atol=TOLERANCE * LEVEL)


@every_tool()
@checked
@given(scene=scenes())
def test_outside_the_region_not_a_bit_changes(tool, scene):
    destination, _, mask = scene
    assert_untouched(edited(tool, scene), destination, mask)


@every_tool("clone", "average", "mix")
@checked
@given(scene=scenes())
def test_a_picture_put_onto_itself_does_not_change(tool, scene):
    destination, _, mask = scene
    image = edited(tool, (destination, destination.copy(), mask))
    np.testing.assert_allclose(image, destination, rtol=0, atol=TOLERANCE * LEVEL)


@every_tool("clone", "average", "mix")
@checked
@given(scene=scenes(), shift=st.floats(-1, 1))
def test_a_constant_added_to_the_source_changes_nothing(tool, scene, shift):
    destination, source, mask = scene
    difference = edited(tool, (destination, source + shift, mask)) - edited(tool, scene)
    assert np.abs(difference).max() <= SLACK


@every_tool()
@checked
@given(scene=scenes(), gain=st.floats(0.2, 1.5), shift=st.floats(-1, 1))
def test_a_change_of_exposure_commutes_with_editing(tool, scene, gain, shift):
    """The equations are linear, and mixing compares variations that grow alike."""
    destination, source, mask = scene

    def exposed(picture):
        return gain * picture + shift

    before = edited(tool, (exposed(destination), exposed(source), mask))
    after = exposed(edited(tool, scene))
    assert np.abs(before - after).max() <= (1 + gain) * TOLERANCE * LEVEL * 1.05


@checked
@given(scene=scenes(), first=st.floats(-2, 2), second=st.floats(-2, 2))
def test_the_solution_is_linear_in_the_right_hand_side(scene, first, second):
    values, _, region = scene
    rng = np.random.default_rng(1)
    one, other = (rng.normal(size=values.shape) for _ in range(2))
    known = np.where(region.reshape(*region.shape, *[1] * (values.ndim - 2)), 0.0, values)

    def solve(known, rhs):
        return solve_multigrid(
            PoissonProblem(region, known, rhs=rhs, level=LEVEL), tolerance=TOLERANCE
        ).solution

    together = solve((first + second) * known, first * one + second * other)
    apart = first * solve(known, one) + second * solve(known, other)
    assert np.abs(together - apart).max() <= (1.05 + abs(first) + abs(second)) * TOLERANCE * LEVEL


@checked
@given(scene=scenes())
def test_a_fill_stays_between_the_darkest_and_the_brightest_known_neighbour(scene):
    """The maximum principle: a membrane has no peak of its own."""
    image, _, mask = scene
    assume(not mask.all())
    filled = edited("fill", scene)
    known = image[~mask]
    assert (filled[mask] <= known.max(axis=0) + SLACK).all()
    assert (filled[mask] >= known.min(axis=0) - SLACK).all()


@every_tool()
@checked
@given(scene=scenes())
def test_flips_commute_with_editing(tool, scene):
    for flip in (np.flipud, np.fliplr):
        flipped = edited(tool, tuple(flip(array) for array in scene))
        assert np.abs(flip(flipped) - edited(tool, scene)).max() <= SLACK


@every_tool()
@checked
@given(scene=scenes())
def test_transposition_commutes_with_editing(tool, scene):
    turned = edited(tool, tuple(np.swapaxes(array, 0, 1) for array in scene))
    assert np.abs(np.swapaxes(turned, 0, 1) - edited(tool, scene)).max() <= SLACK


@every_tool("clone", "average", "mix")
@checked
@given(scene=scenes(), offset=offsets)
def test_what_the_mask_leaves_out_of_the_source_has_no_say_but_next_to_the_region(tool, scene, offset):
    """Source pixels that neither lie in the region nor touch it may be anything."""
    destination, source, mask = scene
    near = mask.copy()
    near[1:] |= mask[:-1]
    near[:-1] |= mask[1:]
    near[:, 1:] |= mask[:, :-1]
    near[:, :-1] |= mask[:, 1:]
    assume(oracles.region_of(mask, offset, mask.shape, "source", mask.shape).any())
    other = source.copy()
    other[~near] = 0.123
    same = edited(tool, (destination, other, mask), offset=offset)
    np.testing.assert_array_equal(same, edited(tool, scene, offset=offset))


@checked
@given(scene=scenes())
def test_separate_masks_may_be_done_one_after_the_other(scene):
    """Two pieces that do not touch have nothing to say to each other."""
    image, _, mask = scene
    left, right = mask.copy(), mask.copy()
    middle = mask.shape[1] // 2
    left[:, middle:] = False
    right[:, : middle + 1] = False
    assume(left.any() and right.any())
    together = fill(image, left | right, tolerance=TOLERANCE).image
    apart = fill(fill(image, left, tolerance=TOLERANCE).image, right, tolerance=TOLERANCE).image
    assert np.abs(together - apart).max() <= SLACK


@pytest.mark.parametrize("ours", [clone, mix])
@checked
@given(scene=scenes(), offset=offsets, dtype=st.sampled_from([np.uint8, np.uint16]))
def test_integers_outside_the_region_are_the_same_bytes(ours, scene, offset, dtype):
    destination, source, mask = scene
    full = np.iinfo(dtype).max
    destination, source = ((picture * full).astype(dtype) for picture in (destination, source))
    region = oracles.region_of(mask, offset, mask.shape, "source", mask.shape)
    assume(region.any())
    assert_untouched(ours(destination, source, mask, offset=offset).image, destination, region)
