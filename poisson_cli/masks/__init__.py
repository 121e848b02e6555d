"""Selections: which pixels to edit, from mask files and shapes to one bool array.

`select` does all that the command line can; the functions below it work on arrays and can be used alone::

    from poisson_cli import masks
    from poisson_cli.settings import Polygon
    mask = masks.draw_polygon(Polygon(((10, 10), (10, 90), (50, 50))), shape=(100, 100))
    mask = masks.grow(mask, 3)

`poisson_cli.masks.plan` reads a selection from JSON.
"""

from __future__ import annotations

from poisson_cli.masks.canvas import Canvas
from poisson_cli.masks.growth import grow, shrink
from poisson_cli.masks.opacity import leave_out_transparent
from poisson_cli.masks.overlay import show
from poisson_cli.masks.points import parse_points
from poisson_cli.masks.raster import strength
from poisson_cli.masks.selection import Selected, select
from poisson_cli.masks.shapes import draw_ellipse, draw_polygon, draw_rectangle
from poisson_cli.masks.source import decode_mask, read_mask

__all__ = [
    "Canvas",
    "Selected",
    "decode_mask",
    "draw_ellipse",
    "draw_polygon",
    "draw_rectangle",
    "grow",
    "leave_out_transparent",
    "parse_points",
    "read_mask",
    "select",
    "show",
    "shrink",
    "strength",
]
