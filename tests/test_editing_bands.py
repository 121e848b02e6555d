"""Pictures are worked on a few rows at a time, and how many makes no difference."""

import numpy as np
import pytest

import solvers.canvas
from poisson_cli.editing import (
    Attenuate,
    Scale,
    Sieve,
    clone,
    flatten,
    focus,
    heal,
    mix,
    recolor,
    relight,
    tile,
)
from poisson_cli.editing.attenuation import gradient_norms
from tests.photographs import crop
from tests.regions import SHAPES

SIZE = (45, 38)
EDGES = np.add.outer(np.arange(SIZE[0]), np.arange(SIZE[1])) % 5 == 0

CALLS = {
    "flatten": lambda f, g, m, **o: flatten(f, m, edges=EDGES, **o),
    "relight": lambda f, g, m, **o: relight(f, m, beta=0.4, **o),
    "recolor": lambda f, g, m, **o: recolor(f, m, hue=70, saturation=1.3, **o),
    "decolor": lambda f, g, m, **o: recolor(f, m, decolor_background=True, **o),
    "focus": lambda f, g, m, **o: focus(f, m, amount=2, **o),
    "tile": lambda f, g, m, **o: tile(f, axis="x", **o),
    "heal": lambda f, g, m, **o: heal(f, m, offset=(0, 0), **o),
    "screen": lambda f, g, m, **o: clone(f, g, m, screen=0.01, robust=True, **o),
    "average then": lambda f, g, m, **o: clone(
        f, g, m, gradients="average", then=[Attenuate(), Scale(1.2)], **o
    ),
    "mix then": lambda f, g, m, **o: mix(f, g, m, then=[Attenuate(beta=-0.3), Sieve(EDGES)], **o),
}


@pytest.mark.parametrize("dtype", [np.uint8, np.float32, np.float64])
@pytest.mark.parametrize("space", ["rgb", "linear", "lab"])
@pytest.mark.parametrize("rescale", [False, True])
@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("shape", ["lasso", "noise", "unknown_frame"])
def test_bands_change_no_bit(call, shape, dtype, space, rescale, monkeypatch):
    scale = 1 if dtype is np.uint8 else 1 / 255
    f, g = ((crop(name, *SIZE) * np.float64(scale)).astype(dtype) for name in ("coffee.png", "chelsea.png"))
    whole = CALLS[call](f, g, SHAPES[shape](*SIZE), space=space, rescale=rescale)
    monkeypatch.setattr(solvers.canvas, "BAND", 1)
    monkeypatch.setattr(solvers.canvas, "FEWEST_ROWS", 2)
    banded = CALLS[call](f, g, SHAPES[shape](*SIZE), space=space, rescale=rescale)
    assert banded.image.tobytes() == whole.image.tobytes()
    for name in ("clipped", "overshoot", "scale", "outliers", "boundary_mismatch"):
        assert getattr(banded.report, name) == getattr(whole.report, name)


@pytest.mark.parametrize("shape", [(6, 7, 3), (1, 5, 1), (5, 1, 2), (2, 2, 1), (1, 1, 1)])
def test_norms_are_those_of_vectors_at_the_middle_of_pairs(shape):
    picture = np.random.default_rng(0).normal(size=shape)
    norms = gradient_norms(picture)
    height, width, _ = shape
    for row in range(height):
        for col in range(width - 1):
            beside = [
                picture[r, c] - picture[r + 1, c]
                for c in (col, col + 1)
                for r in (row - 1, row)
                if 0 <= r < height - 1
            ]
            down = np.mean(beside, axis=0) if beside else 0
            want = np.hypot(picture[row, col] - picture[row, col + 1], down)
            np.testing.assert_allclose(norms.across[row, col], want)
    turned = gradient_norms(picture.swapaxes(0, 1))
    np.testing.assert_allclose(turned.across, norms.down.swapaxes(0, 1))


def test_a_plane_has_one_norm_however_it_lies():
    for angle in np.linspace(0, np.pi, 7):
        plane = np.add.outer(np.sin(angle) * np.arange(8.0), np.cos(angle) * np.arange(9.0))[:, :, None]
        norms = gradient_norms(plane)
        np.testing.assert_allclose(norms.across, 1)
        np.testing.assert_allclose(norms.down, 1)
