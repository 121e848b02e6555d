"""The truth for the tools that edit one picture: section 4 of the paper, its conclusion, and what it points to.

Written from the equations alone, on top of `oracles`; the conventions are the same.  Where the paper leaves a choice
open, the tools' docstrings say what was chosen and why; it is written down once more here, from those words.

What section 4 does to a guidance field is to multiply it, by one factor for each pixel pair: a transform is made of
two arrays of factors, one for pairs across and one for pairs down.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from tests import oracles
from tests.oracles import Array, Field, Transform
from tests.oracles_spaces import lab_of_srgb, srgb_of_lab

# --- factors on pixel pairs -------------------------------------------------------------------------


def times(factors: Field) -> Transform:
    """The transform that multiplies v_pq, in every channel, by the pair's factor."""

    def transform(field: Field) -> Field:
        across, down = (
            v * (factor if factor.ndim == v.ndim else factor[..., None])
            for v, factor in zip(field, factors, strict=True)
        )
        return across, down

    return transform


def scale(amount: float) -> Transform:
    """The conclusion's change of sharpness: every gradient times `amount`."""
    return lambda field: (amount * field[0], amount * field[1])


def sieve(edges: Array) -> Field:
    """Eq. (15): 1 where an edge lies between p and q, which is where one of the two is an edge pixel; 0 elsewhere."""
    edge = np.asarray(edges) != 0
    across, down = edge[:, :-1] | edge[:, 1:], edge[:-1] | edge[1:]
    return across.astype(float), down.astype(float)


def attenuation(
    logarithm: Array,
    region: Array,
    *,
    alpha: float,
    beta: float,
    least: float = 0.0,
    norms: Field | None = None,
) -> Field:
    """Eq. (16): a^beta |grad L|^-beta, with a = alpha times the mean of |grad L| over the pairs that touch Omega.

    `logarithm` is L, (H, W) or (H, W, C), each channel with an a of its own; norms given instead of it are |grad L|.
    Norms below `least` times a count as that.  Where |grad L| = 0 so is v, and the factor may be anything.
    """
    across, down = norms or pair_norms(logarithm)
    touches = (region[:, :-1] | region[:, 1:], region[:-1] | region[1:])
    a = alpha * np.concatenate([across[touches[0]], down[touches[1]]]).mean(axis=0)

    def factor(norm: Array) -> Array:
        norm = np.maximum(norm, least * a)
        return np.where(norm > 0, a / np.where(norm > 0, norm, 1), 1) ** beta

    return factor(across), factor(down)


def pair_norms_by_loops(picture: Array) -> Field:
    """|grad f| on every pixel pair: of its own difference and the mean of those across it at both of its ends."""
    height, width = picture.shape[:2]
    across, down = (
        np.zeros((height, width - 1, *picture.shape[2:])),
        np.zeros((height - 1, width, *picture.shape[2:])),
    )
    for row in range(height):
        for col in range(width):
            for norm, step, side in ((across, (0, 1), (1, 0)), (down, (1, 0), (0, 1))):
                if row + step[0] >= height or col + step[1] >= width:
                    continue
                beside = []
                for r, c in ((row, col), (row + step[0], col + step[1])):
                    for before, after in (
                        ((r - side[0], c - side[1]), (r, c)),
                        ((r, c), (r + side[0], c + side[1])),
                    ):
                        if min(before) >= 0 and after[0] < height and after[1] < width:
                            beside.append(picture[after] - picture[before])
                along = picture[row + step[0], col + step[1]] - picture[row, col]
                norm[row, col] = np.hypot(along, np.mean(beside, axis=0) if beside else 0)
    return across, down


def pair_norms(picture: Array) -> Field:
    """The same as `pair_norms_by_loops`, from slices."""

    def mean_beside(differences: Array) -> Array:
        """The mean of the differences between rows that both pixels of a pair along a row take part in."""
        total = np.zeros((2, differences.shape[0] + 1, *differences.shape[1:]))
        for rows in (slice(None, -1), slice(1, None)):
            total[0, rows] += differences
            total[1, rows] += 1
        both = total[:, :, :-1] + total[:, :, 1:]
        return both[0] / np.maximum(both[1], 1)

    down = np.hypot(
        np.diff(picture, axis=0), np.swapaxes(mean_beside(np.diff(np.swapaxes(picture, 0, 1), axis=0)), 0, 1)
    )
    return np.hypot(np.diff(picture, axis=1), mean_beside(np.diff(picture, axis=0))), down


# --- section 4 --------------------------------------------------------------------------------------


def own(image: Array, mask: Array, **variant: Any) -> Array:
    """An edit by the picture's own gradients, transformed as `variant` (see `oracles.edit`) says."""
    return oracles.edit(oracles.imported, image, image, np.asarray(mask) != 0, **variant)


def flatten(image: Array, mask: Array, *, edges: Array, **variant: Any) -> Array:
    """Texture flattening, eqs. (14)-(15)."""
    return own(image, mask, then=[times(sieve(edges))], **variant)


def relight(
    image: Array,
    mask: Array,
    *,
    alpha: float = 0.2,
    beta: float = 0.2,
    per_channel: bool = False,
    space: str = "rgb",
) -> Array:
    """Local illumination changes, eq. (16) on the log luminance: all channels are multiplied by exp(new L - L).

    With `per_channel`, on the log of each channel, which it is multiplied by.
    """
    region, full = np.asarray(mask) != 0, oracles.full_scale(image.dtype)
    logarithm = log_values(image, space, full) if per_channel else log_luminance(image, space, full)
    factors = attenuation(logarithm, region, alpha=alpha, beta=beta)
    field = times(factors)(oracles.guidance(oracles.imported, logarithm, logarithm))
    return brightened(image, region, oracles.solve(region, logarithm, *field) - logarithm, space)


def brightened(image: Array, region: Array, change: Array, space: str) -> Array:
    """The picture with all that is in the region times exp(change), in a space."""
    full = oracles.full_scale(image.dtype)
    values = oracles.working(image, full, space)
    gain = np.exp(change if change.ndim == values.ndim else change[..., None])
    edited = image.astype(np.float64)
    edited[region] = oracles.restored((values * gain)[region], full, space)
    return edited


def half_a_level(full: float, space: str) -> float:
    """The luminance of a grey of 1/510 of full scale: below it, a logarithm stands still."""
    grey = oracles.working(np.full((1, 1, 3), full / 510), full, space)
    return float(grey[0, 0, 0])


def log_values(picture: Array, space: str, full: float) -> Array:
    """The log of each channel."""
    return np.log(np.maximum(oracles.working(picture, full, space), half_a_level(full, space)))


def log_luminance(picture: Array, space: str, full: float) -> Array:
    """(H, W): the log of Y of the values that the equations are solved in; of L* in Lab."""
    values = oracles.working(picture, full, space)
    if values.ndim == 3:
        channels = values.shape[2]
        values = values[..., 0] if space == "lab" or channels == 1 else oracles.grey(values)
    return np.log(np.maximum(values, half_a_level(full, space)))


def recolor(
    image: Array,
    mask: Array,
    *,
    gain: tuple[float, float, float] = (1.0, 1.0, 1.0),
    hue: float = 0.0,
    saturation: float = 1.0,
    decolor_background: bool = False,
    **variant: Any,
) -> Array:
    """Local colour changes, Fig. 11: a recoloured copy cloned into the picture, or into its luminance."""
    source = recolored(image, gain, hue, saturation)
    return oracles.clone(stored_luminance(image) if decolor_background else image, source, mask, **variant)


def stored_luminance(image: Array) -> Array:
    """The luminance in three channels, as the picture's type stores it: of integers rounded, halves to even.

    Ten thousand times the weights are integers, and their sum and its division by ten thousand are exact where the
    result is a half.
    """
    if np.issubdtype(image.dtype, np.integer):
        weighted = image.astype(np.int64) @ np.rint(1e4 * np.array(oracles.LUMINANCE)).astype(np.int64)
        grey = np.rint(weighted / 1e4)
    else:
        grey = oracles.grey(image)
    return np.repeat(grey[..., None], 3, axis=2).astype(image.dtype)


def recolored(image: Array, gain: tuple[float, float, float], hue: float, saturation: float) -> Array:
    """The copy, float64: channels multiplied, then turned by `hue` degrees in Lab and its chroma multiplied."""
    copy = image * np.array(gain, float)
    if (hue, saturation) == (0, 1):
        return copy
    full = oracles.full_scale(image.dtype)
    lab = lab_of_srgb(copy / full)
    turned = saturation * np.exp(1j * np.deg2rad(hue)) * (lab[..., 1] + 1j * lab[..., 2])
    return full * srgb_of_lab(np.stack([lab[..., 0], turned.real, turned.imag], axis=-1))


def tile(
    image: Array, *, rect: tuple[int, int, int, int] | None = None, axis: str = "both", space: str = "rgb"
) -> Array:
    """Seamless tiling of a rectangle (row, column, height, width), Fig. 12; the result is as large as it.

    Along `axis` "x" the left and the right side become their mean, and nothing is known on the other two; "y" the
    other way round.  With "both" all four sides are known, and a corner is the mean of the four.  The means are of the
    values that the equations are solved in, and known as the picture's type can store them.
    """
    row, col, height, width = rect or (0, 0, *image.shape[:2])
    full = oracles.full_scale(image.dtype)
    picture = image[row : row + height, col : col + width]
    g = oracles.working(picture, full, space)
    mean, region = g.copy(), np.ones((height, width), bool)
    if axis in ("x", "both"):
        mean[:, 0] = mean[:, -1] = (mean[:, 0] + mean[:, -1]) / 2
        region[:, [0, -1]] = False
    if axis in ("y", "both"):
        mean[0] = mean[-1] = (mean[0] + mean[-1]) / 2
        region[[0, -1]] = False
    sides = oracles.restored(mean, full, space)
    if np.issubdtype(image.dtype, np.integer):
        sides = oracles.stored(sides, image.dtype).astype(float)
    f = oracles.working(sides, full, space)
    solution = oracles.restored(
        oracles.solve(region, f, *oracles.guidance(oracles.imported, g, g)), full, space
    )
    solution[~region] = sides[~region]
    return solution


# --- the conclusion, and what the paper points to ---------------------------------------------------


def focus(image: Array, mask: Array, *, amount: float, **variant: Any) -> Array:
    """The conclusion's change of focus."""
    return own(image, mask, then=[scale(amount)], **variant)


def heal(image: Array, mask: Array, *, offset: tuple[int, int], **variant: Any) -> Array:
    """Concealment, Fig. 2: g_p is the picture's value at p + offset."""
    away = (-offset[0], -offset[1])
    return oracles.clone(image, image, mask, offset=away, mask_on="destination", **variant)


# --- into the range ---------------------------------------------------------------------------------


def desaturated(colour: Array, full: float) -> Array:
    """R, G and B drawn towards the grey of their luminance, just as far as they must to lie in 0...full."""
    luminance = float(np.dot(oracles.LUMINANCE, colour))
    if not 0 <= luminance <= full:
        return np.full(3, luminance)
    share = 1.0
    for value in colour:
        if value > full:
            share = min(share, (full - luminance) / (value - luminance))
        if value < 0:
            share = min(share, luminance / (luminance - value))
    return luminance + share * (colour - luminance)


def fitted(picture: Callable[[float], Array], region: Array, full: float) -> tuple[Array, float]:
    """A picture without a value out of 0...full, and s.

    `picture` makes it of s, by which all gradients are multiplied.  s is the largest number up to 1 with which the
    luminance of every pixel stays in range that is in range with s = 0; colours are `desaturated`.
    """

    def in_range(s: float) -> Array:
        values = picture(s)[region]
        luminance = values if values.ndim == 1 else oracles.grey(values)
        return (luminance >= -1e-9 * full) & (luminance <= (1 + 1e-9) * full)

    can_be = in_range(0)
    low, high = (1.0, 1.0) if in_range(1)[can_be].all() else (0.0, 1.0)
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if in_range(middle)[can_be].all() else (low, middle)
    exact = picture(low)
    if exact.ndim == 3:
        exact[region] = [desaturated(colour, full) for colour in exact[region]]
    return exact, low


# --- the range of a whole picture -------------------------------------------------------------------


def tonemap(
    image: Array,
    *,
    alpha: float = 0.1,
    beta: float = 0.1,
    saturation: float = 0.6,
    black: float = 0.5,
    white: float = 99.5,
    floor: float = 0.01,
    gamma: float = 1.0,
    space: str = "rgb",
) -> Array:
    """Fattal et al. 2002: the log luminance with its gradients attenuated on every scale, the natural condition around.

    Luminance and colours have `floor` times the percentile `white` of the luminance added to them.  The new luminance
    is stretched: its percentile `white` becomes white, its percentile `black` is as far from that as it was; what is
    beyond is cut off, and the rest raised to 1 / gamma.  A colour is the new luminance times (old / old
    luminance)^(saturation / gamma), in Lab its chroma times saturation and the ratio of lightness, all of them with
    `floor` times white added.
    """
    full = oracles.full_scale(image.dtype)
    values = oracles.working(image, full, space)
    coloured = values.ndim == 3 and values.shape[2] == 3
    bright = values[..., :1] if space == "lab" else oracles.grey(values)[..., None] if coloured else values
    bright = np.maximum(bright.reshape(image.shape[:2]), 0)
    darkest, lightest = np.percentile(bright, black), np.percentile(bright, white)
    old = bright + floor * lightest
    logarithm = np.log(old)
    factor = attenuation_on_all_scales(logarithm, alpha, beta)
    field = times(((factor[:, :-1] + factor[:, 1:]) / 2, (factor[:-1] + factor[1:]) / 2))(
        oracles.guidance(oracles.imported, logarithm, logarithm)
    )
    new = np.exp(oracles.solve(np.ones(old.shape, bool), logarithm, *field))
    brightest = float(oracles.working(np.full((1, 1, 3), full), full, space)[0, 0, 0])
    low, high = np.percentile(new, black), np.percentile(new, white)
    above_black = (new - low) / (high - low) * (1 - darkest / lightest)
    new = brightest * np.clip(darkest / lightest + above_black, 0, 1) ** (1 / gamma)
    haze = floor * brightest
    if space == "lab":
        chroma = [saturation * values[..., i] * (new + haze) / old for i in (1, 2)]
        edited = np.stack([new, *chroma], axis=-1)
    elif coloured:
        ratio = (values + floor * lightest) / old[..., None]
        edited = (new[..., None] + haze) * np.sign(ratio) * np.abs(ratio) ** (saturation / gamma) - haze
    else:
        edited = new.reshape(image.shape)
    return np.clip(oracles.restored(edited, full, space), 0, full)


def attenuation_on_all_scales(logarithm: Array, alpha: float, beta: float) -> Array:
    """Per pixel, the product over a pyramid of (a / |grad|)^beta, a being alpha times the mean of |grad| on its level.

    A level has the means of 2 x 2 pixels of the one below, the last of them as long as its shorter side has 32 pixels
    or more; beyond its edge a picture continues with the pixels there.  Norms below a / 10 count as that.
    """
    pyramid = [logarithm]
    while min(pyramid[-1].shape) // 2 >= 32:
        pyramid.append(halved(pyramid[-1]))
    product = np.ones_like(pyramid[-1])
    for level in reversed(range(len(pyramid))):
        picture = pyramid[level]
        if product.shape != picture.shape:
            rows, cols = (doubling(n) for n in product.shape)
            product = (rows @ product @ cols.T)[: picture.shape[0], : picture.shape[1]]
        norm = np.zeros_like(picture)
        for row, col in np.ndindex(*picture.shape):
            height, width = picture.shape
            down = picture[min(row + 1, height - 1), col] - picture[max(row - 1, 0), col]
            across = picture[row, min(col + 1, width - 1)] - picture[row, max(col - 1, 0)]
            norm[row, col] = np.hypot(down, across) / 2 ** (level + 1)
        a = alpha * norm.mean()
        if a > 0:
            product = product * (a / np.maximum(norm, a / 10)) ** beta
    return product


def halved(picture: Array) -> Array:
    """Means of 2 x 2 pixels."""
    height, width = picture.shape
    half = np.zeros(((height + 1) // 2, (width + 1) // 2))
    for row, col in np.ndindex(*half.shape):
        rows, cols = ([2 * i, min(2 * i + 1, length - 1)] for i, length in ((row, height), (col, width)))
        half[row, col] = picture[np.ix_(rows, cols)].mean()
    return half


def doubling(length: int) -> Array:
    """(2 length, length): linear interpolation of pixels, each of which becomes two of half the size."""
    matrix = np.zeros((2 * length, length))
    for i in range(2 * length):
        place = (i + 0.5) / 2 - 0.5
        for j in (int(np.floor(place)), int(np.floor(place)) + 1):
            matrix[i, min(max(j, 0), length - 1)] += 1 - abs(place - j)
    return matrix
