"""The functions of `poisson_cli.editing`, returning the image alone."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, ParamSpec

import numpy as np
from numpy.typing import NDArray

from poisson_cli import editing

__all__ = ["clone", "fill", "flatten", "focus", "heal", "mix", "recolor", "relight", "tile", "tonemap"]

_P = ParamSpec("_P")


def _image_of(tool: Callable[_P, editing.Edit]) -> Callable[_P, NDArray[Any]]:
    """Wrap a tool so that it returns the edited image instead of an `Edit`; its parameters stay the same."""

    @functools.wraps(tool)
    def image(*args: _P.args, **kwargs: _P.kwargs) -> NDArray[Any]:
        return tool(*args, **kwargs).image

    image.__signature__ = inspect.signature(tool).replace(return_annotation=np.ndarray)  # type: ignore[attr-defined]
    image.__doc__ = (
        f"{inspect.cleandoc(tool.__doc__ or '')}\n\n"
        "This function returns the image of that `Edit` alone; "
        f"`poisson_cli.editing.{tool.__name__}` returns all of it.\n"
    )
    return image


clone = _image_of(editing.clone)
mix = _image_of(editing.mix)
fill = _image_of(editing.fill)
flatten = _image_of(editing.flatten)
relight = _image_of(editing.relight)
recolor = _image_of(editing.recolor)
focus = _image_of(editing.focus)
tile = _image_of(editing.tile)
tonemap = _image_of(editing.tonemap)
heal = _image_of(editing.heal)
