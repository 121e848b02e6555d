"""One golden case: its files, its right answer, and what is said when an answer is wrong."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import imageio.v3 as imageio
import numpy as np

from tests import oracles, oracles_tools

CASES = Path(__file__).parent / "cases"

ORACLES: dict[str, Callable[..., np.ndarray]] = {
    "clone": oracles.clone,
    "mix": oracles.mix,
    "fill": oracles.fill,
    "flatten": oracles_tools.flatten,
    "relight": oracles_tools.relight,
    "recolor": oracles_tools.recolor,
    "focus": oracles_tools.focus,
    "tile": oracles_tools.tile,
    "heal": oracles_tools.heal,
    "tonemap": oracles_tools.tonemap,
}

WITH_SOURCE = ("clone", "mix")
WITHOUT_MASK = ("tile", "tonemap")
STRAIGHT = ("clone", "mix", "fill", "flatten", "focus", "tile", "heal")
"""In rgb, these add what they solved to stored values; the others go through a curve."""

NEAR_A_TIE = 1e-3
"""Levels: nearer to a half than this, a value may be rounded either way.  Five times the default tolerance."""

NEAR_A_TIE_AFTER_A_CURVE = 5e-3
"""The same where what was solved goes through powers or exponentials in float32 before it is rounded."""


@dataclass(frozen=True)
class Case:
    """The pictures as `pictures` are given to the tool before `mask`: destination and source, or the image alone.

    Tools that edit a whole picture have no mask; `edges` is the picture that `flatten` is given by that name.
    """

    name: str
    tool: str
    pictures: tuple[np.ndarray, ...]
    mask: np.ndarray | None
    arguments: dict[str, Any] = field(default_factory=dict)
    edges: np.ndarray | None = None

    def given_to(self, tool: Callable[..., np.ndarray]) -> np.ndarray:
        """What a function makes of the case, ours or the oracle's."""
        masks = () if self.mask is None else (self.mask,)
        edges = {} if self.edges is None else {"edges": self.edges}
        return tool(*self.pictures, *masks, **edges, **self.arguments)

    def exact(self) -> np.ndarray:
        """The oracle's answer, float64."""
        return self.given_to(ORACLES[self.tool])

    @property
    def expected(self) -> np.ndarray:
        """The oracle's answer as a picture."""
        return oracles.stored(self.exact(), self.pictures[0].dtype)

    def near_ties(self) -> np.ndarray:
        """(n, 2) or (n, 3): row, column and channel of the values that may be rounded either way."""
        straight = self.arguments.get("space", "rgb") == "rgb" and self.tool in STRAIGHT
        near = NEAR_A_TIE if straight else NEAR_A_TIE_AFTER_A_CURVE
        return np.argwhere(oracles.distance_to_tie(self.exact(), self.pictures[0].dtype) < near)

    def save(self, folder: Path) -> None:
        """Writes every file of the case, the expected picture included."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, picture in zip(("destination", "source"), self.pictures, strict=False):
            write_png(folder / f"{name}.png", picture)
        for name, selected in (("mask", self.mask), ("edges", self.edges)):
            if selected is not None:
                write_png(folder / f"{name}.png", np.where(selected != 0, 255, 0).astype(np.uint8))
        write_png(folder / "expected.png", self.expected)
        facts = {"tool": self.tool, "arguments": self.arguments, "near_ties": self.near_ties().tolist()}
        lines = ",\n".join(f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in facts.items())
        (folder / "case.json").write_text(f"{{\n{lines}\n}}\n")


@dataclass(frozen=True)
class Stored:
    """A case as its folder has it: the inputs, and the answer of the day it was added."""

    case: Case
    expected: np.ndarray
    near_ties: np.ndarray

    @classmethod
    def load(cls, folder: Path) -> "Stored":
        facts = json.loads((folder / "case.json").read_text())
        arguments = {key: tuple(v) if isinstance(v, list) else v for key, v in facts["arguments"].items()}
        files = {path.stem: read_png(path) for path in folder.glob("*.png")}
        pictures = tuple(files[name] for name in ("destination", "source") if name in files)
        case = Case(folder.name, facts["tool"], pictures, files.get("mask"), arguments, files.get("edges"))
        expected = files["expected"]
        near_ties = np.array(facts["near_ties"], int).reshape(-1, expected.ndim)
        return cls(case, expected, near_ties)

    def check(self, actual: np.ndarray, folder: Path) -> None:
        """AssertionError, and two pictures in `folder` to look at, unless the answer is the expected one."""
        assert actual.dtype == self.expected.dtype
        assert actual.shape == self.expected.shape
        off = np.abs(actual.astype(int) - self.expected)
        allowed = np.zeros_like(off)
        allowed[tuple(self.near_ties.T)] = 1
        wrong = np.where(off > allowed, off, 0)
        if not wrong.any():
            return
        write_png(folder / "actual.png", actual)
        write_png(folder / "difference.png", (wrong * (255 / wrong.max())).astype(np.uint8))
        row, col, *channel = (int(i) for i in np.unravel_index(wrong.argmax(), wrong.shape))
        at = (row, col, *channel)
        raise AssertionError(
            f"{self.case.name}: {np.count_nonzero(wrong)} values differ, the worst at row {row}, column {col}"
            + (f", channel {channel[0]}" if channel else "")
            + f": {actual[at]} instead of {self.expected[at]}.\n"
            f"Look at {folder / 'actual.png'} and at {folder / 'difference.png'},"
            f" brightened {255 / wrong.max():.0f} times."
        )


def all_cases() -> list[Path]:
    """The folders of all cases, by name."""
    return sorted(path.parent for path in CASES.glob("*/case.json"))


def read_png(path: Path) -> np.ndarray:
    """A picture as an (H, W) or (H, W, C) array, read-only."""
    picture = np.asarray(imageio.imread(path, plugin="pillow"))
    picture.flags.writeable = False
    return picture


def write_png(path: Path, picture: np.ndarray) -> None:
    imageio.imwrite(path, picture, plugin="pillow", optimize=True)
