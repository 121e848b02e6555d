"""Defaults that were chosen by looking at photographs: what was seen, as numbers."""

import numpy as np

from poisson_cli.editing import flatten, tonemap
from tests.photographs import photograph


def test_a_flag_does_not_glow():
    """Red and blue are what leaves the range first: at a saturation of .8 a twentieth of all values does."""
    image = photograph("astronaut.png")
    assert tonemap(image).report.clipped < 0.025 * image.size
    assert tonemap(image, saturation=0.8).report.clipped > 0.05 * image.size


def test_fur_keeps_its_pattern():
    """With Canny's thresholds at 6 and 12 so few edges are left that colours of the background run into a cat."""
    image = photograph("chelsea.png")
    mask = np.zeros(image.shape[:2], bool)
    mask[40:260, 80:340] = True
    shares = [
        flatten(image, mask, **thresholds).report.edge_share for thresholds in ({}, {"low": 6, "high": 12})
    ]
    assert 0.1 < shares[0] < 0.25
    assert shares[1] < 0.75 * shares[0]
