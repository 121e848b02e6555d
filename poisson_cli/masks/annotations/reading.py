"""From the text of an annotation file to a mask: which of the known kinds it is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.masks.annotations.coco import draw_coco
from poisson_cli.masks.annotations.document import load, mapping
from poisson_cli.masks.annotations.labelme import draw_labelme
from poisson_cli.masks.canvas import Canvas

__all__ = ["draw_annotations"]


def draw_annotations(text: str, name: str | None, canvas: Canvas) -> NDArray[np.bool_]:
    """Select what an annotation file outlines.

    Parameters
    ----------
    text
        JSON, as labelme or COCO have it.
    name
        What to select: a label, a category, or the number of an annotation; None for everything that is annotated.
    canvas
        The picture that was annotated.

    Returns
    -------
    ndarray
        (H, W) bool, True = selected.

    Raises
    ------
    InputError
        If the text is of neither kind, damaged, for another picture, or has nothing of that name. The message does not
        name the file.
    """
    document = mapping(load(text), "the document")
    if "shapes" in document:
        return draw_labelme(document, name, canvas)
    if "annotations" in document:
        return draw_coco(document, name, canvas)
    raise InputError('JSON that is neither labelme\'s nor COCO\'s: it has no "shapes" and no "annotations"')
