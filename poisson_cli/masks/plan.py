"""A selection as JSON, for whoever describes edits in files::

    {
      "mask": ["bird.png:alpha", "coco.json:17"],
      "selection": [
        {"rect": [0, 0, 50, 50]},
        {"subtract": {"ellipse": [10, 10, 20, 20]}},
        {"intersect": {"polygon": [[1, 2], [30.5, 4], [5, 60]]}},
        {"grow": 3}
      ],
      "invert_mask": false,
      "mask_threshold": 128
    }

The words are those of the command line, and so are the numbers: x before y. Every key may be left out; what ``mask``
names is joined before the steps of ``selection`` are done in their order.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Literal, cast

from poisson_cli import defaults
from poisson_cli.errors import InputError
from poisson_cli.masks.annotations.document import coordinates, items, mapping, shown
from poisson_cli.masks.points import MOST_POINTS
from poisson_cli.settings import (
    Area,
    Combine,
    Ellipse,
    Grow,
    How,
    MaskFile,
    Polygon,
    Rectangle,
    Selection,
)

__all__ = ["KEYS", "selection_of"]

KEYS: Final = ("mask", "selection", "invert_mask", "mask_threshold")
"""The keys that describe a selection."""

_MOST: Final = 999_999_999
_AREAS: Final = ("mask", "rect", "ellipse", "polygon", "lasso")


def selection_of(description: Mapping[str, Any]) -> Selection:
    """Read a selection from JSON values.

    Parameters
    ----------
    description
        A JSON object; only its `KEYS` are looked at.

    Returns
    -------
    Selection
        What the same words mean on the command line.

    Raises
    ------
    InputError
        If a value makes no sense, or nothing is selected.

    Examples
    --------
    >>> selection_of({"selection": [{"rect": [10, 20, 300, 200]}, {"grow": 2}]}).steps[1]
    Grow(pixels=2)
    """
    masks = description.get("mask", [])
    masks = [masks] if isinstance(masks, str) else items(masks, '"mask"')
    steps: list[Combine | Grow] = [Combine(_area("mask", name)) for name in masks]
    listed = items(description.get("selection", []), '"selection"')
    steps += [_step(step, f"step {number} of the selection") for number, step in enumerate(listed, start=1)]
    if not steps:
        raise InputError('no selection: name a mask with "mask", or shapes with "selection"')
    if isinstance(steps[0], Grow) or steps[0].how != "add":
        raise InputError(
            "the first step of the selection works on what was selected before it, and nothing was"
        )
    invert = description.get("invert_mask", False)
    if not isinstance(invert, bool):
        raise InputError(f'"invert_mask" is {shown(invert)}, not true or false')
    threshold = description.get("mask_threshold", defaults.THRESHOLD)
    return Selection(tuple(steps), invert, _whole(threshold, 1, 255, '"mask_threshold"'))


def _step(value: Any, what: str) -> Combine | Grow:
    """One step: an object with a single key."""
    word, inner = _single(value, what)
    if word in ("grow", "shrink"):
        pixels = _whole(inner, 1, _MOST, f'"{word}" of {what}')
        return Grow(pixels if word == "grow" else -pixels)
    if word in ("add", "subtract", "intersect"):
        area, inner = _single(inner, f'"{word}" of {what}')
        return Combine(_area(area, inner), cast("How", word))
    return Combine(_area(word, inner))


def _single(value: Any, what: str) -> tuple[str, Any]:
    pairs = list(mapping(value, what).items())
    if len(pairs) != 1:
        raise InputError(f'{what} has {len(pairs)} keys, not one, as in {{"rect": [10, 20, 300, 200]}}')
    return pairs[0]


def _area(word: str, value: Any) -> Area:
    match word:
        case "mask":
            if not isinstance(value, str) or "\0" in value:
                raise InputError(f'"mask" is {shown(value)}, not the name of a file')
            return MaskFile(value)
        case "rect":
            return _box(value, '"rect"')
        case "ellipse":
            return Ellipse(_box(value, '"ellipse"'))
        case "polygon":
            return _polygon(value, "even-odd", '"polygon"')
        case "lasso":
            return _polygon(value, "nonzero", '"lasso"')
    raise InputError(
        f"a selection has no {shown(word)}; it has {', '.join(_AREAS)}, and steps grow and shrink"
    )


def _box(value: Any, what: str) -> Rectangle:
    numbers = items(value, what)
    if len(numbers) != 4:
        raise InputError(f"{what} has {len(numbers)} numbers, not x, y, width and height")
    x, y = (_whole(number, -_MOST, _MOST, what) for number in numbers[:2])
    width, height = (_whole(number, 1, _MOST, what) for number in numbers[2:])
    return Rectangle(row=y, col=x, height=height, width=width)


def _polygon(value: Any, rule: Literal["even-odd", "nonzero"], what: str) -> Polygon:
    points = [items(point, f"a point of {what}") for point in items(value, what)]
    if not 3 <= len(points) <= MOST_POINTS or any(len(point) != 2 for point in points):
        raise InputError(f"{what} has {len(points):,} points, not 3 to {MOST_POINTS:,} of x and y")
    pairs = (coordinates(point, what).tolist() for point in points)
    return Polygon(tuple((y, x) for x, y in pairs), rule)


def _whole(value: Any, least: int, most: int, what: str) -> int:
    if type(value) is not int or not least <= value <= most:
        raise InputError(f"{what} has {shown(value)}, not a whole number from {least} to {most}")
    return value
