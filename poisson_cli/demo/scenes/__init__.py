"""What the gallery shows, in the order of the paper and then beyond it. A new scene is one more entry here.

The selections were drawn by eye, loosely on purpose: where the paper's method works, there is no need to be precise.
"""

from __future__ import annotations

from typing import Final

from poisson_cli.demo.scenes import altering, beyond, concealing, inserting, mixing, tiling

__all__ = ["SCENES"]

SCENES: Final = (
    *concealing.SCENES,
    *inserting.SCENES,
    *mixing.SCENES,
    *altering.SCENES,
    *tiling.SCENES,
    *beyond.SCENES,
)
"""Every scene, in the order of the page."""
