"""Pictures that repeat: Figure 12."""

from __future__ import annotations

from typing import Final

from poisson_cli.demo.command import Command
from poisson_cli.demo.naive import Repeated
from poisson_cli.demo.photographs import Photograph
from poisson_cli.demo.scene import PREVIEW, RESULT, Panel, Scene

__all__ = ["SCENES"]

_TILE = Scene(
    name="tile-wood",
    title="An endless table",
    figure="Figure 12",
    caption=(
        "A piece of the table, brighter on one side than on the other, is to be repeated. Opposite sides are set to "
        "their mean, and the inside follows with its own gradients: the grain stays, the steps are gone."
    ),
    pictures={"coffee.png": Photograph("coffee.png")},
    selections={},
    naive={"plain-repeat.png": Repeated()},
    commands=(
        Command(
            "tile coffee.png --rect 480,120,120,90 --preview preview.png -o result.png --overwrite"
        ),
    ),
    panels=(
        Panel("Before", "a piece of a table", "coffee.png", crop=(480, 120, 600, 210)),
        Panel("Tile", "poisson tile: the same piece, evened out", RESULT),
        Panel("Repeated", "as it is: every border shows", "plain-repeat.png"),
        Panel("After", "the tile repeated: one surface", PREVIEW),
    ),
)  # fmt: skip


SCENES: Final = (_TILE,)
