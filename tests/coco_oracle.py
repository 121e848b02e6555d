"""COCO's own library as an oracle: its polygons and run lengths as bool arrays."""

import warnings
from typing import Any

import numpy as np
from pycocotools import mask as coco


def decode(rle: dict[str, Any]) -> np.ndarray:
    """(h, w) bool of a mask in run lengths, compressed or listed."""
    if isinstance(rle["counts"], list):
        rle = coco.frPyObjects(rle, *rle["size"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # what its arrays make numpy 2 say
        return coco.decode(rle).astype(bool)


def encode(mask: np.ndarray) -> dict[str, Any]:
    """A mask in compressed run lengths, as a JSON value."""
    rle = coco.encode(np.asfortranarray(mask.astype(np.uint8)))
    return {"size": [int(side) for side in rle["size"]], "counts": rle["counts"].decode("ascii")}


def draw(polygons: list[list[float]], shape: tuple[int, int]) -> np.ndarray:
    """(h, w) bool of the union of polygons, each x, y, x, y, ..."""
    return decode(coco.merge(coco.frPyObjects(polygons, *shape)))
