"""Putting one picture into another: Figures 3 to 5."""

from __future__ import annotations

from typing import Final

from poisson_cli.demo.command import Command
from poisson_cli.demo.naive import Pasted
from poisson_cli.demo.photographs import Photograph
from poisson_cli.demo.scene import RESULT, Panel, Scene, Selection
from poisson_cli.demo.shapes import Lasso

__all__ = ["SCENES"]

_INSERT = Scene(
    name="clone-insert",
    title="A tip for the coffee",
    figure="Figure 3",
    caption=(
        "The coin comes from a grey photograph of a museum tray, and some of the black tray is inside the loop. It "
        "disappears: along the loop the result equals the wooden table, and from there inwards only differences "
        "between neighbouring pixels are added. That is also why silver becomes bronze."
    ),
    pictures={
        "coin.png": Photograph("coins.png", crop=(292, 0, 384, 90), size=(115, 92)),
        "coffee.png": Photograph("coffee.png", crop=(290, 40, 600, 300)),
    },
    selections={
        "loop.png": Selection(
            on="coin.png",
            shapes=(
                Lasso(
                    (
                        (95, 44), (90, 62), (74, 74), (53, 80), (32, 74), (16, 62), (12, 44), (16, 27), (32, 15),
                        (53, 9), (74, 15), (90, 27),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted(), "alpha-blend.png": Pasted(feather=4)},
    commands=(Command("clone coin.png coffee.png -m loop.png --at 182,86 -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a coloured photograph", "coffee.png"),
        Panel("Selection", "a loose loop on a grey photograph", "coin.png", "loop.png"),
        Panel("Plain copy", "grey, and with its background", "plain-paste.png"),
        Panel("Alpha blend", "soft, and still grey", "alpha-blend.png"),
        Panel("After", "poisson clone", RESULT),
        Panel("After, closer", "bronze on wood", RESULT, crop=(150, 60, 310, 194)),
    ),
    columns=3,
)  # fmt: skip


_EXCHANGE = Scene(
    name="clone-exchange",
    title="The Cheshire cat",
    figure="Figure 4",
    caption=(
        "One feature for another: an astronaut's smile for Chelsea's. Here the place matters, the outline still does "
        "not: skin becomes fur, and the light on the lips comes from the cat's side of the loop."
    ),
    pictures={
        "face.png": Photograph("astronaut.png", crop=(160, 40, 300, 190), size=(448, 480)),
        "cat.png": Photograph("chelsea.png", size=(902, 600)),
    },
    selections={
        "smile.png": Selection(
            on="face.png",
            shapes=(
                Lasso(
                    (
                        (118, 320), (160, 300), (208, 304), (256, 298), (288, 315), (282, 350), (240, 378), (196, 382),
                        (146, 364),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted(), "alpha-blend.png": Pasted(feather=9)},
    commands=(Command("clone face.png cat.png -m smile.png --at 308,213 -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a serious cat", "cat.png", crop=(290, 240, 830, 600)),
        Panel("Selection", "a loose loop around a smile", "face.png", "smile.png", crop=(0, 150, 448, 449)),
        Panel("Plain copy", "a cut-out", "plain-paste.png", crop=(290, 240, 830, 600)),
        Panel("Alpha blend", "human skin around it", "alpha-blend.png", crop=(290, 240, 830, 600)),
        Panel("After", "poisson clone", RESULT, crop=(290, 240, 830, 600)),
        Panel("After, all of it", "the Cheshire cat", RESULT),
    ),
    columns=3,
)  # fmt: skip


_MONOCHROME = Scene(
    name="clone-monochrome",
    title="Latte art",
    figure="Figure 5",
    caption=(
        "Texture without colour. Cloned as she is, Chelsea the cat keeps green eyes and a pink nose. With --monochrome "
        "only light and dark are taken from her, and all colour comes from the coffee."
    ),
    pictures={
        "cat.png": Photograph("chelsea.png", size=(330, 192)),
        "cup.png": Photograph("coffee.png", crop=(150, 10, 420, 235), size=(540, 450)),
    },
    selections={
        "face.png": Selection(
            on="cat.png",
            shapes=(
                Lasso(
                    (
                        (80, 16), (140, 7), (205, 8), (252, 24), (278, 60), (270, 110), (240, 150), (205, 180),
                        (160, 180), (110, 160), (70, 130), (45, 100), (40, 62), (52, 34),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted()},
    commands=(
        Command("clone cat.png cup.png -m face.png --at 118,180 -o colour.png --overwrite"),
        Command("clone cat.png cup.png -m face.png --at 118,180 --monochrome -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "an espresso", "cup.png"),
        Panel("Selection", "a loose loop around the face", "cat.png", "face.png"),
        Panel("Plain copy", "a cut-out", "plain-paste.png"),
        Panel("In colour", "poisson clone: green eyes, pink nose", "colour.png"),
        Panel("After", "poisson clone --monochrome", RESULT),
        Panel("After, closer", "the crema lends its colour", RESULT, crop=(150, 170, 410, 387)),
    ),
    columns=3,
)  # fmt: skip


SCENES: Final = (_INSERT, _EXCHANGE, _MONOCHROME)
