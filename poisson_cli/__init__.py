"""Exact Poisson image editing: seamless cloning, and editing in place, on selections of any shape.

The functions take arrays and return the edited image::

    import poisson_cli
    result = poisson_cli.clone(destination, source, mask, offset=(row, column))

The same functions in `poisson_cli.editing` return an `Edit` instead: the image and a report on how it was made.
Nothing heavy is imported before one of them is asked for.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from poisson_cli.api import clone, fill, flatten, focus, heal, mix, recolor, relight, tile, tonemap
    from poisson_cli.errors import InputError, NotConverged, OutputError, PoissonError

__version__ = "0.1.0"

__all__ = [
    "InputError",
    "NotConverged",
    "OutputError",
    "PoissonError",
    "__version__",
    "clone",
    "fill",
    "flatten",
    "focus",
    "heal",
    "mix",
    "recolor",
    "relight",
    "tile",
    "tonemap",
]

_HOMES = {
    "clone": "poisson_cli.api",
    "fill": "poisson_cli.api",
    "flatten": "poisson_cli.api",
    "focus": "poisson_cli.api",
    "heal": "poisson_cli.api",
    "mix": "poisson_cli.api",
    "recolor": "poisson_cli.api",
    "relight": "poisson_cli.api",
    "tile": "poisson_cli.api",
    "tonemap": "poisson_cli.api",
    "InputError": "poisson_cli.errors",
    "NotConverged": "poisson_cli.errors",
    "OutputError": "poisson_cli.errors",
    "PoissonError": "poisson_cli.errors",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, and keep it."""
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
