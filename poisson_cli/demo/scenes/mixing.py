"""Keeping the stronger detail of two pictures: Figures 6 to 8."""

from __future__ import annotations

from typing import Final

from poisson_cli.demo.command import Command
from poisson_cli.demo.naive import Pasted
from poisson_cli.demo.photographs import Coat, Photograph
from poisson_cli.demo.scene import RESULT, Panel, Scene, Selection
from poisson_cli.demo.shapes import Lasso

__all__ = ["SCENES"]

_MURAL = Scene(
    name="mix-mural",
    title="A mural on a brick wall",
    figure="Figure 6",
    caption=(
        "Painting on a textured wall. Cloning wipes the bricks out; averaging the gradients of both pictures leaves "
        "half of each. Mixing keeps, for every pair of neighbouring pixels, the stronger of the two gradients: the "
        "joints of the wall show through wherever the painting is plain, and no outline has to be cut. (The wall is "
        "used in negative, for pale bricks and dark joints.)"
    ),
    pictures={
        "logo.png": Photograph("logo.png", size=(360, 360), margin=40),
        "wall.png": Photograph("brick.png", quarter_turns=1, levels=(235, 65), coat=Coat((255, 236, 200), 0.2)),
    },
    selections={
        "loop.png": Selection(
            on="logo.png",
            shapes=(
                Lasso(
                    (
                        (222, 22), (300, 26), (370, 74), (414, 145), (417, 226), (408, 310), (356, 376), (290, 414),
                        (214, 418), (140, 410), (74, 362), (30, 296), (22, 214), (34, 134), (86, 66), (150, 28),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted()},
    commands=(
        Command("clone logo.png wall.png -m loop.png --at 42,40 -o clone.png --overwrite"),
        Command("clone logo.png wall.png -m loop.png --at 42,40 --gradients average -o average.png --overwrite"),
        Command("mix logo.png wall.png -m loop.png --at 42,40 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "a wall of pale bricks", "wall.png"),
        Panel("Selection", "a loose loop around a drawing on white", "logo.png", "loop.png"),
        Panel("Plain copy", "a sticker", "plain-paste.png"),
        Panel("Cloned", "poisson clone: the bricks are gone", "clone.png"),
        Panel("Averaged", "--gradients average: half of each", "average.png"),
        Panel("After", "poisson mix: painted on the bricks", RESULT),
    ),
    columns=3,
)  # fmt: skip


_REFLECTION = Scene(
    name="mix-reflection",
    title="Mission in the visor",
    figure="Figure 7",
    caption=(
        "Something transparent: a launch pad reflected in a visor. The loop is not even drawn along the helmet. Mixing "
        "keeps the stronger gradient of the two photographs, so the rim and the highlights of the helmet stay where "
        "they are, and rocket, towers and lamps appear in the black glass between them."
    ),
    pictures={
        "pad.png": Photograph("rocket.jpg", size=(269, 179), mirrored=True),
        "helmet.png": Photograph("astronaut.png", crop=(150, 250, 512, 512)),
    },
    selections={
        "loop.png": Selection(
            on="pad.png",
            shapes=(
                Lasso(
                    (
                        (70, 20), (135, 14), (200, 20), (235, 60), (238, 100), (235, 140), (200, 174), (135, 176),
                        (70, 174), (35, 140), (28, 100), (32, 60),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted()},
    commands=(
        Command("clone pad.png helmet.png -m loop.png --at 108,88 -o clone.png --overwrite"),
        Command("mix pad.png helmet.png -m loop.png --at 108,88 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "an astronaut's helmet", "helmet.png"),
        Panel("Selection", "a loose loop, mirror-inverted", "pad.png", "loop.png"),
        Panel("Plain copy", "covers the helmet", "plain-paste.png"),
        Panel("Cloned", "poisson clone: rim and highlights are lost", "clone.png"),
        Panel("After", "poisson mix: a reflection", RESULT),
        Panel("After, closer", "highlight and rocket, both", RESULT, crop=(140, 92, 340, 237)),
    ),
    columns=3,
)  # fmt: skip


_GALAXIES = Scene(
    name="mix-galaxies",
    title="Deep field over the launch pad",
    figure="Figure 7",
    caption=(
        "The Hubble telescope's galaxies are brighter than the evening sky, its black is not: mixing takes the first "
        "and leaves the second. The glow of dusk and the lattice of the towers stay, although the selection runs right "
        "across them; it only goes round the rocket."
    ),
    pictures={
        "galaxies.png": Photograph("hubble_deep_field.jpg", crop=(14, 78, 814, 612), size=(640, 427)),
        "pad.png": Photograph("rocket.jpg"),
    },
    selections={
        "sky.png": Selection(
            on="pad.png",
            shapes=(
                Lasso(
                    (
                        (-90, -60), (320, -60), (730, -60), (760, 140), (730, 345), (600, 347), (500, 345),
                        (400, 345), (352, 325), (343, 250), (341, 140), (322, 110), (303, 140), (301, 250),
                        (292, 325), (250, 345), (150, 347), (40, 345), (-90, 345), (-120, 140),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted()},
    commands=(Command("mix galaxies.png pad.png -m sky.png --mask-on destination -o result.png --overwrite"),),
    panels=(
        Panel("Before", "dusk", "pad.png"),
        Panel("Selection", "the sky, towers included", "pad.png", "sky.png"),
        Panel("Plain copy", "black, and the towers are gone", "plain-paste.png"),
        Panel("After", "poisson mix", RESULT),
    ),
)  # fmt: skip


_CLOSE = Scene(
    name="mix-close",
    title="One more coin",
    figure="Figure 8",
    caption=(
        "A coin is put into a gap so narrow that the loop around it runs across the neighbours. Cloning starts from "
        "their brightness, which bleeds into the selection; mixing keeps their edges and stops it."
    ),
    pictures={"tray.png": Photograph("coins.png")},
    selections={
        "coin.png": Selection(
            on="tray.png",
            shapes=(
                Lasso(((337, 98), (357, 104), (363, 124), (355, 143), (337, 150), (318, 143), (311, 124), (318, 104))),
            ),
        )
    },
    naive={"plain-paste.png": Pasted()},
    commands=(
        Command("clone tray.png tray.png -m coin.png --at -32,-36 -o clone.png --overwrite"),
        Command("mix tray.png tray.png -m coin.png --at -32,-36 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "a gap among four coins", "tray.png", crop=(234, 10, 378, 154)),
        Panel("Selection", "a coin of the same tray", "tray.png", "coin.png", crop=(234, 10, 378, 154)),
        Panel("Plain copy", "cuts into the neighbours", "plain-paste.png", crop=(234, 10, 378, 154)),
        Panel("Cloned", "poisson clone: the neighbours bleed", "clone.png", crop=(234, 10, 378, 154)),
        Panel("After", "poisson mix", RESULT, crop=(234, 10, 378, 154)),
        Panel("After, all of it", "which one is new?", RESULT),
    ),
    columns=3,
)  # fmt: skip


SCENES: Final = (_MURAL, _REFLECTION, _GALAXIES, _CLOSE)
