"""The whole-image relative of the paper's tools: gradient domain compression of the dynamic range."""

from functools import partial
from time import perf_counter
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from poisson_cli.editing import tone
from poisson_cli.editing.numbers import LARGEST_FACTOR, check_number
from poisson_cli.editing.pyramid import attenuation_map
from poisson_cli.editing.report import Edit, report_on
from poisson_cli.editing.solving import SolverOptions, solve
from poisson_cli.editing.spaces import Space, SpaceName, named
from poisson_cli.errors import InputError
from solvers import Guidance, PoissonProblem
from solvers.canvas import Values

# Far beyond what can be looked at; the ratios of colours, which are up to 14, may be raised to one over the other.
LARGEST_SATURATION = 10.0
GAMMAS = 0.5, 10.0


def tonemap(
    image: NDArray[Any],
    *,
    alpha: float = 0.1,
    beta: float = 0.1,
    saturation: float = 0.6,
    black: float = 0.5,
    white: float = 99.5,
    floor: float = 0.01,
    gamma: float = 1.0,
    space: SpaceName = "rgb",
    **options: Unpack[SolverOptions],
) -> Edit:
    """Compression of the dynamic range: large changes of luminance made smaller, detail kept (Fattal et al. 2002).

    For pictures that are dark where the light is not, and for floats of more range than a screen has.  In the log
    domain, as in `relight`, but over the whole picture, with the natural condition at its edges, and on all scales:
    what is small next to a window frame is large in the window, and is kept there.

    Y is the luminance (of values as stored, of linear light, or L*, as in `relight`), but no less than 0.  With e =
    `floor` times its percentile `white`, L = log(Y + e): without e the noise of what is nearly black would count for
    as much as the lights.  A pyramid of means of 2 x 2 pixels, as long as the shorter side keeps 32 of them, has at
    level k the norm n_k of central differences / 2^(k + 1); its factor is (a_k / max(n_k, a_k / 10))^beta, with
    a_k = alpha mean(n_k).  The product over all levels, enlarged linearly, is the factor of a pixel; that of a pixel
    pair is the mean of its two pixels'.

    All gradients shrink, so that the new luminance exp(f) is stretched: its percentile `white` becomes full scale, and
    its percentile `black` that share of it which Y's was of Y's own percentile `white`: blacks stay as black as they
    were.  What leaves the range is cut off, and the rest raised to 1 / gamma.  With e' = `floor` times full scale,
    colours are new = (newY + e') ((old + e) / (Y + e))^(saturation / gamma) - e', channel by channel; in Lab a* and b*
    are multiplied by saturation (newL* + e') / (L* + e).  The result is clipped to the range, for floats too.  Without
    attenuation (beta 0, saturation 1) only the exposure changes.

    Parameters
    ----------
    image : (H, W) or (H, W, C) array
        C is 1 or 3.
    alpha : float
        Positive, at most 1000: what part of the mean norm of a gradient is left as it is.
    beta : float
        From 0 to 1; how strongly.  0 leaves all gradients as they are, .2 looks unreal.  Fattal et al. write 1 - beta.
    saturation : float
        From 0 to 10; 1 keeps the ratios of colours, which look too strong where much range was taken away: above .6
        what is red or blue begins to glow.
    black, white : float
        From 0 to 100, the first the smaller one.
    floor : float
        Above 0, at most 1000.  .01 suits photographs; less for floats of a large range.
    gamma : float
        From .5 to 10; 2.2 for pictures that store linear light and are to be looked at, with ``space="rgb"``.
    space, **options
        See `clone`.
    """
    check_number("alpha", alpha, 0, LARGEST_FACTOR, above_low=True)
    check_number("beta", beta, 0, 1)
    check_number("saturation", saturation, 0, LARGEST_SATURATION)
    check_number("black", black, 0, 100)
    check_number("white", white, 0, 100, above_low=True)
    check_number("floor", floor, 0, LARGEST_FACTOR, above_low=True)
    check_number("gamma", gamma, *GAMMAS)
    if black >= white:
        raise InputError(f"black is {black} and white {white}, but black must be less")
    start = perf_counter()
    image = tone.check_picture("image", image)
    tone.check_values("image", image)
    stored = image.reshape(*image.shape[:2], -1).astype(tone.working_dtype(image.dtype))
    domain = named(space, image.dtype)
    domain.check("image", stored.shape[2])
    tone.check_luminance("image", stored.shape[2])
    working = domain.to_working(stored)
    full = domain.brightness(domain.to_working(np.full((1, 3), domain.full, domain.dtype))).item()
    brightness = np.maximum(domain.brightness(working), 0)
    exposure = full / (float(np.percentile(brightness, white)) or full)
    haze = brightness.dtype.type(floor * full / exposure)
    old = brightness + haze

    logs: Values = np.log(old[:, :, 0])
    problem = _problem(logs, attenuation_map(logs, alpha, beta), domain)
    prepared = perf_counter()
    result = solve(problem, **options)
    solved = perf_counter()

    new = np.exp(logs + result.solution)[:, :, np.newaxis]
    blackest = min(1.0, float(np.percentile(brightness, black)) * exposure / full)
    new = full * _stretched(new, black, white, blackest) ** new.dtype.type(1 / gamma)
    values = domain.to_stored(_colored(working, haze, old, new, floor * full, saturation, gamma, domain))
    clipped = tone.count_clipped(values, image.dtype)
    overshoot = tone.excess(values, image.dtype) / tone.level(image.dtype)
    np.clip(values, 0, domain.full, out=values)
    seconds = {
        "guidance": prepared - start,
        "solve": solved - prepared,
        "paste": perf_counter() - solved,
    }
    report = partial(
        report_on,
        "tonemap",
        result,
        options,
        rectangle=(0, 0, *image.shape[:2]),
        space=domain.name,
        clipped=clipped,
        overshoot=overshoot,
        seconds=seconds,
    )
    return Edit(tone.to_storage(values, image.dtype).reshape(image.shape), report)


def _problem(logs: Values, factors: Values, space: Space) -> PoissonProblem:
    """The change u of the logs: v = factor * grad L, less grad L; the first guess is none."""
    gradient = Guidance.of(logs)
    across = ((factors[:, :-1] + factors[:, 1:]) / 2 - 1) * gradient.across
    down = ((factors[:-1] + factors[1:]) / 2 - 1) * gradient.down
    # An error of u multiplies all values, once by itself and once by what becomes white; as much again for stretching.
    level = 1 / (4 * 255 * space.expansion)
    return PoissonProblem(
        np.ones(logs.shape, np.bool_), np.zeros_like(logs), Guidance(across, down), level=level
    )


def _stretched(new: Values, black: float, white: float, blackest: float) -> Values:
    """Two percentiles become `blackest` and 1; clipped to 0..1."""
    low, high = (float(p) for p in np.percentile(new, (black, white)))
    if low == high:  # a single brightness
        low, blackest = 0.0, 0.0
    kind: Any = new.dtype.type
    stretched: Values = (new - kind(low)) * kind((1 - blackest) / (high - low)) + kind(blackest)
    np.clip(stretched, 0, 1, out=stretched)
    return stretched


def _colored(
    working: Values,
    haze: np.floating[Any],
    old: Values,
    new: Values,
    new_haze: float,
    saturation: float,
    gamma: float,
    space: Space,
) -> Values:
    """Working values of the new luminance, with the colours of the old ones."""
    if working.shape[2] == 1:
        return new
    kind = working.dtype.type
    if space.name == "lab":
        colored: Values = working * ((new + kind(new_haze)) / old) * kind(saturation)
        colored[:, :, :1] = new
        return colored
    ratio = (working + haze) / old
    weights: Values = np.copysign(np.abs(ratio) ** kind(saturation / gamma), ratio)
    weights *= new + kind(new_haze)
    weights -= kind(new_haze)
    return weights
