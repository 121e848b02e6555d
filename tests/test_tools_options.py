"""Every tool crossed with every option that all tools share, in every space it can be asked for.

The pictures are floats, which are neither rounded nor clipped: an answer may differ from the one with the default
options by the tolerances of both, and by no more.
"""

from typing import Any

import numpy as np
import pytest

from poisson_cli import editing
from poisson_cli.editing.transforms import Attenuate, Scale, Sieve
from poisson_cli.errors import InputError, NotConverged
from solvers import DEFAULT_TOLERANCE
from tests.photographs import crop
from tests.regions import lasso

SIZE = (64, 75)
MASK = lasso(*SIZE)
PICTURE = crop("coffee.png", *SIZE, top=150) / 255 * 0.6 + 0.2
SOURCE = crop("astronaut.png", *SIZE) / 255 * 0.6 + 0.2
EDGES = np.add.outer(2 * np.arange(SIZE[0]), np.arange(SIZE[1])) % 13 == 0
SPACES = ("rgb", "linear", "lab")

CALLS: dict[str, Any] = {
    "clone": lambda **o: editing.clone(PICTURE, SOURCE, MASK, **o),
    "clone, screened": lambda **o: editing.clone(PICTURE, SOURCE, MASK, screen=0.01, **o),
    "clone, robust": lambda **o: editing.clone(PICTURE, SOURCE, MASK, robust=True, **o),
    "clone, average": lambda **o: editing.clone(PICTURE, SOURCE, MASK, gradients="average", **o),
    "clone, monochrome": lambda **o: editing.clone(PICTURE, SOURCE, MASK, monochrome=True, **o),
    "clone, edited": lambda **o: editing.clone(
        PICTURE, SOURCE, MASK, then=[Sieve(EDGES), Scale(1.2), Attenuate()], **o
    ),
    "mix": lambda **o: editing.mix(PICTURE, SOURCE, MASK, **o),
    "mix, everything": lambda **o: editing.mix(
        PICTURE, SOURCE, MASK, then=[Attenuate(), Scale(0.8)], screen=0.02, robust=True, **o
    ),
    "fill": lambda **o: editing.fill(PICTURE, MASK, **o),
    "flatten": lambda **o: editing.flatten(PICTURE, MASK, edges=EDGES, **o),
    "relight": lambda **o: editing.relight(PICTURE, MASK, **o),
    "recolor": lambda **o: editing.recolor(PICTURE, MASK, gain=(1.2, 0.8, 0.7), hue=20.0, **o),
    "recolor, screened": lambda **o: editing.recolor(PICTURE, MASK, gain=(1.2, 0.8, 0.7), screen=0.01, **o),
    "recolor, decolored": lambda **o: editing.recolor(PICTURE, MASK, decolor_background=True, **o),
    "focus": lambda **o: editing.focus(PICTURE, MASK, amount=1.4, **o),
    "tile": lambda **o: editing.tile(PICTURE, **o),
    "tile, x": lambda **o: editing.tile(PICTURE, axis="x", **o),
    "tonemap": lambda **o: editing.tonemap(PICTURE, **o),
    "heal": lambda **o: editing.heal(PICTURE, MASK, offset=(2, -3), **o),
    "heal, searching": lambda **o: editing.heal(
        PICTURE, np.pad(MASK[16:48:2, 20:52:2], ((5, 43), (7, 52))), **o
    ),
}

every_call = pytest.mark.parametrize("call", CALLS)
every_space = pytest.mark.parametrize("space", SPACES)


@every_space
@every_call
@pytest.mark.parametrize(
    "options",
    [
        {"solver": "sor"},
        {"cycle": "V"},
        {"cycle": "W"},
        {"tolerance": 1e-6},
        {"tolerance": 0.05},
        {"certify": True},
    ],
    ids=str,
)
def test_solver_options(options, call, space):
    default = CALLS[call](space=space)
    edit = CALLS[call](space=space, **options)
    tolerance = options.get("tolerance", DEFAULT_TOLERANCE)
    assert np.abs(edit.image - default.image).max() * 255 <= 1.05 * (tolerance + DEFAULT_TOLERANCE)
    assert edit.report.error_estimate <= tolerance == edit.report.tolerance
    assert edit.report.space == space
    if "certify" in options:
        assert 0 <= edit.report.error_bound <= 0.05


@every_space
@every_call
def test_threads_change_no_bit(call, space):
    one, two = (CALLS[call](space=space, threads=threads).image for threads in (1, 2))
    assert one.tobytes() == two.tobytes()


@every_call
def test_progress_is_told_and_impatience_is_an_error(call):
    told: list[tuple[int, float]] = []
    CALLS[call](progress=lambda *state: told.append(state))
    assert told
    with pytest.raises(NotConverged, match="1 sweeps"):
        CALLS[call](solver="sor", max_iterations=1, tolerance=1e-9)


@every_call
def test_a_space_that_does_not_exist_is_named(call):
    with pytest.raises(InputError, match="'xyz'.*'rgb', 'linear', 'lab'"):
        CALLS[call](space="xyz")


@every_space
@pytest.mark.parametrize(
    "tool",
    [
        "clone",
        "clone, screened",
        "clone, edited",
        "mix",
        "flatten",
        "relight",
        "recolor",
        "focus",
        "tile",
        "heal",
    ],
)
def test_rescaling_what_fits_changes_no_bit(tool, space):
    plain, rescaled = CALLS[tool](space=space), CALLS[tool](space=space, rescale=True)
    if plain.report.overshoot == 0:
        assert rescaled.report.scale == 1
        assert rescaled.image.tobytes() == plain.image.tobytes()
    else:
        assert rescaled.report.scale < 1
        assert rescaled.image.min() >= 0 and rescaled.image.max() <= 1


@every_space
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_rescaling_leaves_nothing_to_clip(dtype, space):
    full = 1 if np.dtype(dtype).kind == "f" else np.iinfo(dtype).max
    picture = (crop("astronaut.png", *SIZE) / 255 * full).astype(dtype)
    plain = editing.focus(picture, MASK, amount=5.0, space=space)
    fitted = editing.focus(picture, MASK, amount=5.0, space=space, rescale=True)
    assert plain.report.overshoot > 1
    assert fitted.report.overshoot <= 0.01 and fitted.report.clipped == 0
    assert 0 < fitted.report.scale < 1
    assert fitted.image[~MASK].tobytes() == picture[~MASK].tobytes()
