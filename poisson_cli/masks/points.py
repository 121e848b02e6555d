"""Corners of a polygon as people write them: ``x,y x,y x,y``."""

from __future__ import annotations

import re
from typing import Final

from poisson_cli.errors import InputError

__all__ = ["FARTHEST", "MOST_POINTS", "parse_points"]

FARTHEST: Final = 1e9
"""Pixels; no picture is that large, and coordinates up to here can be reckoned with without a thought."""

MOST_POINTS: Final = 1_000_000
"""Corners of one polygon."""

_LONGEST_TEXT: Final = 1 << 25
"""Characters."""

_LONGEST: Final = 100
"""Characters of a point; whoever writes more means something else."""

_NUMBER: Final = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_POINT: Final = re.compile(rf"({_NUMBER}),({_NUMBER})")
_BLANKS: Final = re.compile(r"\s+")
_COMMENT: Final = re.compile(r"#[^\n]*")


def parse_points(text: str) -> tuple[tuple[float, float], ...]:
    """Read the corners of a polygon.

    Parameters
    ----------
    text
        Points ``x,y`` separated by blanks or line breaks; numbers may be fractions. From ``#`` to the end of a line is
        a comment.

    Returns
    -------
    tuple of (float, float)
        (row, column) of each corner, at least three.

    Raises
    ------
    InputError
        If something else stands there, a number is too large, or there are too few points or too many.

    Examples
    --------
    >>> parse_points("0,0  4.5,0  4.5,-2")
    ((0.0, 0.0), (0.0, 4.5), (-2.0, 4.5))
    """
    if text.count(",") > MOST_POINTS or len(text) > _LONGEST_TEXT:
        raise InputError(f"a polygon with more than {MOST_POINTS:,} corners; simplify it")
    points = []
    for number, line in enumerate(_COMMENT.sub("", text).split("\n"), start=1):
        for word in _BLANKS.sub(" ", line).replace(" ,", ",").replace(", ", ",").split():
            match = _POINT.fullmatch(word) if len(word) <= _LONGEST else None
            if match is None:
                shown = word if len(word) <= 40 else word[:37] + "..."
                where = f" in line {number}" if "\n" in text else ""
                raise InputError(f"{shown!r}{where} is not a point X,Y, for example 12,34.5")
            x, y = float(match[1]), float(match[2])
            if abs(x) > FARTHEST or abs(y) > FARTHEST:
                raise InputError(f"the point {match[0][:40]} is farther away than {FARTHEST:,.0f} pixels")
            points.append((y, x))
    if len(points) < 3:
        raise InputError(f"a polygon needs at least 3 points X,Y, not {len(points)}")
    return tuple(points)
