"""What the gallery shows. A new scene is one more entry in `SCENES`, whatever the tool.

Coordinates are X, Y in pixels of the prepared pictures, as image viewers show them. The selections were drawn by eye,
loosely on purpose: where the paper's method works, there is no need to be precise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from poisson_cli.demo.command import Command
from poisson_cli.demo.photographs import Coat, Photograph
from poisson_cli.demo.shapes import Brush, Lasso, Shape

__all__ = ["PASTE", "RESULT", "SCENES", "SHEET", "Panel", "Scene", "Selection"]

RESULT: Final = "result.png"
"""The picture that a scene is about; its last command writes it."""

PASTE: Final = "plain-paste.png"
"""What plain copying makes of the last command; written for scenes whose last command takes two pictures."""

SHEET: Final = "sheet.png"


@dataclass(frozen=True)
class Selection:
    """A selection drawn on one of the scene's pictures.

    Parameters
    ----------
    on
        The picture's file name.
    shapes
        Selected is what any of them covers.
    """

    on: str
    shapes: tuple[Shape, ...]


@dataclass(frozen=True)
class Panel:
    """One picture on a sheet.

    Parameters
    ----------
    label
        What it is, in a word or two.
    note
        One line more about it.
    picture
        Its file name.
    selection
        File name of the mask to outline on it, None for the bare picture.
    crop
        Part to show: left, top, right, bottom in pixels; None for all of it.
    """

    label: str
    note: str
    picture: str
    selection: str | None = None
    crop: tuple[int, int, int, int] | None = None


@dataclass(frozen=True)
class Scene:
    """One example: pictures and selections to prepare, commands to run, and how to show what came of it.

    Parameters
    ----------
    name
        The scene's folder: the tool and a word.
    title
        What happens, for a headline.
    figure
        Where the paper shows this kind of edit.
    caption
        What to look at and why it works.
    pictures
        Photographs by the file names they get; all end in ``.png``.
    selections
        Masks by the file names they get.
    commands
        What to run in order; the last one writes `RESULT`.
    panels
        The sheet, row by row.
    columns
        Panels in a row.
    """

    name: str
    title: str
    figure: str
    caption: str
    pictures: Mapping[str, Photograph]
    selections: Mapping[str, Selection]
    commands: tuple[Command, ...]
    panels: tuple[Panel, ...]
    columns: int = 2

    @property
    def has_paste(self) -> bool:
        """Whether the last command brings one picture into another, so that plain copying could be tried instead."""
        return len(self.commands[-1].pictures) == 2


_LAUNCH_PAD: Final = Photograph("rocket.jpg")


_HIDE = Scene(
    name="clone-hide",
    title="Two towers gone",
    figure="Figure 2",
    caption=(
        "To hide something, clone a clean piece of the same photograph over it: here the sky 52 pixels to the right of "
        "each tower, both in one go. The sky is darker there, and plain copying shows it; cloning takes over only the "
        "differences between neighbouring pixels, so brightness and clouds fit on all sides."
    ),
    pictures={"pad.png": _LAUNCH_PAD},
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
    commands=(
        Command("clone pad.png pad.png -m towers.png --mask-on destination --at -52,0 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "a launch pad at dusk", "pad.png"),
        Panel("Selection", "two loose loops round the towers", "pad.png", "towers.png"),
        Panel("Plain copy", "sky from further right: too dark", PASTE),
        Panel("After", "poisson clone: only the gradients are copied", RESULT),
    ),
)  # fmt: skip


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
    commands=(Command("clone coin.png coffee.png -m loop.png --at 182,86 -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a coloured photograph", "coffee.png"),
        Panel("Selection", "a loose loop on a grey photograph", "coin.png", "loop.png"),
        Panel("Plain copy", "grey, and with its background", PASTE),
        Panel("After", "poisson clone", RESULT),
    ),
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
    commands=(
        Command("clone cat.png cup.png -m face.png --at 118,180 -o colour.png --overwrite"),
        Command("clone cat.png cup.png -m face.png --at 118,180 --monochrome -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "an espresso", "cup.png"),
        Panel("Selection", "a loose loop around the face", "cat.png", "face.png"),
        Panel("Plain copy", "a cut-out", PASTE),
        Panel("In colour", "poisson clone: green eyes, pink nose", "colour.png"),
        Panel("After", "poisson clone --monochrome", RESULT),
        Panel("After, closer", "the crema lends its colour", RESULT, crop=(150, 170, 410, 387)),
    ),
    columns=3,
)  # fmt: skip


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
    commands=(
        Command("clone logo.png wall.png -m loop.png --at 42,40 -o clone.png --overwrite"),
        Command("clone logo.png wall.png -m loop.png --at 42,40 --gradients average -o average.png --overwrite"),
        Command("mix logo.png wall.png -m loop.png --at 42,40 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "a wall of pale bricks", "wall.png"),
        Panel("Selection", "a loose loop around a drawing on white", "logo.png", "loop.png"),
        Panel("Plain copy", "a sticker", PASTE),
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
    commands=(
        Command("clone pad.png helmet.png -m loop.png --at 108,88 -o clone.png --overwrite"),
        Command("mix pad.png helmet.png -m loop.png --at 108,88 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "an astronaut's helmet", "helmet.png"),
        Panel("Selection", "a loose loop, mirror-inverted", "pad.png", "loop.png"),
        Panel("Plain copy", "covers the helmet", PASTE),
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
        "pad.png": _LAUNCH_PAD,
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
    commands=(Command("mix galaxies.png pad.png -m sky.png --mask-on destination -o result.png --overwrite"),),
    panels=(
        Panel("Before", "dusk", "pad.png"),
        Panel("Selection", "the sky, towers included", "pad.png", "sky.png"),
        Panel("Plain copy", "black, and the towers are gone", PASTE),
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
    commands=(
        Command("clone tray.png tray.png -m coin.png --at -32,-36 -o clone.png --overwrite"),
        Command("mix tray.png tray.png -m coin.png --at -32,-36 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Before", "a gap among four coins", "tray.png", crop=(234, 10, 378, 154)),
        Panel("Selection", "a coin of the same tray", "tray.png", "coin.png", crop=(234, 10, 378, 154)),
        Panel("Plain copy", "cuts into the neighbours", PASTE, crop=(234, 10, 378, 154)),
        Panel("Cloned", "poisson clone: the neighbours bleed", "clone.png", crop=(234, 10, 378, 154)),
        Panel("After", "poisson mix", RESULT, crop=(234, 10, 378, 154)),
        Panel("After, all of it", "which one is new?", RESULT),
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
    commands=(Command("fill print.png -m folds.png -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a print that was folded", "print.png"),
        Panel("Selection", "a brush along the folds", "print.png", "folds.png"),
        Panel("After", "poisson fill", RESULT),
    ),
    columns=3,
)  # fmt: skip


SCENES: Final = (_HIDE, _INSERT, _MONOCHROME, _MURAL, _REFLECTION, _GALAXIES, _CLOSE, _CREASES)
"""Every scene, in the order of the page."""
