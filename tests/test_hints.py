"""When a run says what would have been better, and when it is silent."""

import json
from pathlib import Path

import numpy as np
import pytest

from poisson_cli.hints import hints
from tests.small_pictures import encoded
from tests.test_report import changed

EVEN = {"boundary_mismatch": (60.0, 60.0, 60.0), "boundary_shift": (60.0, 60.0, 60.0)}
CAST = {"boundary_mismatch": (54.0, 40.0, 50.0), "boundary_shift": (52.0, -5.0, -50.0)}
LARGE = {"boundary_mismatch": (3.0, 100.4, 3.0)}
MANY = {**EVEN, "clipped": 12345 * 3 // 8}


@pytest.mark.parametrize("tool", ["clone", "mix", "heal", "recolor"])
def test_an_even_shift_is_what_these_tools_are_for(tool):
    shift = 60.0 if tool in ("clone", "mix") else 39.0
    assert hints(changed(tool=tool, boundary_mismatch=(shift,) * 3, boundary_shift=(-shift,) * 3)) == []


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        (LARGE, ["the pictures differ by 100 levels on average", "colours bleed in", "--screen .001"]),
        ({**LARGE, "tool": "mix"}, ["the pictures differ by 100 levels on average", "--screen .001"]),
        (
            {**LARGE, "tool": "heal"},
            ["the patch and the picture differ by 100", "a margin of a few", "--from"],
        ),
        (
            {**LARGE, "tool": "recolor"},
            ["the new colours differ by 100", "keeps its colour", "--screen .001"],
        ),
        ({**EVEN, "tool": "heal"}, ["the patch and the picture differ by 60"]),
        ({**EVEN, "tool": "recolor"}, ["the new colours differ by 60"]),
        (CAST, ["differ by +52, -5, -50 levels (R, G, B) on average", "another hue", "--screen .001"]),
        ({**CAST, "tool": "mix"}, ["another hue"]),
        (MANY, ["12% of the values", "--rescale", "--screen .001"]),
        ({"boundary_mismatch": (9.0,), "boundary_shift": (9.0,), "clipped": 2000}, ["16% of the values"]),
        ({"scale": 0.26}, ["to 26%, which leaves a ghost; try --screen .001 or --space lab instead"]),
        ({"scale": 0.26, "guarded": True}, ["ghost; try --space lab instead"]),
        ({"scale": 0.26, "space": "lab"}, ["ghost; try --screen .001 instead"]),
        ({"scale": 0.26, "space": "lab", "guarded": True}, ["ghost; leave --rescale out"]),
        (
            {"scale": 0.26, "tool": "focus"},
            ["to 26% of what was asked for", "no room", "a smaller --amount"],
        ),
        ({"boundary_mismatch": None, "edge_share": 0.0}, ["lower --high and --low, or mark edges"]),
        ({"advice": "multigrid would do"}, ["multigrid would do"]),
    ],
    ids=str,
)
def test_what_is_said(changes, parts):
    (hint,) = hints(changed(**changes))
    for part in parts:
        assert part in hint


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"boundary_mismatch": (99.9, 99.9, 99.9)},
        {"boundary_mismatch": None},
        {**LARGE, "tool": "tile"},
        {**LARGE, "guarded": True},
        {**CAST, "guarded": True},
        {**CAST, "tinted": True},
        {**CAST, "boundary_shift": (52.0, -5.0, -27.9)},
        {**MANY, "guarded": True},
        {**MANY, "clipped": 12345 * 3 // 10},
        {**MANY, "tool": "recolor", "boundary_mismatch": (20.0, 20.0, 20.0)},
        {**MANY, "tool": "focus", "boundary_mismatch": None},
        {"scale": 0.5},
        {"boundary_mismatch": None, "edge_share": 1e-6},
    ],
    ids=str,
)
def test_when_nothing_is_said(changes):
    assert hints(changed(**changes)) == []


def save(name: str, colour: tuple[int, ...] | int, shape: tuple[int, int]) -> None:
    pixels = np.empty((*shape, 3) if isinstance(colour, tuple) else shape, np.uint8)
    pixels[:] = colour
    Path(name).write_bytes(encoded(pixels))


WORDS = ["clone", "cat.png", "coffee.png", "-m", "mask.png", "--overwrite", "-o", "out.png"]


def test_a_clone_that_takes_on_another_hue_says_so_unless_that_is_wanted(folder, poisson):
    save("cat.png", (120, 120, 120), (24, 30))
    save("coffee.png", (170, 115, 70), (40, 48))
    ran = poisson(*WORDS, "--json")
    told = json.loads(ran.out)
    assert ran.code == 0
    assert told["boundary_shift"] == pytest.approx([50, -5, -50])
    assert told["boundary_mismatch"] == pytest.approx([50, 5, 50])
    assert "hint: along the border the pictures differ by +50, -5, -50 levels (R, G, B)" in ran.err
    for remedy in (["--screen", ".001"], ["--monochrome"]):
        ran = poisson(*WORDS, *remedy)
        assert (ran.code, "hint" in ran.err) == (0, False)
    save("cat.png", 120, (24, 30))
    ran = poisson(*WORDS)
    assert (ran.code, "hint" in ran.err) == (0, False)


def test_a_recolouring_whose_border_crosses_colour_says_so(folder, poisson):
    save("red.png", (200, 60, 50), (40, 48))
    save("grey.png", (120, 118, 122), (40, 48))
    for name, said in (("red.png", True), ("grey.png", False)):
        words = ["recolor", name, "--rect", "10,10,12,9", "--hue", "180", "--overwrite", "-o", "out.png"]
        ran = poisson(*words)
        assert ran.code == 0
        assert ("hint: along the border the new colours differ by" in ran.err) == said
        assert "hint" not in poisson(*words, "--screen", ".001").err


def test_a_picture_weakened_to_a_ghost_says_so(folder, poisson):
    save("cat.png", (120, 120, 120), (24, 30))
    save("coffee.png", (250, 250, 250), (40, 48))
    pixels = np.full((24, 30, 3), 120, np.uint8)
    pixels[8:16, 10:20] = 220
    Path("cat.png").write_bytes(encoded(pixels))
    ran = poisson(*WORDS, "--rescale", "--json")
    assert ran.code == 0
    scale = json.loads(ran.out)["scale"]
    assert scale < 0.5
    assert f"hint: --rescale weakened the gradients to {scale:.0%}, which leaves a ghost" in ran.err
