"""Hiding things: Figure 2, and the membrane of equation 2."""

from __future__ import annotations

from typing import Final

from poisson_cli.demo.command import Command
from poisson_cli.demo.naive import Blurred, Pasted
from poisson_cli.demo.photographs import Photograph
from poisson_cli.demo.scene import RESULT, Panel, Scene, Selection
from poisson_cli.demo.shapes import Brush, Lasso

__all__ = ["SCENES"]

_HIDE = Scene(
    name="clone-hide",
    title="Two towers gone",
    figure="Figure 2",
    caption=(
        "To hide something, clone a clean piece of the same photograph over it: here the sky 52 pixels to the right of "
        "each tower, both in one go. The sky is darker there, and plain copying shows it; cloning takes over only the "
        "differences between neighbouring pixels, so brightness and clouds fit on all sides."
    ),
    pictures={"pad.png": Photograph("rocket.jpg")},
    selections={
        "towers.png": Selection(
            on="pad.png",
            shapes=(
                Lasso(
                    (
                        (202, 112), (210, 125), (212, 190), (213, 300), (214, 360), (212, 372), (204, 377),
                        (190, 376), (176, 378), (165, 376), (165, 350), (178, 255), (186, 188), (195, 125),
                    )
                ),
                Lasso(
                    (
                        (445, 112), (453, 125), (462, 190), (472, 280), (480, 340), (484, 378), (486, 440),
                        (470, 440), (468, 408), (460, 394), (450, 387), (440, 380), (434, 368), (434, 260),
                        (436, 190), (440, 125),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted()},
    commands=(
        Command("clone pad.png pad.png -m towers.png --mask-on destination --at -52,0 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "a launch pad at dusk", "pad.png"),
        Panel("Selection", "two loose loops round the towers", "pad.png", "towers.png"),
        Panel("Plain copy", "sky from further right: too dark", "plain-paste.png"),
        Panel("After", "poisson clone: only the gradients are copied", RESULT),
    ),
)  # fmt: skip


_SKYLINE: Final = (92, 46, 212, 136)

_HEAL = Scene(
    name="heal-skyline",
    title="A tower leaves the skyline",
    figure="Figure 2",
    caption=(
        "Concealment without having to say where to copy from. The tool compares what lies around the selection with "
        "every other place of the picture, takes the one that fits best, and says which it took: here 59 pixels to the "
        "right and 10 up, where sky meets roofs and trees just as it does around the tower. Cloned from there, the sky "
        "has the right brightness, and a lower house stands where the tower was."
    ),
    pictures={"park.png": Photograph("camera.png", crop=(272, 60, 512, 240))},
    selections={
        "tower.png": Selection(
            on="park.png",
            shapes=(
                Lasso(
                    (
                        (120, 54), (132, 45), (146, 42), (164, 46), (172, 62), (172, 100), (171, 124), (152, 132),
                        (130, 131), (121, 122), (119, 90),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted(at=(-59, 10))},
    commands=(Command("heal park.png -m tower.png -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a tower", "park.png"),
        Panel("Selection", "a loose loop around it", "park.png", "tower.png"),
        Panel("After", "poisson heal", RESULT),
        Panel("Before, closer", "sky, roofs and trees around it", "park.png", crop=_SKYLINE),
        Panel("Plain copy, closer", "a patch of another grey", "plain-paste.png", crop=_SKYLINE),
        Panel("After, closer", "a lower house", RESULT, crop=_SKYLINE),
    ),
    columns=3,
)  # fmt: skip


_FOLDS: Final = (
    ((-5, 222), (60, 214), (130, 226), (230, 216), (300, 224), (380, 214), (517, 226)),
    ((322, -5), (316, 80), (324, 160), (312, 250), (318, 330), (330, 420), (322, 517)),
    ((90, -5), (110, 60), (104, 120), (124, 160)),
    ((-5, 420), (60, 380), (110, 350), (150, 300)),
)

_CREASES = Scene(
    name="fill-creases",
    title="A folded print, mended",
    figure="Equation 2",
    caption=(
        "Where something is missing and nothing can be copied, the membrane fills in: the smoothest surface that meets "
        "the picture all along the border of the selection. On narrow damage it is hard to tell from the original. "
        "(The folds were drawn by this demo; the selection is a broader stroke along each of them.)"
    ),
    pictures={
        "print.png": Photograph(
            "astronaut.png",
            creases=tuple(Brush(fold, 2) for fold in _FOLDS),
        )
    },
    selections={
        "folds.png": Selection(
            on="print.png",
            shapes=tuple(Brush(fold, 7) for fold in _FOLDS),
        )
    },
    naive={"gaussian-blur.png": Pasted(change=Blurred(3))},
    commands=(Command("fill print.png -m folds.png -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a print that was folded", "print.png"),
        Panel("Selection", "a brush along the folds", "print.png", "folds.png"),
        Panel("After", "poisson fill", RESULT),
        Panel("Before, closer", "the colour has come off", "print.png", crop=(230, 130, 450, 350)),
        Panel("Gaussian blur", "the folds are pale and broad", "gaussian-blur.png", crop=(230, 130, 450, 350)),
        Panel("After, closer", "poisson fill", RESULT, crop=(230, 130, 450, 350)),
    ),
    columns=3,
)  # fmt: skip


SCENES: Final = (_HIDE, _HEAL, _CREASES)
