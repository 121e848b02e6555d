"""Selections on the command line: their order, their shapes, and ``poisson mask``, which shows them."""

import json
from pathlib import Path

import numpy as np
import pytest

from poisson_cli import editing
from poisson_cli.masks import draw_polygon
from poisson_cli.settings import Polygon
from tests.small_pictures import ALPHA, DESTINATION, DESTINATION_MASK, GREY, MASK, SOURCE, encoded, load

SHAPE = DESTINATION_MASK.shape


def box(x: int, y: int, width: int, height: int) -> np.ndarray:
    mask = np.zeros(SHAPE, bool)
    mask[y : y + height, x : x + width] = True
    return mask


A, B, C = box(2, 3, 20, 20), box(10, 10, 30, 8), box(0, 15, 48, 5)
DIAMOND = draw_polygon(Polygon(((4, 20), (20, 36.5), (36, 20), (20, 4))), SHAPE)
RECTS = {"A": "2,3,20,20", "B": "10,10,30,8", "C": "0,15,48,5"}


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("--rect A --rect B", A | B),
        ("--rect A --subtract --rect B", A & ~B),
        ("--rect A --subtract --rect B --rect C", A & ~B & ~C),
        ("--rect A --subtract --rect B --add --rect C", A & ~B | C),
        ("--rect A --rect C --subtract --rect B", (A | C) & ~B),
        ("--rect A --intersect --rect B --add --rect C", A & B | C),
        ("--add --rect A --intersect --rect B --rect C", A & B & C),
        ("--rect A --subtract --rect B --add --rect B", A | B),
        ("--rect A --subtract --rect B --rect C --add -m dest-mask.png", A & ~B & ~C | DESTINATION_MASK),
        ("-m dest-mask.png --subtract --rect A", DESTINATION_MASK & ~A),
        ("--rect A --subtract -m dest-mask.png", A & ~DESTINATION_MASK),
        ("--rect A --intersect -m dest-mask.png --add --rect=B", A & DESTINATION_MASK | B),
        ("--invert-mask --rect A --subtract --rect B", ~(A & ~B)),
        ("--rect A --invert-mask --add --rect B", ~(A | B)),
        ('--polygon "20,4 36.5,20 20,36 4,20"', DIAMOND),
        ('--rect A --intersect --lasso "20,4 36.5,20 20,36 4,20"', A & DIAMOND),
        ("--rect A --subtract --ellipse 2,3,1,1", A & ~box(2, 3, 1, 1)),
        ("--rect A --grow 1 --subtract --rect A", (box(1, 3, 22, 20) | box(2, 2, 20, 22)) & ~A),
        ("--rect A --shrink 2 --rect B", box(4, 5, 16, 16) | B),
        ("--rect A --shrink 2 --shrink 1 --subtract --grow 1 --rect B", None),
    ],
)
def test_options_act_in_their_order(folder, poisson, words, expected):
    import shlex

    for name, numbers in RECTS.items():
        words = words.replace(f"--rect {name}", f"--rect {numbers}").replace(
            f"--rect={name}", f"--rect={numbers}"
        )
    if expected is None:
        inner = box(5, 6, 14, 14)
        expected = (inner | box(4, 6, 16, 14) | box(5, 5, 14, 16)) & ~B
    ran = poisson("mask", "destination.png", *shlex.split(words), "-o", "out.png")
    assert ran.code == 0, ran.err
    out = load("out.png")
    assert out.dtype == np.uint8
    np.testing.assert_array_equal(out, expected * np.uint8(255))


def test_every_command_selects_alike(folder, poisson):
    words = "--rect 2,3,20,20 --subtract --ellipse 5,5,9,9 --add -m dest-mask.png --shrink 1 --invert-mask".split()
    assert poisson("mask", "grey.png", *words, "-o", "m.png").code == 0
    assert poisson("fill", "grey.png", *words, "-o", "one.png").code == 0
    assert poisson("fill", "grey.png", "-m", "m.png", "-o", "two.png").code == 0
    np.testing.assert_array_equal(load("one.png"), load("two.png"))
    np.testing.assert_array_equal(load("one.png"), editing.fill(GREY, load("m.png") > 0).image)


@pytest.mark.parametrize("name", ["destination.png", "grey.png", "alpha.png"])
def test_over_shows_the_selection_on_the_picture(folder, poisson, name):
    ran = poisson("mask", name, "-m", "dest-mask.png", "--over", "-o", "out.png")
    assert ran.code == 0
    out, pixels = load("out.png"), load(name)
    colours = np.dstack([pixels] * 3) if pixels.ndim == 2 else pixels[..., :3]
    assert out.shape == (*SHAPE, 3)
    np.testing.assert_array_equal(out[DESTINATION_MASK], colours[DESTINATION_MASK])
    assert (out[0, 0] == colours[0, 0] // 3).all()
    assert ((out == [255, 214, 10]).all(axis=2) & ~DESTINATION_MASK).any()


def test_over_may_be_a_jpeg_but_a_mask_may_not(folder, poisson):
    ran = poisson("mask", "alpha.png", "-m", "dest-mask.png", "-o", "out.jpg")
    assert (ran.code, ran.err) == (
        4,
        "poisson: error: out.jpg: JPEG would blur the mask; choose another format, such as PNG\n",
    )
    assert not Path("out.jpg").exists()
    lossy = poisson("mask", "alpha.png", "-m", "dest-mask.png", "-o", "out.webp", "--quality", "60")
    assert (lossy.code, "out.webp: WebP would blur the mask" in lossy.err) == (4, True)
    assert poisson("mask", "alpha.png", "-m", "dest-mask.png", "--over", "-o", "out.jpg").code == 0


@pytest.mark.parametrize("ending", ["png", "tif", "bmp", "webp"])
def test_a_mask_is_exact_in_every_other_format(folder, poisson, ending):
    assert poisson("mask", "grey.png", "-m", "dest-mask.png", "-o", f"m.{ending}").code == 0
    assert poisson("mask", "grey.png", "-m", f"m.{ending}", "-o", "back.png").code == 0
    np.testing.assert_array_equal(load("back.png") > 0, DESTINATION_MASK)


def test_what_is_said(folder, poisson):
    words = ("mask", "grey.png", "--rect", "40,30,20,5", "-o", "m.png")
    assert poisson(*words) == (0, "", "mask: 40 of 1,920 pixels at 40,30 (8x5) -> m.png\n")
    assert poisson(*words, "--overwrite", "-q") == (0, "", "")
    assert json.loads(poisson(*words, "--overwrite", "--json").out) == {
        "tool": "mask",
        "output": "m.png",
        "region": 40,
        "pixels": 1920,
        "rectangle": {"x": 40, "y": 30, "width": 8, "height": 5},
        "notices": [],
    }


def test_a_notice_is_said_once_and_told_in_json(folder, poisson):
    ramp = np.repeat(np.arange(48, dtype=np.uint8)[None] * 5, 40, axis=0)
    Path("ramp.png").write_bytes(encoded(ramp))
    for words in (["mask", "grey.png"], ["fill", "grey.png"]):
        ran = poisson(*words, "-m", "ramp.png", "-o", f"{words[0]}-out.png", "--json")
        first, second = ran.err.splitlines()
        # 115, 120, 125 below the threshold and 130, 135, 140 above it.
        assert first == (
            "poisson: note: mask ramp.png has grey edges: it is cut at 128, and 240 of its pixels are less than 16 "
            "levels from there (--mask-threshold moves the cut)"
        )
        assert second.startswith(f"{words[0]}: ")
        assert json.loads(ran.out)["notices"] == [first.removeprefix("poisson: note: ")]


def test_a_whole_file_of_a_colon(folder, poisson):
    Path("a:red").write_bytes(encoded(DESTINATION_MASK.astype(np.uint8) * 255))
    assert poisson("mask", "grey.png", "-m", "a:red", "-o", "m.png").code == 0
    np.testing.assert_array_equal(load("m.png") > 0, DESTINATION_MASK)


# A source that is transparent in places


def cut_out() -> np.ndarray:
    return np.dstack((SOURCE, np.where(MASK, 255, 0).astype(np.uint8)))


def inside(mask: np.ndarray) -> np.ndarray:
    """The pixels whose four neighbours are in it too."""
    padded = np.pad(mask, 1, constant_values=True)
    return mask & padded[2:, 1:-1] & padded[:-2, 1:-1] & padded[1:-1, 2:] & padded[1:-1, :-2]


@pytest.mark.parametrize("mask_name", ["cut.png:alpha", "cut.png"])
def test_the_alpha_of_the_source_as_mask(folder, poisson, mask_name):
    Path("cut.png").write_bytes(encoded(cut_out()))
    ran = poisson("clone", "cut.png", "destination.png", "-m", mask_name, "--at", "7,9", "-o", "out.png")
    assert ran.code == 0
    expected = editing.clone(DESTINATION, SOURCE, inside(MASK), offset=(9, 7)).image
    np.testing.assert_array_equal(load("out.png"), expected)
    lost = MASK.sum() - inside(MASK).sum()
    assert ran.err.startswith(
        f"poisson: note: {lost} selected pixels are left out: the source cut.png is transparent there or beside\n"
    )


def test_colours_under_transparent_pixels_have_no_effect(folder, poisson):
    pixels = cut_out()
    Path("cut.png").write_bytes(encoded(pixels))
    pixels[~MASK] = [255, 0, 255, 0]
    Path("other.png").write_bytes(encoded(pixels))
    for name in ("cut", "other"):
        words = ("mix", f"{name}.png", "destination.png", "--rect", "0,0,30,24", "-o", f"{name}-out.png")
        assert poisson(*words).code == 0
    np.testing.assert_array_equal(load("cut-out.png"), load("other-out.png"))
    assert not np.array_equal(load("cut-out.png"), DESTINATION)


@pytest.mark.parametrize("offset", [(5, 3), (-6, -4), (25, 20)])
def test_a_selection_on_the_destination_is_limited_too(folder, poisson, offset):
    Path("cut.png").write_bytes(encoded(cut_out()))
    x, y = offset
    words = ("clone", "cut.png", "destination.png", "--rect", "0,0,48,40", "--mask-on", "destination")
    assert poisson(*words, "--at", f"{x},{y}", "-o", "out.png").code == 0
    expected = editing.clone(DESTINATION, SOURCE, inside(MASK), offset=(y, x)).image
    np.testing.assert_array_equal(load("out.png"), expected)


def test_an_opaque_source_has_nothing_left_out(folder, poisson):
    Path("soft.png").write_bytes(encoded(np.dstack((SOURCE, np.full(SOURCE.shape[:2], 128, np.uint8)))))
    ran = poisson("clone", "soft.png", "destination.png", "-m", "mask.png", "-o", "out.png")
    assert (ran.code, ran.err.count("\n")) == (0, 1)
    np.testing.assert_array_equal(load("out.png"), editing.clone(DESTINATION, SOURCE, MASK).image)


def test_the_alpha_of_the_destination_as_mask(folder, poisson):
    assert poisson("fill", "alpha.png", "-m", "alpha.png:alpha", "-o", "out.png").code == 0
    expected = editing.fill(DESTINATION, ALPHA[..., 3] >= 128).image
    np.testing.assert_array_equal(load("out.png")[..., :3], expected)
