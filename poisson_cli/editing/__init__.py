"""The paper's tools on arrays: arrays in, arrays out, no files and no printing."""

from poisson_cli.editing.compose import Edit, EditReport
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.tools import clone, fill, mix

__all__ = ["Edit", "EditReport", "SolverOptions", "clone", "fill", "mix"]
