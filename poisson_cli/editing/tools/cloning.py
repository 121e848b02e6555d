"""Section 3: gradients imported from a source, and the membrane that needs none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Unpack

from numpy.typing import NDArray

from poisson_cli.editing import colour, guidance, tone
from poisson_cli.editing.compose import compose
from poisson_cli.editing.guidance import GRADIENTS, Gradients
from poisson_cli.editing.placement import MaskOn, place
from poisson_cli.editing.report import Edit
from poisson_cli.editing.scene import Scene
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.spaces import SpaceName, named
from poisson_cli.errors import InputError

if TYPE_CHECKING:
    from poisson_cli.editing.transforms import Transform


def clone(
    destination: NDArray[Any],
    source: NDArray[Any],
    mask: NDArray[Any],
    *,
    offset: tuple[int, int] = (0, 0),
    mask_on: MaskOn = "source",
    gradients: Gradients = "source",
    monochrome: bool = False,
    then: Sequence[Transform] = (),
    screen: float = 0.0,
    robust: bool = False,
    rescale: bool = False,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """Seamless cloning: the source's gradients inside, the destination's values at the rim (eqs. 9-11).

    Parameters
    ----------
    destination, source : (H, W) or (H, W, C) array
        f* and g, of one dtype.  A grey source is spread over the channels of a colour destination.
    mask : (H, W) array
        True or non-zero = edit; of the source's size, or the destination's (`mask_on`).
    offset : (row, column)
        The source's top left corner on the destination; may be negative.  Overhang is clipped.
    mask_on : {"source", "destination"}
        Whose pixels the mask speaks of.
    gradients : {"source", "average"}
        "average" takes the mean of both pictures' gradients (Fig. 6c).
    monochrome : bool
        Import the source's luminance only, not its colours (Fig. 5).
    then : sequence of Transform
        What to do with the guidance before it is integrated, in this order: `Sieve`, `Scale`, `Attenuate`.
    screen : float
        Keeps the source's own colour away from the rim, within about 1 / sqrt(screen) pixels of it: adds
        screen * (f - g) to the equations, per pixel.  0 is the paper's equation.
    robust : bool
        Boundary pixels whose mismatch f* - g is an outlier count less, so that an object which the selection touches
        does not bleed into it.
    rescale : bool
        Fit the result into the range of the picture, so that nothing is clipped: colours that would leave it lose just
        enough saturation, at equal luminance, and where the luminance would, the guidance is multiplied by the largest
        number below 1 with which it does not.
    space : {"rgb", "linear", "lab"}
        Solve in the values as stored (the paper's choice), in linear light (sRGB decoded), or in CIE-Lab (D65).  Floats
        that are linear light already are for "rgb".
    **options
        See `SolverOptions`.

    Returns
    -------
    Edit
        ``.image`` and ``.report``; `poisson_cli.clone` returns the image alone.

    Raises
    ------
    InputError
        If the pictures, the mask and the options do not fit together.  It is also a ValueError.
    NotConverged
        If `max_iterations` was too small.

    Examples
    --------
    >>> import numpy as np
    >>> sky = np.full((5, 5), 100, np.uint8)
    >>> star = np.zeros((3, 3), np.uint8)
    >>> star[1, 1] = 40
    >>> clone(sky, star, star > 0, offset=(1, 1)).image[2]
    array([100, 100, 140, 100, 100], dtype=uint8)
    """
    if gradients not in GRADIENTS:
        raise InputError(f"gradients is {gradients!r}, but must be one of {', '.join(map(repr, GRADIENTS))}")
    destination, source = _check_pair(destination, source)
    if monochrome:
        tone.check_luminance("source", source.shape[2] if source.ndim == 3 else 1)
    placement = place(destination.shape, source.shape, mask, offset=offset, mask_on=mask_on)
    scene = Scene(destination, placement, source, colour.luminance if monochrome else None)
    return compose(
        "clone",
        scene,
        GRADIENTS[gradients],
        named(space, destination.dtype),
        then=then,
        screen=screen,
        robust=robust,
        rescale=rescale,
        **options,
    )


def mix(
    destination: NDArray[Any],
    source: NDArray[Any],
    mask: NDArray[Any],
    *,
    offset: tuple[int, int] = (0, 0),
    mask_on: MaskOn = "source",
    then: Sequence[Transform] = (),
    screen: float = 0.0,
    robust: bool = False,
    rescale: bool = False,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """Mixing gradients: of each pixel pair the stronger gradient of both pictures (eq. 13).

    For objects with holes, transparent ones, and text: what is flat in the source lets the destination through.
    Parameters, errors and result are those of `clone`.  A `screen` draws the result to the source, where that is flat
    as well: little of it lets the destination through.
    """
    destination, source = _check_pair(destination, source)
    placement = place(destination.shape, source.shape, mask, offset=offset, mask_on=mask_on)
    return compose(
        "mix",
        Scene(destination, placement, source),
        guidance.mixed,
        named(space, destination.dtype),
        then=then,
        screen=screen,
        robust=robust,
        rescale=rescale,
        **options,
    )


def fill(
    image: NDArray[Any],
    mask: NDArray[Any],
    *,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """The membrane: the selection filled as smoothly as its rim allows (eq. 2).

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
    mask : (H, W) array
        True or non-zero = fill.  What the picture holds there has no influence, unless everything is selected: then the
        result is the picture's mean.
    space, **options
        See `clone`.
    """
    image = tone.check_picture("image", image)
    placement = place(image.shape, image.shape, mask)
    return compose("fill", Scene(image, placement), guidance.membrane, named(space, image.dtype), **options)


def _check_pair(destination: Any, source: Any) -> tuple[NDArray[Any], NDArray[Any]]:
    """Both pictures as arrays of one depth."""
    destination = tone.check_picture("destination", destination)
    source = tone.check_picture("source", source)
    if destination.dtype != source.dtype:
        raise InputError(
            f"the source is {source.dtype} but the destination is {destination.dtype}: convert the source first"
        )
    return destination, source
