"""What the numbers that steer a tool may be."""

import math

from poisson_cli.errors import InputError

# Factors above this leave nothing of a picture, and in float32 no accuracy.
LARGEST_FACTOR = 1000.0


def check_number(
    name: str, value: float, low: float, high: float = math.inf, *, above_low: bool = False
) -> None:
    """InputError, naming the number, unless it lies in low ... high; `low` itself may be left out."""
    if math.isfinite(value) and (low < value or (value == low and not above_low)) and value <= high:
        return
    lower = f"above {low:g}" if above_low else f"from {low:g}"
    upper = "" if high == math.inf else f" and at most {high:g}" if above_low else f" to {high:g}"
    raise InputError(f"{name} is {value}, but must be a number {lower}{upper}")
