"""Section 4: a picture edited in place."""

from time import perf_counter
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import colour, guidance, tone
from poisson_cli.editing.attenuation import attenuating
from poisson_cli.editing.compose import compose
from poisson_cli.editing.edges import HIGH, LOW, SIGMA, find_edges
from poisson_cli.editing.logarithm import LogChannels, LogLuminance
from poisson_cli.editing.placement import place
from poisson_cli.editing.recoloring import recoloring
from poisson_cli.editing.report import Edit
from poisson_cli.editing.scene import Scene
from poisson_cli.editing.solving import SolverOptions
from poisson_cli.editing.spaces import SpaceName, named
from poisson_cli.editing.transforms import ALPHA, BETA, Scale, Sieve, Transform, check_edges
from solvers.canvas import bands


def flatten(
    image: NDArray[Any],
    mask: NDArray[Any],
    *,
    edges: NDArray[Any] | None = None,
    low: float = LOW,
    high: float = HIGH,
    sigma: float = SIGMA,
    rescale: bool = False,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """Texture flattening: the gradient survives only where an edge lies between two pixels (eqs. 14-15).

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
    mask : (H, W) array
        True or non-zero = edit.
    edges : (H, W) array, optional
        Non-zero = edge.  v_pq is kept if p or q (or both) is an edge pixel.  Without them: `find_edges` in the whole
        picture, so that the selection's outline is no edge; this needs OpenCV, the extra ``edges``.
    low, high, sigma : float
        See `find_edges`; of no effect if `edges` are given.
    rescale, space, **options
        See `clone`.
    """
    scene = _scene(image, mask)
    size = scene.destination.shape[:2]
    finding = {}
    if edges is None:
        start = perf_counter()
        edges = find_edges(scene.destination, low=low, high=high, sigma=sigma)
        finding = {"edges": perf_counter() - start}
    edges = check_edges(edges, size, "image")
    edit = _in_place("flatten", scene, Sieve(edges), rescale=rescale, space=space, **options)
    placement = scene.placement
    share = placement.on_destination(edges)[placement.region].mean()
    return edit.reporting(finding, edge_share=float(share))


def relight(
    image: NDArray[Any],
    mask: NDArray[Any],
    *,
    alpha: float = ALPHA,
    beta: float = BETA,
    per_channel: bool = False,
    rescale: bool = False,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """Local illumination changes, in the log domain (eq. 16): v = a^beta |grad L|^-beta grad L.

    L is the log of the picture's luminance, Y = .2126 R + .7152 G + .0722 B of the values as stored (of linear light
    with ``space="linear"``, L* with ``space="lab"``); where Y is less than that of a grey of half a level (1/510 of
    full scale), it is taken to be that.  The solution u = (new L) - L, zero on the boundary, brightens all channels
    of the space alike: new value = value * exp(u), so that colours keep their ratios, and black stays black.

    On a pixel pair p, q the norm |grad L| is that of (L_p - L_q, d), d being the mean of the differences between
    neighbours along the other axis that p or q takes part in, as many of the four as lie inside the picture.
    a is `alpha` times the mean of |grad L| over all pixel pairs with at least one pixel in Omega.  Where |grad L| is
    zero, so is v.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
        C is 1 or 3, unless `per_channel`.
    mask : (H, W) array
        True or non-zero = edit.
    alpha : float
        Positive, at most 1000: gradients above a become smaller, those below it larger.
    beta : float
        From -1 to 1; 0 changes nothing, a negative one makes large gradients larger.
    per_channel : bool
        The log of each channel by itself takes the place of L, with a norm and an a of its own.  Not in Lab.
    rescale, space, **options
        See `clone`.
    """
    scene = _scene(image, mask)
    domain = (LogChannels if per_channel else LogLuminance)(named(space, scene.destination.dtype))
    logs = scene.layer("destination", domain)
    attenuated = attenuating([logs], scene.placement.region, alpha=alpha, beta=beta)
    return compose("relight", scene, guidance.own, domain, then=[attenuated], rescale=rescale, **options)


def recolor(
    image: NDArray[Any],
    mask: NDArray[Any],
    *,
    gain: tuple[float, float, float] = (1.0, 1.0, 1.0),
    hue: float = 0.0,
    saturation: float = 1.0,
    decolor_background: bool = False,
    screen: float = 0.0,
    rescale: bool = False,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """Local colour changes: a recoloured copy of the picture cloned into the picture (Fig. 11).

    The copy g is first multiplied by `gain`, in R, G and B as stored and without clipping, then `hue` degrees are added
    to the hue angle of CIE-Lab (D65), and its chroma is multiplied by `saturation`; g is not clipped then either.

    Parameters
    ----------
    image : (H, W, 3) array
    mask : (H, W) array
        True or non-zero = edit.
    gain : (red, green, blue)
        From 0 to 1000.
    hue : float
        Degrees.
    saturation : float
        From 0 to 1000; 0 is grey.
    decolor_background : bool
        f* is the picture's luminance, in all three channels and as the picture's dtype stores it (rounded half to
        even): that is what the output shows outside the selection.  The colour that the boundary loses is missing
        inside as well, where greys turn to its opposite; a `screen` of .0005 keeps them.
    screen, rescale, space, **options
        See `clone`.
    """
    scene = _scene(image, mask)
    picture = scene.destination
    tone.check_colours("image", 1 if picture.ndim == 2 else picture.shape[2])
    if decolor_background:
        picture = _luminance_of(picture)
    look = recoloring(gain, hue, saturation, tone.FULL_SCALE[picture.dtype.type])
    return compose(
        "recolor",
        Scene(picture, scene.placement, scene.destination, look),
        guidance.imported,
        named(space, picture.dtype),
        screen=screen,
        rescale=rescale,
        **options,
    )


def focus(
    image: NDArray[Any],
    mask: NDArray[Any],
    *,
    amount: float,
    rescale: bool = False,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """An apparent change of focus: v = amount * grad f* (the paper's conclusion).

    Coarse gradients are multiplied as well as fine ones: below 1 the selection loses contrast, like in haze, and takes
    the colours of its border.  That is no blur, and no depth of field.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
    mask : (H, W) array
        True or non-zero = edit.
    amount : float
        From 0 to 1000.  Above 1 sharper, below 1 softer, 0 the membrane.
    rescale, space, **options
        See `clone`.
    """
    return _in_place("focus", _scene(image, mask), Scale(amount), rescale=rescale, space=space, **options)


def _scene(image: Any, mask: NDArray[Any]) -> Scene:
    """A picture that is edited in place."""
    image = tone.check_picture("image", image)
    return Scene(image, place(image.shape, image.shape, mask))


def _in_place(
    tool: str,
    scene: Scene,
    transform: Transform,
    *,
    rescale: bool,
    space: SpaceName,
    **options: Unpack[SolverOptions],
) -> Edit:
    """The picture's own gradients, transformed."""
    domain = named(space, scene.destination.dtype)
    return compose(tool, scene, guidance.own, domain, then=[transform], rescale=rescale, **options)


def _luminance_of(picture: NDArray[Any]) -> NDArray[Any]:
    """The luminance in all three channels, as the picture's dtype stores it."""
    grey = np.empty_like(picture)
    for first, end in bands(0, len(picture), picture[0].size):
        part = picture[first:end].astype(
            np.float64
        )  # in float32 a 16-bit value may be rounded to another one
        grey[first:end] = tone.to_storage(colour.luminance(part), picture.dtype)
    return grey
