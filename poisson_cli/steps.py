"""From what is plain data in a `Job` to keywords that hold arrays: edges, and what is done to imported gradients."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from poisson_cli import defaults, editing
from poisson_cli.errors import InputError
from poisson_cli.images import Picture, read
from poisson_cli.masks import strength
from poisson_cli.settings import Edges, Then

__all__ = ["drawn_edges", "edge_keywords", "transforms"]


def edge_keywords(edges: Edges, picture: Picture) -> dict[str, Any]:
    """The keywords that tell `poisson_cli.editing.flatten` and `Sieve` where edges are.

    Parameters
    ----------
    edges
        Where they are.
    picture
        The picture whose edges they are.

    Raises
    ------
    InputError
        If the file with the edges cannot be read or has another size.
    """
    drawn = None if edges.file is None else _read_edges(edges.file, picture)
    return {"edges": drawn, "low": edges.low, "high": edges.high, "sigma": edges.sigma}


def transforms(then: Then, sieve: dict[str, Any] | None) -> list[editing.Transform]:
    """What a clone's keyword ``then`` is to be.

    Parameters
    ----------
    then
        What is done to the gradients after they are imported.
    sieve
        From `edge_keywords`, for a flattening; None without one.
    """
    steps: list[editing.Transform] = []
    if sieve is not None:
        steps.append(editing.Sieve(**sieve))
    if then.focus is not None:
        steps.append(editing.Scale(then.focus))
    if then.relight is not None:
        steps.append(editing.Attenuate(**then.relight._asdict()))
    return steps


def drawn_edges(picture: Picture, *, edges: NDArray[np.bool_] | None, **search: float) -> NDArray[np.uint8]:
    """The edges that a tool used, to be looked at.

    Parameters
    ----------
    picture
        The picture whose edges they are.
    edges, **search
        From `edge_keywords`.

    Returns
    -------
    ndarray
        (H, W), 255 on edges and 0 elsewhere.
    """
    found = editing.find_edges(picture.pixels, **search) if edges is None else edges
    return np.where(found, np.uint8(255), np.uint8(0))


def _read_edges(path: Path, picture: Picture) -> NDArray[np.bool_]:
    """White is an edge, as in a mask white is selected."""
    file = read(path).in_8_bits()
    if file.shape != picture.shape:
        raise InputError(
            f"edges {file.name} are {file.size}, but {picture.name} is {picture.size}; draw them on that picture"
        )
    found: NDArray[np.bool_] = strength(file) >= defaults.THRESHOLD
    return found
