"""COCO's files: the things on many pictures, each of a category, as polygons or run lengths."""

from __future__ import annotations

import re
from pathlib import PurePath, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli.errors import InputError
from poisson_cli.masks.annotations.document import choices, coordinates, items, mapping, picture_size, shown
from poisson_cli.masks.annotations.rle import rle_runs
from poisson_cli.masks.canvas import Canvas
from poisson_cli.masks.runs import paint
from poisson_cli.masks.scan import polygon_runs

__all__ = ["draw_coco"]

_Objects = list[dict[str, Any]]


def draw_coco(document: dict[str, Any], name: str | None, canvas: Canvas) -> NDArray[np.bool_]:
    """Select the annotated things of a category, or a single one.

    Parameters
    ----------
    document
        The file, with ``annotations``. Of the pictures it is for, the one with the canvas's file name counts; if it is
        for one only, that one.
    name
        Name of a category, or else the ``id`` of an annotation; None for everything on the picture.
    canvas
        The picture that was annotated.

    Returns
    -------
    ndarray
        (H, W) bool, True = selected: the union of all polygons and run lengths.

    Raises
    ------
    InputError
        If the file is damaged, is not for the picture, or has nothing of that name on it.
    """
    annotations = _objects(document["annotations"], "annotation")
    images = _objects(document["images"], "image") if "images" in document else []
    categories = {
        _key(category.get("id")): shown_name
        for category in _objects(document.get("categories", []), "category")
        if isinstance(shown_name := category.get("name"), str)
    }
    if name is not None and name not in categories.values() and re.fullmatch("[0-9]{1,18}", name):
        chosen = [one for one in annotations if _key(one.get("id")) in (int(name), name)]
        if not chosen:
            raise InputError(f"no category is called {shown(name)}, and no annotation has that id")
        image_ids = {_key(one.get("image_id")) for one in chosen}
        images = [image for image in images if _key(image.get("id")) in image_ids]
        _refuse_other_size(images, canvas)
        return _draw(chosen, canvas)
    if images:
        images = _of_canvas(images, canvas)
        _refuse_other_size(images, canvas)
        (image,) = images
        annotations = [one for one in annotations if _key(one.get("image_id")) == _key(image.get("id"))]
    chosen = annotations
    if name is not None:
        names = [categories.get(_key(one.get("category_id")), "") for one in annotations]
        chosen = [one for one, its in zip(annotations, names, strict=True) if its == name]
        if not chosen:
            there = choices([its for its in names if its])
            raise InputError(f"nothing on this picture is a {shown(name)}; the categories on it are: {there}")
    return _draw(chosen, canvas)


def _objects(value: Any, what: str) -> _Objects:
    listed = items(value, f"the list of each {what}")
    return [mapping(one, f"{what} {number}") for number, one in enumerate(listed, start=1)]


def _key(value: Any) -> int | str | None:
    """An id that can be looked up; None for what cannot be one."""
    return value if type(value) in (int, str) else None


def _of_canvas(images: _Objects, canvas: Canvas) -> _Objects:
    """The one image that the canvas is, in a list."""
    if len(images) == 1:
        return images
    name = PurePath(canvas.picture.name).name
    named = [
        image
        for image in images
        if isinstance(file := image.get("file_name"), str) and PurePosixPath(file).name == name
    ]
    if len(named) != 1:
        count = "more than one" if named else "none"
        raise InputError(
            f"it is for {len(images):,} pictures, and {count} of them is called {name}; "
            "name an annotation by its id, or save the annotations of this picture in a file of their own"
        )
    return named


def _refuse_other_size(images: _Objects, canvas: Canvas) -> None:
    for image in images:
        height, width = image.get("height"), image.get("width")
        if height is not None or width is not None:
            canvas.refuse_other_size("it is for a picture of", picture_size(height, width, "the annotation"))


def _draw(annotations: _Objects, canvas: Canvas) -> NDArray[np.bool_]:
    """The union of all segmentations."""
    polygons: list[NDArray[np.float64]] = []
    nothing = np.zeros(0, np.int64)
    starts, ends = [nothing], [nothing]
    for one in annotations:
        what = f"annotation {shown(one.get('id'))}"
        segmentation = one.get("segmentation")
        if isinstance(segmentation, list):
            polygons += [_polygon(flat, what) for flat in segmentation]
        elif segmentation is None:
            raise InputError(f"{what} has no segmentation")
        else:
            begin, end = rle_runs(segmentation, canvas, what)
            starts.append(begin)
            ends.append(end)
    height, width = canvas.shape
    mask = paint(*polygon_runs(polygons, canvas.shape), height * width).reshape(height, width)
    mask |= paint(np.concatenate(starts), np.concatenate(ends), height * width).reshape(width, height).T
    return mask


def _polygon(flat: Any, what: str) -> NDArray[np.float64]:
    """(n, 2) float64: (row, column) from x, y, x, y, ..."""
    numbers = coordinates(items(flat, f"a polygon of {what}"), what)
    if numbers.size < 6 or numbers.size % 2:
        raise InputError(
            f"{what} has a polygon of {numbers.size} numbers; it takes x and y of 3 points or more"
        )
    return numbers.reshape(-1, 2)[:, ::-1]
