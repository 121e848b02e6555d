"""Selections: which pixels to edit, from mask pictures and rectangles to one bool array."""

from __future__ import annotations

from poisson_cli.masks.raster import strength
from poisson_cli.masks.selection import Canvas, select
from poisson_cli.masks.shapes import draw_rectangle

__all__ = ["Canvas", "draw_rectangle", "select", "strength"]
