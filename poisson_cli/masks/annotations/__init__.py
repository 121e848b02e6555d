"""Annotation files: outlines and masks of things, with names, in JSON."""

from __future__ import annotations

from poisson_cli.masks.annotations.reading import draw_annotations

__all__ = ["draw_annotations"]
