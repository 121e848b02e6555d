"""Sections 3 and 4 of the paper, each tool a few lines over one pipeline.

Pictures are (H, W) or (H, W, C) arrays of uint8, uint16, float32 or float64; floats have full scale 1.  The result
has the destination's shape and dtype; outside the selection it is the destination, bit for bit.  No argument is
modified.

The functions here return an `Edit`: the picture and a report.  `poisson_cli.clone` and so on are the same functions
and return the picture alone.
"""

from poisson_cli.editing.tools.altering import flatten, focus, recolor, relight
from poisson_cli.editing.tools.cloning import clone, fill, mix
from poisson_cli.editing.tools.healing import heal
from poisson_cli.editing.tools.tiling import tile
from poisson_cli.editing.tools.tonemapping import tonemap

__all__ = ["clone", "fill", "flatten", "focus", "heal", "mix", "recolor", "relight", "tile", "tonemap"]
