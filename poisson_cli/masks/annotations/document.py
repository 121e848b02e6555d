"""What a JSON document holds, asked for with care: whatever is there instead becomes one `InputError`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.masks.points import FARTHEST

__all__ = ["LARGEST", "choices", "coordinates", "items", "load", "mapping", "picture_size", "shown"]

LARGEST: Final = 1 << 25
"""Characters of a document; read into memory it can be forty times as large."""


def load(text: str) -> Any:
    """Parse a JSON document.

    Raises
    ------
    InputError
        If it is none, or too large.
    """
    if len(text) > LARGEST:
        raise InputError(
            f"more than {LARGEST:,} characters of JSON; save the annotations of this picture in a file of their own"
        )
    try:
        return json.loads(text)
    except RecursionError as error:
        raise InputError("JSON that is nested too deeply") from error
    except ValueError as error:  # not JSON, or a number of thousands of digits
        raise InputError(f"damaged JSON ({error})") from error


def mapping(value: Any, what: str) -> dict[str, Any]:
    """The value, which must be a JSON object."""
    if not isinstance(value, dict):
        raise InputError(f"{what} is {shown(value)}, not an object")
    return value


def items(value: Any, what: str) -> list[Any]:
    """The value, which must be a list."""
    if not isinstance(value, list):
        raise InputError(f"{what} is {shown(value)}, not a list")
    return value


def coordinates(values: Sequence[Any], what: str) -> NDArray[np.float64]:
    """Coordinates as float64, which must all be numbers, finite and of a size that a picture can have."""
    for value in values:
        if (
            type(value) not in (int, float) or not -FARTHEST <= value <= FARTHEST
        ):  # NaN is not between anything
            raise InputError(f"{what} has {shown(value)} where a coordinate should be")
    return np.array(values, np.float64)


def picture_size(height: Any, width: Any, what: str) -> tuple[int, int]:
    """(H, W) of the picture that something was made for."""
    for side in (height, width):
        if type(side) is not int or side < 0:
            raise InputError(f"{what} is for a picture whose height or width is {shown(side)}")
    return height, width


def choices(names: Sequence[str]) -> str:
    """Some of the names that there are, for a message."""
    few = sorted(set(names))
    more = f" and {len(few) - 8:,} more" if len(few) > 8 else ""
    return ", ".join(map(shown, few[:8])) + more if few else "none"


def shown(value: Any) -> str:
    """A value as short text for a message."""
    if isinstance(value, dict | list):
        return "an object" if isinstance(value, dict) else "a list"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else text[:37] + "..."
