"""labelme's files: the shapes on one picture, each with a label."""

from __future__ import annotations

import base64
import binascii
import math
import struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.images import decode
from poisson_cli.images.demands import asked
from poisson_cli.masks.annotations.document import choices, coordinates, items, mapping, picture_size, shown
from poisson_cli.masks.canvas import Canvas
from poisson_cli.masks.raster import strength
from poisson_cli.masks.runs import paint
from poisson_cli.masks.scan import polygon_runs

__all__ = ["draw_labelme"]

_FLAT: Final = ("point", "points", "line", "linestrip")

_PNG: Final = b"\x89PNG\r\n\x1a\n"


def draw_labelme(document: dict[str, Any], label: str | None, canvas: Canvas) -> NDArray[np.bool_]:
    """Select the shapes of a label.

    Parameters
    ----------
    document
        The file, with ``shapes``.
    label
        Whose shapes are meant; None for all.
    canvas
        The picture that was annotated.

    Returns
    -------
    ndarray
        (H, W) bool, True = selected.

    Raises
    ------
    InputError
        If the file is damaged or for another picture, no shape has that label, one of those that have it has no inside,
        or none at all has one.
    """
    height, width = document.get("imageHeight"), document.get("imageWidth")
    if height is not None or width is not None:  # other writers leave them out
        canvas.refuse_other_size("it is for a picture of", picture_size(height, width, "the document"))
    shapes = [
        mapping(shape, f"shape {number}")
        for number, shape in enumerate(items(document["shapes"], '"shapes"'), start=1)
    ]
    labels = [text for shape in shapes if isinstance(text := shape.get("label"), str)]
    if label is not None and label not in labels:
        raise InputError(f"no shape has the label {shown(label)}; the labels are: {choices(labels)}")
    mask = np.zeros(canvas.shape, np.bool_)
    polygons = []
    circles = []
    flat: list[str] = []
    for number, shape in enumerate(shapes, start=1):
        if label is not None and shape.get("label") != label:
            continue
        what = f"shape {number} ({shown(shape.get('label'))})"
        points = _points(shape, what)
        kind = shape.get("shape_type") or "polygon"
        if kind == "mask":
            _add_bitmap(mask, shape.get("mask"), points, what)
        elif kind == "circle" and len(points) == 2:
            circles.append(points)
        elif kind == "rectangle" and len(points) == 2:
            (top, left), (bottom, right) = points
            polygons.append(np.array([[top, left], [top, right], [bottom, right], [bottom, left]]))
        elif kind in ("polygon", "rectangle") and len(points) >= 3:
            polygons.append(points)
        else:
            flat.append(f"{what} is a {shown(kind)} of {len(points)} points, which has no inside")
            if label is not None or kind not in _FLAT or len(flat) == len(shapes):
                raise InputError(flat[-1])
    if flat:
        asked().notices.append(
            f"left out, because only areas can be selected: {len(flat):,} of the shapes, for one {flat[0]}"
        )
    runs = [polygon_runs(polygons, canvas.shape), *(_circle_runs(points, canvas.shape) for points in circles)]
    starts, ends = (np.concatenate(side) for side in zip(*runs, strict=True))
    mask |= paint(starts, ends, mask.size).reshape(mask.shape)
    return mask


def _points(shape: dict[str, Any], what: str) -> NDArray[np.float64]:
    """(n, 2) float64: (row, column)."""
    pairs = [items(pair, f"a point of {what}") for pair in items(shape.get("points"), f'"points" of {what}')]
    if any(len(pair) != 2 for pair in pairs):
        raise InputError(f"{what} has a point that is not x and y")
    numbers = coordinates([number for pair in pairs for number in pair], what)
    return numbers.reshape(-1, 2)[:, ::-1]


def _circle_runs(
    points: NDArray[np.float64], shape: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The runs of pixels inside a circle, given by its centre and a point on it."""
    (row, col), (edge_row, edge_col) = points
    radius = math.hypot(edge_row - row, edge_col - col)
    lines = np.arange(
        np.clip(math.ceil(row - radius - 0.5), 0, shape[0]),
        np.clip(math.ceil(row + radius - 0.5), 0, shape[0]),
    )
    half = np.sqrt(np.maximum(radius**2 - (lines + 0.5 - row) ** 2, 0))
    starts, ends = (
        lines * shape[1] + np.clip(np.ceil(col + side - 0.5), 0, shape[1]).astype(np.int64)
        for side in (-half, half)
    )
    return starts, ends


def _add_bitmap(mask: NDArray[np.bool_], value: Any, points: NDArray[np.float64], what: str) -> None:
    """Select a bitmap: a PNG in base64, and the centres of the pixels at two of its corners."""
    if len(points) != 2 or not isinstance(value, str):
        raise InputError(f"{what} is a mask without its bitmap or its two corners")
    top, left, bottom, right = np.rint(points).astype(np.int64).ravel().tolist()
    if not (0 <= top <= bottom < mask.shape[0] and 0 <= left <= right < mask.shape[1]):
        raise InputError(f"{what} does not lie on the picture")
    try:
        data = base64.b64decode(value, validate=True)
    except (binascii.Error, ValueError) as error:
        raise InputError(f"the bitmap of {what} is not base64") from error
    shape = (bottom + 1 - top, right + 1 - left)
    # Asked before it is decoded: a few bytes can claim to be very large.
    if not data.startswith(_PNG) or len(data) < 24 or struct.unpack(">II", data[16:24]) != shape[::-1]:
        raise InputError(f"the bitmap of {what} is not a PNG of {shape[1]}x{shape[0]} pixels")
    bitmap = decode(data, f"the bitmap of {what}")
    mask[top : bottom + 1, left : right + 1] |= strength(bitmap.in_8_bits()) > 0
