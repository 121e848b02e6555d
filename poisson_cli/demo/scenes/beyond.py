"""What the paper proposes in its conclusion, what it builds on, and what it leaves open: colours that bleed in."""

from __future__ import annotations

from typing import Final

from poisson_cli.demo.command import Command
from poisson_cli.demo.naive import Brightened, Contrasted, Pasted
from poisson_cli.demo.photographs import Coat, Photograph
from poisson_cli.demo.scene import RESULT, Panel, Scene, Selection
from poisson_cli.demo.shapes import Lasso

__all__ = ["SCENES"]

_FOCUS = Scene(
    name="focus-cat",
    title="Look at me",
    figure="Section 5",
    caption=(
        "All gradients in the selection times 1.6: fur, whiskers and eyes gain contrast, and nothing tells where that "
        "begins. Stretching the values of the selection gives the same contrast and an outline."
    ),
    pictures={"cat.png": Photograph("chelsea.png")},
    selections={
        "face.png": Selection(
            on="cat.png",
            shapes=(
                Lasso(
                    (
                        (60, 70), (120, 20), (240, 0), (360, 40), (390, 120), (360, 220), (280, 290), (160, 280),
                        (80, 200),
                    )
                ),
            ),
        )
    },
    naive={"plain-contrast.png": Pasted(change=Contrasted(1.6))},
    commands=(Command("focus cat.png -m face.png --amount 1.6 --space lab -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a dull light", "cat.png"),
        Panel("Selection", "a loose loop around the face", "cat.png", "face.png"),
        Panel("Values stretched", "see the right edge of the loop", "plain-contrast.png"),
        Panel("After", "poisson focus --amount 1.6 --space lab", RESULT),
    ),
)  # fmt: skip


_DRAWN = Scene(
    name="mix-drawn",
    title="Painted on the wall",
    figure="Section 5",
    caption=(
        "Cloning and editing in one go, as the paper's conclusion proposes: what is brought over are the gradients at "
        "the edges of the photograph only (--flatten), and those half as strong again (--focus 1.5). So the cat is "
        "painted rather than pasted, in flat patches, and the joints of the wall run through her. A little of --screen "
        "gives her the darks of her own picture back."
    ),
    pictures={
        "cat.png": Photograph("chelsea.png", size=(540, 360)),
        "wall.png": Photograph(
            "brick.png", quarter_turns=1, levels=(235, 65), coat=Coat((214, 150, 110), 0.45)
        ),
    },
    selections={
        "face.png": Selection(
            on="cat.png",
            shapes=(
                Lasso(
                    (
                        (30, 60), (100, 10), (240, 5), (430, 15), (470, 100), (430, 230), (350, 320), (230, 345),
                        (90, 310), (40, 200),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted(), "alpha-blend.png": Pasted(feather=14)},
    commands=(
        Command("mix cat.png wall.png -m face.png --at 0,80 -o mix.png --overwrite"),
        Command(
            "mix cat.png wall.png -m face.png --at 0,80 --flatten --focus 1.5 --screen .0005 "
            "-o result.png --overwrite"
        ),
    ),
    panels=(
        Panel("Before", "a brick wall", "wall.png", crop=(0, 60, 512, 460)),
        Panel("Selection", "a loose loop around the face", "cat.png", "face.png"),
        Panel("Plain copy", "a sticker", "plain-paste.png", crop=(0, 60, 512, 460)),
        Panel("Alpha blend", "a worn sticker", "alpha-blend.png", crop=(0, 60, 512, 460)),
        Panel("Mixed", "poisson mix: a projection", "mix.png", crop=(0, 60, 512, 460)),
        Panel("After", "--flatten --focus 1.5 --screen .0005: a painting", RESULT, crop=(0, 60, 512, 460)),
    ),
    columns=3,
)  # fmt: skip


_CLOSER: Final = (90, 120, 390, 322)

_TONEMAP = Scene(
    name="tonemap-garage",
    title="Light in the garage",
    figure="Section 1",
    caption=(
        "The relative that the paper starts from (Fattal, Lischinski and Werman 2002): over the whole picture, large "
        "gradients of the logarithm are made smaller and small ones larger, scale by scale. Seat, tyre and lettering "
        "come out of the black, and the wall behind out of the shadow, while bright places keep their detail. A gamma "
        "curve that brightens the darks as much bleaches the rest."
    ),
    pictures={"garage.png": Photograph("motorcycle_left.png")},
    selections={},
    naive={"plain-gamma.png": Pasted(change=Brightened(0.5))},
    commands=(Command("tonemap garage.png -o result.png --overwrite"),),
    panels=(
        Panel("Before", "a flash in the dark", "garage.png"),
        Panel("Gamma curve", "0.5: brighter and paler", "plain-gamma.png"),
        Panel("After", "poisson tonemap", RESULT),
        Panel("Before, closer", "black", "garage.png", crop=_CLOSER),
        Panel("Gamma curve, closer", "grey", "plain-gamma.png", crop=_CLOSER),
        Panel("After, closer", "leather, tread and lettering", RESULT, crop=_CLOSER),
    ),
    columns=3,
)  # fmt: skip


_COFFEE: Final = {
    "cat.png": Photograph("chelsea.png", size=(330, 192)),
    "cup.png": Photograph("coffee.png", crop=(150, 10, 420, 235), size=(540, 450)),
}

_FACE: Final = {
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
}  # fmt: skip

_CUP: Final = (130, 165, 424, 366)

_SCREEN = Scene(
    name="clone-screen",
    title="A cat that keeps her colours",
    figure="",
    caption=(
        "The price of a seamless border: the difference between the two pictures there, coffee minus cat, is spread "
        "over all of the inside, and the cat turns orange. With --screen the source's own colours come back away from "
        "the border; --space lab alone keeps light and dark apart better, but not the colours."
    ),
    pictures=_COFFEE,
    selections=_FACE,
    naive={"plain-paste.png": Pasted(), "alpha-blend.png": Pasted(feather=8)},
    commands=(
        Command("clone cat.png cup.png -m face.png --at 118,180 -o clone.png --overwrite"),
        Command("clone cat.png cup.png -m face.png --at 118,180 --space lab -o lab.png --overwrite"),
        Command("clone cat.png cup.png -m face.png --at 118,180 --screen .002 -o result.png --overwrite"),
    ),
    panels=(
        Panel("Selection", "a loose loop around the face", "cat.png", "face.png", crop=(20, 0, 300, 192)),
        Panel("Plain copy", "a cut-out", "plain-paste.png", crop=_CUP),
        Panel("Alpha blend", "a halo", "alpha-blend.png", crop=_CUP),
        Panel("Cloned", "poisson clone: coffee bleeds in", "clone.png", crop=_CUP),
        Panel("In Lab", "--space lab: darks stay dark", "lab.png", crop=_CUP),
        Panel("After", "--screen .002: her own colours", RESULT, crop=_CUP),
    ),
    columns=3,
)


_RESCALE = Scene(
    name="clone-rescale",
    title="Black stays black",
    figure="",
    caption=(
        "Coffee has much red and little blue, and so has the cat that is cloned into it: less blue than none in her "
        "dark stripes and pupils. Cutting that off turns them brown. With --rescale nothing is cut off: colours that "
        "cannot be had lose as much saturation as they must, at the same brightness, and contrast is reduced where "
        "that is not enough, here to 98 %."
    ),
    pictures=_COFFEE,
    selections=_FACE,
    naive={"plain-paste.png": Pasted()},
    commands=(
        Command("clone cat.png cup.png -m face.png --at 118,180 -o clone.png --overwrite"),
        Command("clone cat.png cup.png -m face.png --at 118,180 --rescale -o result.png --overwrite"),
    ),
    panels=(
        Panel("Selection", "a loose loop around the face", "cat.png", "face.png", crop=(20, 0, 300, 192)),
        Panel("Plain copy", "a cut-out", "plain-paste.png", crop=_CUP),
        Panel("Cloned", "poisson clone: 8,677 values clipped", "clone.png", crop=_CUP),
        Panel("After", "poisson clone --rescale", RESULT, crop=_CUP),
    ),
)


_ROBUST = Scene(
    name="clone-robust",
    title="A light that must not spread",
    figure="",
    caption=(
        "The border of this selection runs through the glare of a lamp, where the two pictures differ far more than "
        "anywhere else. Cloning spreads the difference over the sky. With --robust such pixels of the border count no "
        "more than the others do."
    ),
    pictures={"pad.png": Photograph("rocket.jpg", crop=(60, 60, 340, 427))},
    selections={
        "tower.png": Selection(
            on="pad.png",
            shapes=(
                Lasso(
                    (
                        (142, 52), (150, 65), (152, 130), (153, 240), (157, 290), (162, 308), (160, 319), (144, 322),
                        (130, 322), (118, 322), (107, 318), (103, 290), (118, 195), (126, 128), (135, 65),
                    )
                ),
            ),
        )
    },
    naive={"plain-paste.png": Pasted()},
    commands=(
        Command("clone pad.png pad.png -m tower.png --mask-on destination --at -52,0 -o clone.png --overwrite"),
        Command(
            "clone pad.png pad.png -m tower.png --mask-on destination --at -52,0 --robust -o result.png --overwrite"
        ),
    ),
    panels=(
        Panel("Selection", "its border meets the rays of lamps", "pad.png", "tower.png", crop=(20, 180, 270, 367)),
        Panel("Plain copy", "too dark", "plain-paste.png", crop=(20, 180, 270, 367)),
        Panel("Cloned", "poisson clone: the light bleeds", "clone.png", crop=(20, 180, 270, 367)),
        Panel("After", "poisson clone --robust", RESULT, crop=(20, 180, 270, 367)),
    ),
)  # fmt: skip


SCENES: Final = (_FOCUS, _DRAWN, _TONEMAP, _SCREEN, _RESCALE, _ROBUST)
