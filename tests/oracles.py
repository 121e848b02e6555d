"""The truth that the tests compare with: eq. (7) of Perez et al. 2003, written down and solved directly.

Here are the equations, their solution, and the tools of section 3; `oracles_tools` has the tools that edit one
picture, `oracles_spaces` the colour spaces.  Nothing in them knows our code, and only numpy and scipy are imported.

Every idea is written twice: once as
the paper writes it, pixel by pixel in plain loops (names ending in ``_by_loops``, for small pictures), and
once with slices, for photographs.  ``test_oracles.py`` holds the two against each other and both against
sums done by hand.

Conventions: pictures are (H, W) or (H, W, C); ``region`` is (H, W) bool, True where a pixel is unknown
(Omega); a guidance field is a pair ``across, down`` with one entry per pixel pair, v_pq for p left of q,
shape (H, W-1[, C]), and v_pq for p above q, shape (H-1, W[, C]); v_qp = -v_pq.  Answers are float64 in the
units of the pictures, neither rounded nor clipped.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from tests.oracles_spaces import SPACES

Array = np.ndarray
Pixel = tuple[int, int]
Field = tuple[Array, Array]
Transform = Callable[[Field], Field]

LUMINANCE = (0.2126, 0.7152, 0.0722)  # ITU-R BT.709, what makes a colour source monochrome


# --- eq. (7): the equations -------------------------------------------------------------------------


def neighbours(pixel: Pixel, shape: tuple[int, ...]) -> Iterator[Pixel]:
    """N_p: the 4-neighbours of a pixel that lie inside an image of this shape."""
    row, col = pixel
    for r, c in ((row - 1, col), (row + 1, col), (row, col - 1), (row, col + 1)):
        if 0 <= r < shape[0] and 0 <= c < shape[1]:
            yield r, c


def pair_guidance(across: Array, down: Array, p: Pixel, q: Pixel) -> Array:
    """v_pq of two neighbouring pixels, whichever way the pair points."""
    if p > q:
        return -pair_guidance(across, down, q, p)
    return across[p] if p[0] == q[0] else down[p]


def equations_by_loops(
    region: Array, values: Array, across: Array, down: Array
) -> tuple[sparse.csc_array, Array]:
    """Eq. (7) as printed, one row per unknown pixel in reading order.

    Returns the n x n matrix and the (n, C) right-hand sides; a grey picture has C = 1.
    """
    channels = values.shape[2] if values.ndim == 3 else 1
    unknowns = [(int(r), int(c)) for r, c in np.argwhere(region)]
    number = {p: i for i, p in enumerate(unknowns)}
    matrix = sparse.lil_array((len(unknowns), len(unknowns)))
    b = np.zeros((len(unknowns), channels))
    for p, i in number.items():
        for q in neighbours(p, region.shape):
            matrix[i, i] += 1  # |N_p|
            b[i] += pair_guidance(across, down, p, q)
            if region[q]:
                matrix[i, number[q]] = -1
            else:
                b[i] += values[q]  # f*_q
    return matrix.tocsc(), b


def pair_sums(across: Array, down: Array) -> Array:
    """Sum of v_pq over q in N_p at every pixel p, whatever the region: minus the divergence of v."""
    shape = (down.shape[0] + 1, across.shape[1] + 1, *across.shape[2:])
    total = np.zeros(shape)
    total[:, :-1] += across
    total[:, 1:] -= across
    total[:-1] += down
    total[1:] -= down
    return total


def equations(region: Array, values: Array, across: Array, down: Array) -> tuple[sparse.csc_array, Array]:
    """The same matrix and right-hand sides as `equations_by_loops`, put together from slices."""
    height, width = region.shape
    flat = region.ravel()
    pixels = np.arange(height * width).reshape(height, width)
    first = np.concatenate([pixels[:, :-1].ravel(), pixels[:-1].ravel()])
    second = np.concatenate([pixels[:, 1:].ravel(), pixels[1:].ravel()])
    ones = np.ones(first.size)
    adjacency = sparse.coo_array((ones, (first, second)), (pixels.size, pixels.size)).tocsr()
    adjacency = adjacency + adjacency.T
    laplacian = sparse.diags_array(np.asarray(adjacency.sum(axis=1)).ravel()) - adjacency
    rows = laplacian.tocsr()[flat]
    known = np.where(region.reshape(-1, 1), 0.0, values.reshape(pixels.size, -1))
    b = pair_sums(across, down).reshape(pixels.size, -1)[flat] - rows @ known
    return rows[:, flat].tocsc(), b


# --- eq. (7): its solution --------------------------------------------------------------------------


def solve_equations(matrix: sparse.csc_array, b: Array) -> Array:
    """Sparse LU and one step of iterative refinement: the float64 solution to its last digits."""
    factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    u = factors.solve(b)
    return u + factors.solve(b - matrix @ u)


def solve(
    region: Array,
    values: Array,
    across: Array,
    down: Array,
    *,
    screen: float = 0.0,
    towards: Array | None = None,
    by_loops: bool = False,
) -> Array:
    """The picture that eq. (7) asks for, per channel, float64; outside the region it is `values`.

    With `screen` > 0 each equation gains screen * (f_p - g_p) on its left, g being `towards` (a picture, looked at
    in the region only).

    Where no pixel is known the equations fix the picture up to a constant.  The rule is to keep the mean of
    `values`: the first unknown is held at zero, the rest solved, and the mean put right.
    """
    matrix, b = (equations_by_loops if by_loops else equations)(region, values, across, down)
    if screen:
        assert towards is not None
        matrix = (matrix + screen * sparse.eye_array(len(b))).tocsc()
        u = solve_equations(matrix, b + screen * towards[region].reshape(b.shape))
    elif region.all():
        b = b - b.mean(axis=0)  # zero already unless the sums come from no pair field at all
        u = np.zeros_like(b)
        if len(u) > 1:
            u[1:] = solve_equations(matrix[1:, 1:].tocsc(), b[1:])
        u += values.reshape(u.shape).mean(axis=0, dtype=np.float64) - u.mean(axis=0)
    else:
        u = solve_equations(matrix, b)
    solution = values.astype(np.float64)
    solution[region] = u.reshape(-1, *values.shape[2:])
    return solution


def energy(picture: Array, region: Array, across: Array, down: Array) -> float:
    """Eq. (6): the sum of (f_p - f_q - v_pq)^2 over the pairs of which at least one pixel is unknown."""
    misfit_across = (picture[:, :-1] - picture[:, 1:] - across)[region[:, :-1] | region[:, 1:]]
    misfit_down = (picture[:-1] - picture[1:] - down)[region[:-1] | region[1:]]
    return float((misfit_across**2).sum() + (misfit_down**2).sum())


# --- guidance fields, eqs. (11) and (13) ------------------------------------------------------------

Rule = Callable[[Array, Array], Array]


def imported(difference: Array, source_difference: Array) -> Array:
    """Eq. (11): the source's gradient."""
    return source_difference + 0 * difference


def averaged(difference: Array, source_difference: Array) -> Array:
    """The linear combination of Fig. 6c: half of each."""
    return (difference + source_difference) / 2


def mixed(difference: Array, source_difference: Array) -> Array:
    """Eq. (13): of the two variations the stronger one, per pair and channel; the source's at a draw."""
    return np.where(np.abs(difference) > np.abs(source_difference), difference, source_difference)


def zero(difference: Array, source_difference: Array) -> Array:
    """Eq. (2): the membrane."""
    return 0 * difference


def source_pixel(source: Array, offset: tuple[int, int], pixel: Pixel) -> Array | None:
    """The source's value on a pixel of the destination, None where the source does not lie."""
    row, col = pixel[0] - offset[0], pixel[1] - offset[1]
    if 0 <= row < source.shape[0] and 0 <= col < source.shape[1]:
        return source[row, col].astype(np.float64)
    return None


def guidance_by_loops(
    rule: Rule, destination: Array, source: Array, offset: tuple[int, int] = (0, 0)
) -> Field:
    """The field that a rule makes, pair by pair; a pair that leaves the source has no source gradient."""
    f = destination.astype(np.float64)
    height, width = f.shape[:2]
    across = np.zeros((height, width - 1, *f.shape[2:]))
    down = np.zeros((height - 1, width, *f.shape[2:]))
    for row in range(height):
        for col in range(width):
            p = (row, col)
            for field, q in ((across, (row, col + 1)), (down, (row + 1, col))):
                if q[0] < height and q[1] < width:
                    g_p, g_q = source_pixel(source, offset, p), source_pixel(source, offset, q)
                    source_difference = g_p - g_q if g_p is not None and g_q is not None else np.zeros(1)
                    field[p] = np.squeeze(rule(f[p] - f[q], source_difference))
    return across, down


def placed(source: Array, offset: tuple[int, int], shape: tuple[int, int], empty: float | bool) -> Array:
    """The source on a canvas of the destination's height and width, `empty` where it does not lie."""
    canvas = np.full((*shape, *source.shape[2:]), empty)
    (top, bottom), (left, right) = (
        (min(max(0, start), size), min(max(0, start + length), size))
        for start, size, length in zip(offset, shape, source.shape, strict=False)
    )
    canvas[top:bottom, left:right] = source[top - offset[0] :, left - offset[1] :][
        : bottom - top, : right - left
    ]
    return canvas


def guidance(rule: Rule, destination: Array, source: Array, offset: tuple[int, int] = (0, 0)) -> Field:
    """The same field as `guidance_by_loops`, from slices: NaN marks what lies beyond the source."""
    f, shape = destination.astype(np.float64), (destination.shape[0], destination.shape[1])
    g = placed(source.astype(np.float64), offset, shape, np.nan)
    if g.ndim < f.ndim:
        g = g[..., None]
    across = rule(f[:, :-1] - f[:, 1:], np.nan_to_num(g[:, :-1] - g[:, 1:], nan=0.0))
    down = rule(f[:-1] - f[1:], np.nan_to_num(g[:-1] - g[1:], nan=0.0))
    return across, down


# --- the tools of section 3 -------------------------------------------------------------------------


def grey(picture: Array, weights: tuple[float, float, float] = LUMINANCE) -> Array:
    """A colour picture turned monochrome, (H, W) float64, not rounded."""
    return picture.astype(np.float64) @ np.array(weights)


def region_of(
    mask: Array, offset: tuple[int, int], shape: tuple[int, ...], mask_on: str, source_shape: tuple[int, ...]
) -> Array:
    """Omega: the pixels of the destination that a mask selects, on the source or on the destination.

    Where the source does not lie nothing can be imported: Omega never leaves it.
    """
    selected = np.asarray(mask) != 0
    if mask_on == "source":
        return placed(selected, offset, (shape[0], shape[1]), False)
    return selected & placed(np.ones(source_shape[:2], bool), offset, (shape[0], shape[1]), False)


def clone(
    destination: Array,
    source: Array,
    mask: Array,
    *,
    offset: tuple[int, int] = (0, 0),
    mask_on: str = "source",
    gradients: str = "source",
    monochrome: bool = False,
    **variant: Any,
) -> Array:
    """Seamless cloning, eqs. (9)-(11); Fig. 5 with `monochrome`, Fig. 6c with ``gradients="average"``.

    `variant` are the last parameters of `edit`.
    """
    rule = {"source": imported, "average": averaged}[gradients]
    if monochrome and source.ndim == 3:
        source = grey(source)
    return edit(
        rule,
        destination,
        source,
        region_of(mask, offset, destination.shape, mask_on, source.shape),
        offset,
        **variant,
    )


def mix(
    destination: Array,
    source: Array,
    mask: Array,
    *,
    offset: tuple[int, int] = (0, 0),
    mask_on: str = "source",
    **variant: Any,
) -> Array:
    """Mixed seamless cloning, eq. (13)."""
    region = region_of(mask, offset, destination.shape, mask_on, source.shape)
    return edit(mixed, destination, source, region, offset, **variant)


def fill(image: Array, mask: Array, **variant: Any) -> Array:
    """The membrane, eq. (2)."""
    return edit(zero, image, image, np.asarray(mask) != 0, **variant)


def edit(
    rule: Rule,
    destination: Array,
    source: Array,
    region: Array,
    offset: tuple[int, int] = (0, 0),
    *,
    space: str = "rgb",
    then: Iterable[Transform] = (),
    screen: float = 0.0,
    robust: bool = False,
    by_loops: bool = False,
) -> Array:
    """One edit from pictures to a picture, float64 in the units of the destination, which it is outside the region.

    Parameters
    ----------
    source
        In the destination's units, whatever its type; a grey one is spread over the channels.
    space
        What the equations are solved in: a key of `SPACES`.
    then
        What is done to the guidance of `rule` before it is integrated, in this order.
    screen
        The pull towards the source, see `solve`.
    robust
        Solve for boundary values whose mismatch was `winsorised`; in rgb, with the source under all of the boundary.
    """
    scale = full_scale(destination.dtype)
    if source.ndim < destination.ndim:
        source = np.repeat(source[..., None], destination.shape[2], axis=2)
    f, g = (working(picture, scale, space) for picture in (destination, source))
    field = (guidance_by_loops if by_loops else guidance)(rule, f, g, offset)
    for transform in then:
        field = transform(field)
    towards = placed(g, offset, region.shape, np.nan) if screen or robust else None
    if robust:
        rim = boundary(region)
        f = f.copy()
        f[rim] = towards[rim] + winsorised(f[rim] - towards[rim], scale / 255)
    solution = solve(region, f, *field, screen=screen, towards=towards, by_loops=by_loops)
    edited = destination.astype(np.float64)
    edited[region] = restored(solution[region], scale, space)
    return edited


def boundary(region: Array) -> Array:
    """The known pixels that have an unknown neighbour."""
    beside = np.zeros_like(region)
    for row, col in np.argwhere(region):
        for pixel in neighbours((row, col), region.shape):
            beside[pixel] = True
    return beside & ~region


def winsorised(mismatch: Array, level: float) -> Array:
    """Mismatches (n, C) with outliers drawn straight back towards the median, to where outliers begin.

    That is three standard deviations from it in the worst of the channels, or one level if that is more; a standard
    deviation is 1.4826 times the median distance from the median.
    """
    middle = np.median(mismatch, axis=0)
    distance = np.abs(mismatch - middle)
    limit = np.maximum(3 * 1.4826 * np.median(distance, axis=0), level)
    return np.array(
        [middle + (m - middle) / max(1.0, *(d / limit)) for m, d in zip(mismatch, distance, strict=True)]
    )


def working(picture: Array, scale: float, space: str) -> Array:
    """Stored values of this full scale in the units that the equations are solved in, float64."""
    return picture.astype(np.float64) if space == "rgb" else SPACES[space].work(picture / scale)


def restored(values: Array, scale: float, space: str) -> Array:
    """The inverse of `working`."""
    return values if space == "rgb" else SPACES[space].store(values) * scale


# --- from exact values to stored ones ---------------------------------------------------------------


def full_scale(dtype: np.dtype | type) -> float:
    """The largest value of an integer type; 1 for floats."""
    return float(np.iinfo(dtype).max) if np.issubdtype(dtype, np.integer) else 1.0


def stored(exact: Array, dtype: np.dtype | type) -> Array:
    """An integer picture from exact values: clipped to the range, then rounded to the nearest."""
    return np.rint(np.clip(exact, 0, full_scale(dtype))).astype(dtype)


def distance_to_tie(exact: Array, dtype: np.dtype | type) -> Array:
    """How far a value, once clipped, is from the nearest half, where rounding may go either way."""
    clipped = np.clip(exact, 0, full_scale(dtype))
    return np.abs(clipped - np.floor(clipped) - 0.5)
