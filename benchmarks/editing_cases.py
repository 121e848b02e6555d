"""The tools on one pair of photographs: our call, the oracle's, and OpenCV's where it has the tool.

The oracles are those of the tests (`tests.oracles`, `tests.oracles_tools`), which know neither us nor OpenCV.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks import pictures
from benchmarks.case import Case
from benchmarks.peers.opencv import cv2_box

Array = np.ndarray[Any, Any]
Call = Callable[[], Array]

LOW, HIGH = 6.0, 12.0  # Canny's thresholds in levels per pixel
SOBEL = 8.0  # OpenCV's own are so many times that
GAIN = (1.5, 0.5, 0.5)  # the paper's, for red, green, blue
OFFSET = (100, 100)  # where a patch for `heal` comes from, relative to the selection


@dataclass(frozen=True)
class Row:
    """One tool on one picture."""

    name: str
    ours: Call
    exact: Call  # (H, W, 3) float64, not clipped; never on the clock
    before: Array  # (H, W, 3) uint8: what the picture must be outside the region
    region: Array  # (H, W) bool, True = may change
    their_name: str = ""
    theirs: Call | None = None

    @property
    def tasks(self) -> dict[str, Call]:
        """Ours, and theirs if there is one."""
        mine = {self.name: self.ours}
        return mine if self.theirs is None else mine | {self.their_name: self.theirs}


def every(case: Case, cv2: ModuleType | None) -> Iterator[Row]:
    """All rows, those with an answer by OpenCV first; without OpenCV, given as `cv2`, none has."""
    import poisson_cli
    from poisson_cli import editing
    from poisson_cli.editing.transforms import Scale
    from tests import oracles, oracles_tools

    f, g, mask = case.destination, case.source, case.region
    opencv = None if cv2 is None else OpenCV(cv2, case)
    one = {"threads": 1}

    def beside(name: str, call: str) -> dict[str, Any]:
        return {} if opencv is None else {"their_name": name, "theirs": getattr(opencv, call)}

    yield Row(
        "clone",
        lambda: poisson_cli.clone(f, g, mask, **one),
        lambda: oracles.clone(f, g, mask),
        f,
        mask,
        **beside("NORMAL_CLONE", "normal"),
    )
    yield Row(
        "mix",
        lambda: poisson_cli.mix(f, g, mask, **one),
        lambda: oracles.mix(f, g, mask),
        f,
        mask,
        **beside("MIXED_CLONE", "mixed"),
    )
    yield Row(
        "clone --monochrome",
        lambda: poisson_cli.clone(f, g, mask, monochrome=True, **one),
        lambda: oracles.clone(f, g, mask, monochrome=True),
        f,
        mask,
        **beside("MONOCHROME_TRANSFER", "monochrome"),
    )
    if cv2 is not None:
        from poisson_cli.editing.edges import find_edges

        edges = find_edges(f, low=LOW, high=HIGH)
        yield Row(
            "flatten",
            lambda: poisson_cli.flatten(f, mask, low=LOW, high=HIGH, **one),
            lambda: oracles_tools.flatten(f, mask, edges=edges),
            f,
            mask,
            **beside("textureFlattening", "flattening"),
        )
    yield Row(
        "relight",
        lambda: poisson_cli.relight(f, mask, **one),
        lambda: oracles_tools.relight(f, mask),
        f,
        mask,
        **beside("illuminationChange", "illumination"),
    )
    yield Row(
        "relight --per-channel",
        lambda: poisson_cli.relight(f, mask, per_channel=True, **one),
        lambda: oracles_tools.relight(f, mask, per_channel=True),
        f,
        mask,
        **beside("illuminationChange", "illumination"),
    )
    yield Row(
        "recolor",
        lambda: poisson_cli.recolor(f, mask, gain=GAIN, **one),
        lambda: oracles_tools.recolor(f, mask, gain=GAIN),
        f,
        mask,
        **beside("colorChange", "colour"),
    )
    yield Row(
        "recolor --decolor-background",
        lambda: poisson_cli.recolor(f, mask, decolor_background=True, **one),
        lambda: oracles_tools.recolor(f, mask, decolor_background=True),
        oracles_tools.stored_luminance(f),
        mask,
    )
    for space in ("linear", "lab"):
        yield Row(
            f"clone --space {space}",
            lambda space=space: poisson_cli.clone(f, g, mask, space=space, **one),
            lambda space=space: oracles.clone(f, g, mask, space=space),
            f,
            mask,
        )
    yield Row(
        "clone --screen .003",
        lambda: poisson_cli.clone(f, g, mask, screen=0.003, **one),
        lambda: oracles.clone(f, g, mask, screen=0.003),
        f,
        mask,
    )
    yield Row(
        "clone --focus 1.5",
        lambda: poisson_cli.clone(f, g, mask, then=[Scale(1.5)], **one),
        lambda: oracles.clone(f, g, mask, then=[oracles_tools.scale(1.5)]),
        f,
        mask,
    )
    yield Row(
        "focus",
        lambda: poisson_cli.focus(f, mask, amount=1.5, **one),
        lambda: oracles_tools.focus(f, mask, amount=1.5),
        f,
        mask,
    )
    yield Row("fill", lambda: poisson_cli.fill(f, mask, **one), lambda: oracles.fill(f, mask), f, mask)
    yield Row(
        "heal --from",
        lambda: poisson_cli.heal(f, mask, offset=OFFSET, **one),
        lambda: oracles_tools.heal(f, mask, offset=OFFSET),
        f,
        mask,
    )
    everything = np.ones(mask.shape, bool)
    yield Row(
        "tonemap (all 262,144 pixels)",
        lambda: poisson_cli.tonemap(f, **one),
        lambda: oracles_tools.tonemap(f),
        f,
        everything,
    )
    wide = pictures.destination(512, 1024)  # room for a patch as large as the selection
    selected = np.pad(mask, ((0, 0), (0, 512)))
    patch = editing.heal(wide, selected, **one).report.offset
    assert patch is not None
    yield Row(
        "heal, searching in 512 x 1024",
        lambda: poisson_cli.heal(wide, selected, **one),
        lambda: oracles_tools.heal(wide, selected, offset=patch),
        wide,
        selected,
    )
    side = int(np.sqrt(case.unknowns)) + 2
    rect = ((512 - side) // 2, (512 - side) // 2, side, side)
    crop = f[rect[0] : rect[0] + side, rect[1] : rect[1] + side]
    yield Row(
        "tile",
        lambda: poisson_cli.tile(f, rect=rect, **one),
        lambda: oracles_tools.tile(f, rect=rect),
        crop,
        np.ones((side, side), bool),
    )


class OpenCV:
    """OpenCV's tools on a case, with the options nearest to ours; each call returns (H, W, 3) uint8."""

    def __init__(self, cv2: ModuleType, case: Case) -> None:
        cv2.setNumThreads(1)
        self._cv2 = cv2
        self._destination, self._source = case.destination, case.source
        self._mask = case.region.astype(np.uint8) * 255
        row, col, height, width = cv2_box(case.region)
        self._centre = (col + width // 2, row + height // 2)

    def normal(self) -> Array:
        return self._clone(self._cv2.NORMAL_CLONE)

    def mixed(self) -> Array:
        return self._clone(self._cv2.MIXED_CLONE)

    def monochrome(self) -> Array:
        return self._clone(self._cv2.MONOCHROME_TRANSFER)

    def _clone(self, flag: int) -> Array:
        # A copy of the mask each time: the call overwrites it.
        mask = self._mask.copy()
        return np.asarray(self._cv2.seamlessClone(self._source, self._destination, mask, self._centre, flag))

    def flattening(self) -> Array:
        return np.asarray(
            self._cv2.textureFlattening(
                self._destination,
                self._mask.copy(),
                low_threshold=SOBEL * LOW,
                high_threshold=SOBEL * HIGH,
                kernel_size=3,
            )
        )

    def illumination(self) -> Array:
        return np.asarray(
            self._cv2.illuminationChange(self._destination, self._mask.copy(), alpha=0.2, beta=0.2)
        )

    def colour(self) -> Array:
        """It takes pictures to be blue, green, red, and ours are red, green, blue: the first is its blue."""
        red, green, blue = GAIN
        return np.asarray(
            self._cv2.colorChange(
                self._destination, self._mask.copy(), red_mul=blue, green_mul=green, blue_mul=red
            )
        )
