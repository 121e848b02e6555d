"""The paper's tools on arrays: arrays in, arrays out, no files and no printing."""

from poisson_cli.editing.edges import find_edges
from poisson_cli.editing.report import Edit, EditReport
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.tools import (
    clone,
    fill,
    flatten,
    focus,
    heal,
    mix,
    recolor,
    relight,
    tile,
    tonemap,
)
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
