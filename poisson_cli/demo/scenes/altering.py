"""Changing a picture where it is: Figures 9 to 11."""

from __future__ import annotations

from typing import Final

from poisson_cli.demo.command import Command
from poisson_cli.demo.naive import Blurred, Brightened, Grey, Hue, Median, Pasted
from poisson_cli.demo.photographs import Photograph
from poisson_cli.demo.scene import RESULT, Panel, Scene, Selection
from poisson_cli.demo.shapes import Lasso

__all__ = ["SCENES"]

_FLATTEN = Scene(
    name="flatten-cat",
    title="A cat in flat paint",
    figure="Figure 9",
    caption=(
        "The gradients survive only where an edge was found; the others become zero. Fur turns into flat patches; "
        "eyes, whiskers and outlines stay as sharp as they were. A blur takes the outlines first."
    ),
    pictures={"cat.png": Photograph("chelsea.png")},
    selections={
        "face.png": Selection(
            on="cat.png",
            shapes=(
                Lasso(
                    (
                        (30, 60), (60, 5), (200, -40), (370, 5), (385, 90), (360, 190), (300, 285), (180, 320),
                        (60, 250),
                    )
                ),
            ),
        )
    },
    naive={
        "gaussian-blur.png": Pasted(change=Blurred(3)),
        "median.png": Pasted(change=Median(9)),
    },
    commands=(
        Command(
            "flatten cat.png -m face.png --low 4 --high 9 --show-edges edges.png -o result.png --overwrite"
        ),
    ),
    panels=(
        Panel("Before", "fur", "cat.png"),
        Panel("Selection", "a loose loop around the face", "cat.png", "face.png"),
        Panel("Edges", "--show-edges: what will stay", "edges.png"),
        Panel("Gaussian blur", "everything is soft", "gaussian-blur.png"),
        Panel("Median", "whiskers and spots are gone", "median.png"),
        Panel("After", "poisson flatten", RESULT),
    ),
    columns=3,
)  # fmt: skip


_COAT = Scene(
    name="relight-coat",
    title="What the coat looks like",
    figure="Figure 10",
    caption=(
        "An under-exposed figure. Large gradients of the logarithm become smaller and small ones larger: seams, "
        "buttons and folds appear, and the border of the selection does not. A gamma curve brightens the coat too, "
        "and the sky and the grass within the loop with it."
    ),
    pictures={"park.png": Photograph("camera.png")},
    selections={
        "man.png": Selection(
            on="park.png",
            shapes=(
                Lasso(
                    (
                        (-30, 250), (-10, 180), (60, 130), (120, 105), (150, 75), (180, 55), (215, 50), (250, 75),
                        (275, 130), (330, 150), (335, 200), (290, 240), (285, 310), (230, 320), (190, 350),
                        (170, 420), (165, 540), (-30, 540),
                    )
                ),
            ),
        )
    },
    naive={"plain-gamma.png": Pasted(change=Brightened(0.5))},
    commands=(Command("relight park.png -m man.png -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a black coat", "park.png", crop=(0, 20, 420, 420)),
        Panel("Selection", "a loose loop around the figure", "park.png", "man.png", crop=(0, 20, 420, 420)),
        Panel("Gamma curve", "brightens all that was selected", "plain-gamma.png", crop=(0, 20, 420, 420)),
        Panel("After", "poisson relight", RESULT, crop=(0, 20, 420, 420)),
    ),
)  # fmt: skip


_VISOR = Scene(
    name="relight-visor",
    title="A reflection taken away",
    figure="Figure 10",
    caption=(
        "The same tool against a specular reflection: the steep gradients around the window in the visor are the ones "
        "that are attenuated, so that there is next to nothing left of it. White remains white under a gamma curve."
    ),
    pictures={"helmet.png": Photograph("astronaut.png", crop=(240, 300, 512, 512))},
    selections={
        "reflection.png": Selection(
            on="helmet.png",
            shapes=(
                Lasso(((90, 140), (96, 118), (115, 106), (138, 110), (149, 130), (146, 155), (126, 176), (99, 167))),
            ),
        )
    },
    naive={"plain-gamma.png": Pasted(change=Brightened(3))},
    commands=(Command("relight helmet.png -m reflection.png -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a studio lamp in the visor", "helmet.png"),
        Panel("Selection", "a loose loop around it", "helmet.png", "reflection.png"),
        Panel("Gamma curve", "white stays white", "plain-gamma.png"),
        Panel("After", "poisson relight: next to nothing is left", RESULT),
    ),
)  # fmt: skip


_GARAGE: Final = Photograph("motorcycle_left.png")

_DECOLOR = Scene(
    name="recolor-background",
    title="Only the motorcycle",
    figure="Figure 11",
    caption=(
        "The selected part of the colour picture is cloned into a grey version of it, so the loop may be as loose as "
        "this. What the border lacks, the brown of floor and wood, is then missing inside too, and tyres and chrome "
        "turn bluish: the contamination that the paper mentions. With --screen, colours inside are the picture's own."
    ),
    pictures={"garage.png": _GARAGE},
    selections={
        "motorcycle.png": Selection(
            on="garage.png",
            shapes=(
                Lasso(
                    (
                        (60, 250), (60, 160), (140, 110), (220, 120), (290, 110), (370, 90), (480, 30), (580, 80),
                        (630, 170), (640, 240), (700, 300), (720, 400), (690, 470), (560, 480), (440, 440), (340, 470),
                        (180, 450), (90, 400), (60, 320),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted(backdrop=Grey())},
    commands=(
        Command("recolor garage.png -m motorcycle.png --decolor-background -o paper.png --overwrite"),
        Command(
            "recolor garage.png -m motorcycle.png --decolor-background --screen .0005 -o result.png --overwrite"
        ),
    ),
    panels=(
        Panel("Before", "a garage", "garage.png"),
        Panel("Selection", "a loose loop around the motorcycle", "garage.png", "motorcycle.png"),
        Panel("Plain copy", "brown to the loop and not beyond", "plain-paste.png"),
        Panel("As in the paper", "--decolor-background: bluish", "paper.png"),
        Panel("After", "--decolor-background --screen .0005", RESULT),
        Panel("After, closer", "grey shelf, red paint", RESULT, crop=(330, 60, 710, 316)),
    ),
    columns=3,
)  # fmt: skip


_RECOLOR = Scene(
    name="recolor-tank",
    title="Repainted",
    figure="Figure 11",
    caption=(
        "A copy with its colours turned is cloned into the original. Seat, engine and tyre, within the loops as well, "
        "have little colour to turn, and at the border everything is as it was. A little of --screen gives both pieces "
        "the same blue, whatever their borders run through."
    ),
    pictures={"garage.png": _GARAGE},
    selections={
        "paint.png": Selection(
            on="garage.png",
            shapes=(
                Lasso(
                    (
                        (80, 190), (95, 168), (150, 188), (195, 198), (240, 226), (275, 238), (310, 205), (340, 165),
                        (400, 135), (470, 140), (500, 180), (495, 235), (430, 258), (350, 275), (265, 308), (235, 300),
                        (210, 262), (170, 246), (130, 250), (105, 272), (85, 245),
                    )
                ),
                Lasso(
                    (
                        (495, 325), (512, 280), (550, 258), (610, 260), (655, 288), (665, 325), (610, 330), (560, 315),
                        (520, 350),
                    )
                ),
            ),
        )
    },
    naive={"plain-hue.png": Pasted(change=Hue(220))},
    commands=(Command("recolor garage.png -m paint.png --hue 220 --screen .002 -o result.png --overwrite"),),
    panels=(
        Panel("Before", "red", "garage.png"),
        Panel("Selection", "two loose loops", "garage.png", "paint.png"),
        Panel("Colours turned", "those around it as well", "plain-hue.png"),
        Panel("After", "poisson recolor --hue 220 --screen .002", RESULT),
    ),
)  # fmt: skip


SCENES: Final = (_FLATTEN, _COAT, _VISOR, _DECOLOR, _RECOLOR)
