"""Commands with more than one output: edges, previews, several maps. All of it is written, or nothing."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import tifffile

from poisson_cli import editing
from poisson_cli.images import together
from tests.small_pictures import ALPHA, DESTINATION, DESTINATION_MASK, GREY, MASK, SOURCE, encoded, load

FLATTEN = "flatten destination.png -m dest-mask.png -o out.png --show-edges edges.png".split()
MAPS = "destination.png grey.png alpha.png".split()


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_edges_shown_are_those_used(folder, poisson):
    assert poisson(*FLATTEN, "--low", "3", "--high", "5").code == 0
    edges = load("edges.png")
    np.testing.assert_array_equal(edges, editing.find_edges(DESTINATION, low=3, high=5) * np.uint8(255))
    assert 0 < np.count_nonzero(edges) < edges.size
    np.testing.assert_array_equal(
        load("out.png"), editing.flatten(DESTINATION, DESTINATION_MASK, edges=edges).image
    )


def test_edges_that_were_shown_can_be_given_back(folder, poisson):
    poisson(*FLATTEN)
    words = [*FLATTEN[:5], "again.png", "--edges", "edges.png", "--show-edges", "edges2.png"]
    assert poisson(*words).code == 0
    assert Path("again.png").read_bytes() == Path("out.png").read_bytes()
    assert Path("edges2.png").read_bytes() == Path("edges.png").read_bytes()


def test_the_selection_s_outline_is_no_edge(folder, poisson):
    Path("plain.png").write_bytes(encoded(np.full((40, 48), 90, np.uint8)))
    ran = poisson("flatten", "plain.png", *FLATTEN[2:])
    assert not load("edges.png").any()
    assert ", 0.0% edges, " in ran.err


def test_edges_of_a_clone_are_the_source_s(folder, poisson):
    words = ["clone", "source.png", "destination.png", "-m", "mask.png", "-o", "out.png", "--flatten"]
    ran = poisson(*words, "--show-edges", "edges.png", "--json")
    assert ran.code == 0
    np.testing.assert_array_equal(load("edges.png"), editing.find_edges(SOURCE) * np.uint8(255))
    expected = editing.clone(DESTINATION, SOURCE, MASK, then=[editing.Sieve()])
    np.testing.assert_array_equal(load("out.png"), expected.image)
    assert json.loads(ran.out)["beside"] == {"edges": "edges.png"}
    assert ran.err.endswith("-> out.png, edges -> edges.png\n")


def test_without_opencv_the_error_names_the_extra(folder, poisson, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "cv2", None)
    before = contents(folder)
    ran = poisson(*FLATTEN)
    assert ran.code == 3
    assert "pip install 'poisson-cli[edges]'" in ran.err
    assert contents(folder) == before
    assert poisson(*FLATTEN, "--edges", "grey.png").code == 0


def test_a_preview_is_the_tile_nine_times(folder, poisson):
    words = "tile alpha.png --rect 3,4,20,17 -o tile.png --preview look.png --json".split()
    ran = poisson(*words)
    assert ran.code == 0
    tile = load("tile.png")
    expected = editing.tile(DESTINATION, rect=(4, 3, 17, 20)).image
    np.testing.assert_array_equal(tile, np.dstack((expected, ALPHA[4:21, 3:23, 3])))
    np.testing.assert_array_equal(load("look.png"), np.tile(tile, (3, 3, 1)))
    told = json.loads(ran.out)
    assert (told["beside"], told["region"]) == ({"preview": "look.png"}, None)


def test_a_preview_of_a_grey_picture(folder, poisson):
    assert poisson(*"tile grey.png -o tile.png --preview look.png".split()).code == 0
    np.testing.assert_array_equal(load("look.png"), np.tile(load("tile.png"), (3, 3)))


MANY = {
    "an output each": (["-o", "a.png", "-o", "b.tif", "-o", "c.png"], ["a.png", "b.tif", "c.png"]),
    "a folder": (["-o", "tiles"], [f"tiles/{name}" for name in MAPS]),
}


@pytest.mark.parametrize(("words", "outputs"), MANY.values(), ids=MANY)
def test_several_maps_are_tiled_alike(folder, poisson, words, outputs):
    Path("tiles").mkdir()
    before = contents(folder)
    ran = poisson("tile", *MAPS, "--rect", "2,1,30,25", "--axis", "x", *words, "--json")
    assert ran.code == 0
    for name, output in zip([DESTINATION, GREY, DESTINATION], outputs, strict=True):
        expected = editing.tile(name, rect=(1, 2, 25, 30), axis="x").image
        np.testing.assert_array_equal(load(output)[..., : expected.shape[-1]], expected)
    assert set(contents(folder)) == {*before, *(folder / output for output in outputs)}
    assert [json.loads(line)["output"] for line in ran.out.splitlines()] == outputs
    assert [re.sub(r".*-> ", "", line) for line in ran.err.splitlines()] == outputs


def test_one_picture_into_a_folder(folder, poisson):
    Path("tiles").mkdir()
    assert poisson("tile", "grey.png", "-o", "tiles").code == 0
    np.testing.assert_array_equal(load("tiles/grey.png"), editing.tile(GREY).image)


def test_previews_belong_to_the_pictures_in_their_order(folder, poisson):
    words = "tile destination.png grey.png -o a.png -o b.png --preview look.png".split()
    assert poisson(*words).code == 0
    np.testing.assert_array_equal(load("look.png"), np.tile(load("a.png"), (3, 3, 1)))
    assert poisson(*words, "--preview", "look2.png", "--overwrite").code == 0
    np.testing.assert_array_equal(load("look2.png"), np.tile(load("b.png"), (3, 3)))


COMMANDS = {
    "edges": [*FLATTEN, "--overwrite"],
    "preview": "tile grey.png -o out.png --preview edges.png --overwrite".split(),
    "maps": "tile destination.png grey.png -o out.png -o edges.png --overwrite".split(),
}


@pytest.mark.parametrize("old", [[], ["out.png"], ["out.png", "edges.png"]], ids=str)
@pytest.mark.parametrize("words", COMMANDS.values(), ids=COMMANDS)
def test_a_second_output_that_fails_undoes_the_first(folder, poisson, monkeypatch, words, old):
    """A full disk, met while the last of several files is written."""
    for name in old:
        Path(name).write_bytes(b"precious")
    before = contents(folder)
    written = []
    real = together.write

    def write(target, picture, before_commit):
        if written:
            raise together.OutputError(f"{target.path}: cannot be written (No space left on device)")
        real(target, picture, before_commit)
        written.append(target.path.read_bytes())

    monkeypatch.setattr(together, "write", write)
    ran = poisson(*words)
    assert (ran.code, ran.err) == (
        4,
        "poisson: error: edges.png: cannot be written (No space left on device)\n",
    )
    assert written
    assert written != [b"precious"]
    assert contents(folder) == before


def test_a_map_that_cannot_be_tiled_leaves_nothing_of_the_others(folder, poisson):
    Path("bad.png").write_bytes(encoded(GREY)[:-300])
    before = contents(folder)
    ran = poisson("tile", "destination.png", "bad.png", "-o", "a.png", "-o", "b.png")
    assert ran.code == 3
    assert "bad.png: damaged" in ran.err
    assert contents(folder) == before


def test_heal_says_where_the_patch_is_from(folder, poisson):
    mask = np.zeros(DESTINATION.shape[:2], bool)
    mask[14:22, 20:29] = True
    ran = poisson(*"heal destination.png --rect 20,14,9,8 -o out.png --json".split())
    assert ran.code == 0
    row, col = editing.heal(DESTINATION, mask).report.offset
    assert json.loads(ran.out)["offset"] == {"x": col, "y": row}
    assert f" (--from {col},{row}), " in ran.err
    poisson(*"heal destination.png --rect 20,14,9,8 -o again.png".split(), f"--from={col},{row}")
    np.testing.assert_array_equal(load("again.png"), load("out.png"))


def test_a_clone_that_bleeds_comes_with_a_hint(folder, poisson):
    dark = np.full((24, 30, 3), 5, np.uint8)
    bright = np.full((40, 48, 3), 250, np.uint8)
    Path("dark.png").write_bytes(encoded(dark))
    Path("bright.png").write_bytes(encoded(bright))
    words = ["clone", "dark.png", "bright.png", "-m", "mask.png", "--overwrite", "-o", "out.png"]
    ran = poisson(*words, "--json")
    hint = "along the border the pictures differ by 245 levels on average"
    assert f"\npoisson: hint: {hint}" in ran.err
    assert json.loads(ran.out)["hints"][0].startswith(hint)
    for remedy in (["--screen", ".01"], ["--robust"], ["-q"]):
        assert "hint" not in poisson(*words, *remedy).err


def test_rescaling_says_by_how_much(folder, poisson):
    rng = np.random.default_rng(1)
    Path("harsh.png").write_bytes(encoded(rng.integers(0, 2, (24, 30), np.uint8) * 255))
    words = [
        "clone",
        "harsh.png",
        "grey.png",
        "-m",
        "mask.png",
        "--overwrite",
        "-o",
        "out.png",
        "-v",
        "--json",
    ]
    clipped = poisson(*words)
    rescaled = poisson(*words, "--rescale")
    before, after = json.loads(clipped.out), json.loads(rescaled.out)
    assert before["overshoot"] > 0 and before["clipped"] > 0 and before["scale"] == 1
    assert after["overshoot"] <= 1e-3 and after["clipped"] == 0 and 0 < after["scale"] < 1
    assert f", gradients x {after['scale']:.2g} to fit the range, " in rescaled.err
    assert f", by {before['overshoot']:.1f} levels at most" in clipped.err


@pytest.mark.parametrize(("depth", "dtype"), [("8", np.uint8), ("16", np.uint16)])
def test_tone_mapping_sees_the_whole_range_before_it_is_converted(folder, poisson, depth, dtype):
    """A file of floats may go far beyond white: what is asked for is the depth of the result."""
    light = (DESTINATION / 255.0).astype(np.float32) ** 3 * 40
    tifffile.imwrite("light.tif", light, photometric="rgb")
    words = ["tonemap", "light.tif", "--gamma", "2.2", "--bit-depth", depth, "-o", "out.tif"]
    ran = poisson(*words)
    assert ran.code == 0
    assert "converted from floating point" in ran.err and "outside 0 to 1" not in ran.err
    out = tifffile.imread("out.tif")
    expected = editing.tonemap(light, gamma=2.2).image * np.iinfo(dtype).max
    assert out.dtype == dtype
    np.testing.assert_array_equal(out, np.rint(expected).astype(dtype))


def test_tone_mapping_asks_early_whether_the_depth_fits(folder, poisson):
    tifffile.imwrite("light.tif", np.zeros((9, 9), np.float32))
    ran = poisson("tonemap", "light.tif", "--bit-depth", "16", "-o", "out.jpg")
    assert ran.code == 4
    assert "JPEG cannot hold the depth of light.tif (16 bits per channel)" in ran.err
