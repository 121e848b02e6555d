"""A table of text: aligned for a terminal, or Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence


def render(header: Sequence[str], rows: Sequence[Sequence[str]], *, markdown: bool = False) -> str:
    """First column to the left, the others to the right, as wide as their longest entry.

    >>> print(render(["a", "b"], [["x", "1"], ["long", "20"]]))
    a      b
    ----  --
    x      1
    long  20
    """
    lines = [list(header), *map(list, rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]

    def align(cells: Sequence[str]) -> list[str]:
        first, *others = zip(cells, widths, strict=True)
        return [first[0].ljust(first[1]), *(text.rjust(width) for text, width in others)]

    if markdown:
        rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
        return "\n".join(
            "| " + " | ".join(cells) + " |" for cells in (align(header), rule, *map(align, rows))
        )
    rule = ["-" * width for width in widths]
    return "\n".join("  ".join(cells).rstrip() for cells in (align(header), rule, *map(align, rows)))


def duration(seconds: float) -> str:
    """Three significant figures and a unit: `8.41 ms`, `1.25 s`."""
    if seconds >= 0.9995:
        return f"{three(seconds)} s"
    if seconds >= 0.9995e-3:
        return f"{three(seconds * 1e3)} ms"
    return f"{three(seconds * 1e6)} us"


def three(value: float) -> str:
    """Three significant figures without an exponent for whatever is neither tiny nor huge."""
    if math.isnan(value):
        return "-"
    if value == 0:
        return "0"
    if not 1e-4 <= abs(value) < 1e7:
        return f"{value:.1e}"
    if abs(value) >= 100:
        return f"{value:,.0f}"
    return f"{value:#.3g}"
