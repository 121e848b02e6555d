"""Defaults that ``--help`` must show without importing what they belong to; tests hold each to its original."""

from __future__ import annotations

from typing import Final

__all__ = [
    "ALPHA",
    "BETA",
    "CYCLE",
    "FORMATS",
    "HIGH",
    "LOW",
    "MAX_PIXELS",
    "SIGMA",
    "THRESHOLD",
    "TOLERANCE",
]

TOLERANCE: Final = 2e-4
"""Largest error allowed in any pixel, in levels; that of ``solvers``."""

CYCLE: Final = "F"
"""Multigrid cycle; that of ``solvers``."""

THRESHOLD: Final = 128
"""8-bit value from which a pixel of a mask picture is selected."""

LOW: Final = 4
HIGH: Final = 9
SIGMA: Final = 1
"""Canny's thresholds, in levels per pixel, and the blur before it, in pixels; those of ``flatten``."""

ALPHA: Final = 0.2
BETA: Final = 0.2
"""What eq. (16) attenuates by; those of ``relight``."""

FORMATS: Final = ("png", "jpg", "tif", "bmp", "webp", "ppm", "pfm", "hdr", "exr")
"""Usual endings of the formats that are written; those of ``poisson_cli.images``."""

MAX_PIXELS: Final = 500_000_000
"""Pixels of the largest picture that is read."""
