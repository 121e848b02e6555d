"""Handwritten solvers for the discrete Poisson equation on regions of any shape.

Knows grids and equations, nothing of pictures.  `PoissonProblem` states the equations, `solve_multigrid` and
`solve_sor` solve them, `SolveResult` says how well.
"""

from solvers.hierarchy import Hierarchy, build_hierarchy, describe
from solvers.multigrid import solve_multigrid
from solvers.problem import Guidance, OptionError, PoissonProblem
from solvers.result import SolveResult
from solvers.sor import solve_sor
from solvers.tolerance import DEFAULT_TOLERANCE

__all__ = [
    "DEFAULT_TOLERANCE",
    "Guidance",
    "Hierarchy",
    "OptionError",
    "PoissonProblem",
    "SolveResult",
    "build_hierarchy",
    "describe",
    "solve_multigrid",
    "solve_sor",
]
