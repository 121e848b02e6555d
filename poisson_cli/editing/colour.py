"""sRGB, linear light and CIE-Lab, by the formulas of the standards (IEC 61966-2-1, CIE 15), full scale 1.

They are written out here because what is at hand will not do: OpenCV interpolates its Lab in a table, which moves
values by up to a level, and scikit-image would bring scipy into every command.  On the way there and back every 8-bit
value survives in float32, and every 16-bit value too in linear light; in Lab those need float64.

Values outside 0..1 are no error.  sRGB's curve is continued point-symmetrically below 0 (as scRGB does) and as a power
above 1, and Lab's by its own straight part.  Sums are written out, not left to a matrix product, whose rounding may
depend on how many rows are multiplied at once.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from solvers.canvas import Values

# Where sRGB's straight part ends, as stored and as light, and its slope; the curve is steepest there.
STRAIGHT_STORED = 0.04045
STRAIGHT_LIGHT = 0.0031308
SLOPE = 12.92

# Of R, G, B, with the primaries of sRGB and ITU-R BT.709, times 10,000: the sum is exact for integers, and
# halves are seen to be halves.
LUMINANCE = (2126, 7152, 722)

# X, Y, Z of the primaries, relative to those of white, which is R = G = B = 1: grey is exactly neutral in Lab.
_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
_TO_XYZ = _XYZ / _XYZ.sum(1, keepdims=True)

# Where Lab's straight part ends, as a cube root; the light there is the cube of it.
_DELTA = 6 / 29


def decode_srgb(stored: Values) -> Values:
    """Light, of sRGB values; any shape."""
    size: Values = np.abs(stored)
    light: Values = ((size + 0.055) / 1.055) ** 2.4
    straight = size <= STRAIGHT_STORED
    light[straight] = size[straight] / SLOPE
    np.copysign(light, stored, out=light)
    return light


def encode_srgb(light: Values) -> Values:
    """sRGB values, of light; any shape."""
    size: Values = np.abs(light)
    stored: Values = 1.055 * size ** (1 / 2.4) - 0.055
    straight = size <= STRAIGHT_LIGHT
    stored[straight] = size[straight] * SLOPE
    np.copysign(stored, light, out=stored)
    return stored


def lab_of(stored: Values) -> Values:
    """L* in 0..100, a* and b*, of sRGB values (..., 3)."""
    x, y, z = (_compressed(part) for part in _mixed(_TO_XYZ, decode_srgb(stored)))
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def srgb_of(lab: Values) -> Values:
    """sRGB values, of L*, a*, b* (..., 3)."""
    y = (lab[..., 0] + 16) / 116
    xyz = np.empty_like(lab)
    for i, t in enumerate((y + lab[..., 1] / 500, y, y - lab[..., 2] / 200)):
        xyz[..., i] = _expanded(t)
    return encode_srgb(np.stack(_mixed(np.linalg.inv(_TO_XYZ), xyz), axis=-1))


def luminance(values: Values) -> Values:
    """The luminance of R, G, B, (..., 3) -> (..., 1); one channel is its own."""
    if values.shape[-1] == 1:
        return values
    red, green, blue = LUMINANCE
    weighted: Values = red * values[..., :1] + green * values[..., 1:2] + blue * values[..., 2:]
    weighted /= 10_000
    return weighted


def drawn_into(values: Values, low: float, high: float) -> Values:
    """Colours (..., 3) that leave a range drawn towards the grey of their luminance, just as far as they must.

    So they lose saturation, and neither hue nor luminance.  What is in range stays as it is, to the last bit.  Where
    the luminance itself leaves the range nothing helps, and its grey is what remains.
    """
    leaving = ((values < low) | (values > high)).any(-1)
    if values.shape[-1] != 3 or not leaving.any():
        return values
    colours = values[leaving]
    grey = luminance(colours)
    beyond: Values = colours - grey
    room: Values = np.maximum(np.where(beyond > 0, high - grey, grey - low), 0)
    share = np.min(room / np.maximum(np.abs(beyond), room + (room == 0)), axis=-1, keepdims=True)
    drawn = values.copy()
    drawn[leaving] = np.where((grey < low) | (grey > high), grey, np.clip(grey + share * beyond, low, high))
    return drawn


def _mixed(matrix: NDArray[np.float64], values: Values) -> list[Any]:
    """The matrix times the last axis, as a list of its parts."""
    parts = [values[..., i] for i in range(3)]
    return [sum(float(m) * part for m, part in zip(row, parts, strict=True)) for row in matrix]


def _compressed(light: Values) -> Values:
    root: Values = np.cbrt(light)
    straight = light <= _DELTA**3
    root[straight] = light[straight] / (3 * _DELTA**2) + 4 / 29
    return root


def _expanded(root: Values) -> Values:
    light: Values = root * root * root
    straight = root <= _DELTA
    light[straight] = (root[straight] - 4 / 29) * (3 * _DELTA**2)
    return light
