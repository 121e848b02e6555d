"""The whole-image relative of the paper's tools: gradient domain compression of the dynamic range."""

from typing import Any, Unpack

from numpy.typing import NDArray

from poisson_cli.editing.report import Edit
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.spaces import SpaceName


def tonemap(
    image: NDArray[Any],
    *,
    alpha: float = 0.1,
    beta: float = 0.15,
    saturation: float = 0.8,
    white: float = 99.5,
    gamma: float = 1.0,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """Dynamic range compression of a whole picture (Fattal et al. 2002).  Details follow in this docstring.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
        C is 1 or 3.
    alpha : float
        Gradients above alpha times the mean gradient norm are made smaller, those below larger, scale by scale.
    beta : float
        How strongly; 0 leaves all gradients as they are.  Fattal et al. write 1 - beta.
    saturation : float
        Exponent of the colour ratios: 1 keeps them, less is paler.
    white : float
        Percentile of the new luminance that becomes full scale.
    gamma : float
        The new luminance is raised to 1 / gamma; for pictures that store linear light.
    space, **options
        See `clone`.
    """
    raise NotImplementedError
