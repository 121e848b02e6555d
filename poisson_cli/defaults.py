"""Defaults that ``--help`` must show without importing what they belong to; tests hold each to its original."""

from __future__ import annotations

from typing import Final

__all__ = ["CYCLE", "FORMATS", "MAX_PIXELS", "THRESHOLD", "TOLERANCE"]

TOLERANCE: Final = 2e-4
"""Largest error allowed in any pixel, in levels; that of ``solvers``."""

CYCLE: Final = "F"
"""Multigrid cycle; that of ``solvers``."""

THRESHOLD: Final = 128
"""8-bit value from which a pixel of a mask picture is selected."""

FORMATS: Final = ("png", "jpg", "tif", "bmp", "webp", "ppm", "pfm", "hdr", "exr")
"""Usual endings of the formats that are written; those of ``poisson_cli.images``."""

MAX_PIXELS: Final = 500_000_000
"""Pixels of the largest picture that is read."""
