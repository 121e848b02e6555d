"""The paper's tools on arrays: arrays in, arrays out, no files and no printing.

Each name is imported when it is first asked for: a process that clones has no use for the other tools.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from poisson_cli.editing.edges import find_edges
    from poisson_cli.editing.report import Edit, EditReport
    from poisson_cli.editing.solving import SolverOptions
    from poisson_cli.editing.tools.altering import flatten, focus, recolor, relight
    from poisson_cli.editing.tools.cloning import clone, fill, mix
    from poisson_cli.editing.tools.healing import heal
    from poisson_cli.editing.tools.tiling import tile
    from poisson_cli.editing.tools.tonemapping import tonemap
    from poisson_cli.editing.transforms import Attenuate, Scale, Sieve, Transform

__all__ = [
    "Attenuate",
    "Edit",
    "EditReport",
    "Scale",
    "Sieve",
    "SolverOptions",
    "Transform",
    "clone",
    "fill",
    "find_edges",
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
    "edges": ("find_edges",),
    "report": ("Edit", "EditReport"),
    "solving": ("SolverOptions",),
    "tools.altering": ("flatten", "focus", "recolor", "relight"),
    "tools.cloning": ("clone", "fill", "mix"),
    "tools.healing": ("heal",),
    "tools.tiling": ("tile",),
    "tools.tonemapping": ("tonemap",),
    "transforms": ("Attenuate", "Scale", "Sieve", "Transform"),
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, and keep it."""
    for home, names in _HOMES.items():
        if name in names:
            value = getattr(importlib.import_module(f"{__name__}.{home}"), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
