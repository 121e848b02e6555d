"""Every command does what the function of the same name does, whatever its options, and says so."""

import itertools
import json
import re
from pathlib import Path

import click
import numpy as np
import pytest
import tifffile
from PIL import Image

from poisson_cli import editing
from poisson_cli.main import cli
from tests.small_pictures import (
    ALPHA,
    DESTINATION,
    DESTINATION_MASK,
    GREY,
    MASK,
    SOURCE,
    encoded,
    load,
)

CLONE = ("clone", "source.png", "destination.png", "-m", "mask.png")
MIX = ("mix", "source.png", "destination.png", "-m", "mask.png")
FILL = ("fill", "destination.png", "-m", "dest-mask.png")

EDITED = ("destination.png", "-m", "dest-mask.png")
PATCH = np.zeros(DESTINATION.shape[:2], bool)
PATCH[4:14, 5:17] = True
HEAL = ("heal", "destination.png", "--rect", "5,4,12,10")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (CLONE, lambda: editing.clone(DESTINATION, SOURCE, MASK)),
        (MIX, lambda: editing.mix(DESTINATION, SOURCE, MASK)),
        (FILL, lambda: editing.fill(DESTINATION, DESTINATION_MASK)),
        (("flatten", *EDITED), lambda: editing.flatten(DESTINATION, DESTINATION_MASK)),
        (("relight", *EDITED), lambda: editing.relight(DESTINATION, DESTINATION_MASK)),
        (("recolor", *EDITED), lambda: editing.recolor(DESTINATION, DESTINATION_MASK)),
        (
            ("focus", *EDITED, "--amount", "1.5"),
            lambda: editing.focus(DESTINATION, DESTINATION_MASK, amount=1.5),
        ),
        (HEAL, lambda: editing.heal(DESTINATION, PATCH)),
        (("tile", "destination.png"), lambda: editing.tile(DESTINATION)),
        (("tonemap", "destination.png"), lambda: editing.tonemap(DESTINATION)),
    ],
    ids=lambda words: words[0] if isinstance(words, tuple) else "",
)
def test_defaults_are_those_of_the_function(folder, poisson, words, expected):
    ran = poisson(*words, "-o", "out.png")
    assert (ran.code, ran.out) == (0, "")
    edit = expected()
    np.testing.assert_array_equal(load("out.png"), edit.image)
    assert np.array_equal(edit.image, DESTINATION) == (words[0] == "recolor")


def all_pairs(choices: dict[str, list]) -> list[dict]:
    """Few enough combinations that every pair of values of different options occurs in one of them."""
    names = list(choices)
    wanted = {
        ((a, x), (b, y))
        for a, b in itertools.combinations(names, 2)
        for x in range(len(choices[a]))
        for y in range(len(choices[b]))
    }
    rng = np.random.default_rng(0)
    rows = []
    while wanted:
        candidates = [{name: int(rng.integers(len(choices[name]))) for name in names} for _ in range(60)]
        (a, x), (b, y) = min(wanted)
        for candidate in candidates:
            candidate[a], candidate[b] = x, y
        pairs = [set(itertools.combinations(candidate.items(), 2)) & wanted for candidate in candidates]
        best = max(range(len(candidates)), key=lambda i: len(pairs[i]))
        wanted -= pairs[best]
        rows.append({name: choices[name][i] for name, i in candidates[best].items()})
    return rows


# Each value: words on the command line, and what they mean to the function (or to the test, under a name in capitals).
PLACEMENTS = [
    ([], {}),
    (["--at", "-9,-6"], {"offset": (-6, -9)}),
    (["--at=20,10"], {"offset": (10, 20)}),
]
SELECTIONS = [
    (["-m", "{mask}"], {"SHAPES": ["mask"]}),
    (["--rect", "3,4,20,12"], {"SHAPES": ["rectangle"]}),
    (["-m", "{mask}", "--rect", "-5,-5,20,12"], {"SHAPES": ["mask", "overhang"]}),
    (
        "--lasso/3,4 23,4 23,16 3,16/--subtract/--polygon/5,6 9,6 9,10 5,10/--grow/1/--add".split("/")
        + "--ellipse 12,20,1,1 --intersect --rect 0,0,30,24 --shrink 1".split(),
        {"SHAPES": ["drawn"]},
    ),
]
SOLVERS = [
    ([], {}),
    (["--cycle", "V"], {"cycle": "V"}),
    (["--cycle", "W"], {"cycle": "W"}),
    (["--solver", "sor"], {"solver": "sor"}),
    (["--solver", "multigrid", "--cycle", "W"], {"cycle": "W"}),
]
INVERSIONS = [([], {}), (["--invert-mask"], {"INVERT": True})]
THRESHOLDS = [([], {"THRESHOLD": 128}), (["--mask-threshold", "60"], {"THRESHOLD": 60})]
TOLERANCES = [([], {}), (["--tolerance", "1e-5"], {"tolerance": 1e-5})]
LIMITS = [([], {}), (["--max-iterations", "20000"], {"max_iterations": 20000})]
THREADS = [([], {}), (["--threads", "2"], {"threads": 2})]
REPORTS = [
    ([], {}),
    (["-q"], {}),
    (["-v"], {}),
    (["--json"], {}),
    (["-q", "--json"], {}),
    (["-v", "--json"], {}),
]
OUTPUTS = [
    (["-o", "out.png"], {}),
    (["-o", "out.tif", "--overwrite"], {}),
    (["-o", "old.bmp", "--overwrite"], {}),
    (["-o", "out.WebP"], {}),
    (["-o", "out.dat", "--format", "png", "--bit-depth", "8"], {}),
    (["-o", "out.tif", "--bit-depth", "16"], {"DEPTH": np.uint16}),
    (["-o", "out.tiff", "--bit-depth", "float"], {"DEPTH": np.float32}),
]
CERTIFIED = [([], {}), (["--certify"], {"certify": True})]
LARGEST = [([], {}), (["--max-pixels", "1920"], {})]
SHARED = {
    "selection": SELECTIONS,
    "invert": INVERSIONS,
    "threshold": THRESHOLDS,
    "solver": SOLVERS,
    "tolerance": TOLERANCES,
    "limit": LIMITS,
    "threads": THREADS,
    "report": REPORTS,
    "output": OUTPUTS,
    "certify": CERTIFIED,
    "largest": LARGEST,
}
PLACED = {
    **SHARED,
    "at": PLACEMENTS,
    "mask_on": [
        ([], {"mask_on": "source"}),
        (["--mask-on", "source"], {"mask_on": "source"}),
        (["--mask-on", "destination"], {"mask_on": "destination"}),
    ],
}
SPACES = [([], {}), (["--space", "linear"], {"space": "linear"}), (["--space", "lab"], {"space": "lab"})]
RESCALES = [([], {}), (["--rescale"], {"rescale": True})]
SCREENS = [([], {}), (["--screen", ".01"], {"screen": 0.01})]
ROBUSTS = [([], {}), (["--robust"], {"robust": True})]
EDGES = [
    ([], {}),
    (["--low", "2.5", "--high", "5"], {"low": 2.5, "high": 5}),
    (["--sigma", "2.5"], {"sigma": 2.5}),
    (["--edges", "edges.png"], {"edges": DESTINATION[:, :, 0] >= 128}),
]
RELIGHTS = [
    ([], {}),
    (["--alpha", ".5", "--beta", "-.1"], {"alpha": 0.5, "beta": -0.1}),
    (["--beta", "0"], {"beta": 0}),
]
THENS = [
    ([], {}),
    (["--focus", "1.5"], {"then": [editing.Scale(1.5)]}),
    (["--focus", "0"], {"then": [editing.Scale(0)]}),
    (["--flatten", "--sigma", "0"], {"then": [editing.Sieve(sigma=0)]}),
    (["--flatten", "--low", "2.5", "--high", "5"], {"then": [editing.Sieve(low=2.5, high=5)]}),
    (["--relight", "--alpha", ".3", "--beta", ".3"], {"then": [editing.Attenuate(0.3, 0.3)]}),
    (
        ["--relight", "--focus", "2", "--flatten", "--edges", "source-edges.png"],
        {"then": [editing.Sieve(SOURCE[:, :, 0] >= 128), editing.Scale(2), editing.Attenuate()]},
    ),
]
TONED = {"space": SPACES, "rescale": RESCALES}
IMPORTED = {**PLACED, **TONED, "screen": SCREENS, "robust": ROBUSTS, "then": THENS}
CLONED = {
    **IMPORTED,
    "gradients": [
        ([], {}),
        (["--gradients", "source"], {}),
        (["--gradients", "average"], {"gradients": "average"}),
    ],
    "monochrome": [([], {}), (["--monochrome"], {"monochrome": True})],
}
OF_SELECTIONS = ("selection", "invert", "threshold")
WHOLE = {name: choices for name, choices in SHARED.items() if name not in OF_SELECTIONS}
ALTERED = {**SHARED, **TONED}
IN_PLACE = {
    "fill": {**SHARED, "space": SPACES},
    "flatten": {**ALTERED, "edges": EDGES},
    "relight": {
        **SHARED,
        "rescale": RESCALES,
        "relight": RELIGHTS,
        "per_channel": [  # each channel's logarithm is not defined in Lab
            *SPACES,
            (["--per-channel"], {"per_channel": True}),
            (["--per-channel", "--space", "linear"], {"per_channel": True, "space": "linear"}),
        ],
    },
    "recolor": {
        **ALTERED,
        "screen": SCREENS,
        "gain": [([], {}), (["--gain", "1.5,.5,.5"], {"gain": (1.5, 0.5, 0.5)})],
        "hue": [([], {}), (["--hue", "-90"], {"hue": -90})],
        "saturation": [([], {}), (["--saturation", "0"], {"saturation": 0})],
        "decolor": [([], {}), (["--decolor-background"], {"decolor_background": True})],
    },
    "focus": {
        **ALTERED,
        "amount": [(["--amount", "2"], {"amount": 2}), (["--amount", "0"], {"amount": 0})],
    },
    "heal": {
        **WHOLE,
        **TONED,
        "screen": SCREENS,
        "robust": ROBUSTS,
        "selection": [
            (["--rect", "20,14,9,8"], {"SHAPES": ["patch"]}),
            (["-m", "patch.png", "--mask-threshold", "60"], {"SHAPES": ["patch"]}),
            (
                "--polygon/20,14 29,14 29,22 20,22/--grow/1/--shrink/1/--subtract/--ellipse/24,17,3,2".split(
                    "/"
                )
                + "--add/--ellipse/24,17,3,2/--intersect/--lasso/20,14 29,14 29,22 20,22".split("/"),
                {"SHAPES": ["patch"]},
            ),
        ],
        "offset": [
            ([], {}),
            (["--reach", "15"], {"reach": 15}),
            (["--from", "-16,3"], {"offset": (3, -16)}),
        ],
    },
    "tile": {
        **WHOLE,
        **TONED,
        "rect": [([], {}), (["--rect", "2,5,30,21"], {"rect": (5, 2, 21, 30)})],
        "axis": [([], {}), (["--axis", "x"], {"axis": "x"}), (["--axis", "y"], {"axis": "y"})],
    },
    "tonemap": {
        **WHOLE,
        "space": SPACES,
        "alpha": [([], {}), (["--alpha", ".2", "--beta", ".2"], {"alpha": 0.2, "beta": 0.2})],
        "saturation": [([], {}), (["--saturation", "1"], {"saturation": 1})],
        "white": [([], {}), (["--white", "90", "--gamma", "1.8"], {"white": 90, "gamma": 1.8})],
        "black": [([], {}), (["--black", "2", "--floor", ".05"], {"black": 2, "floor": 0.05})],
    },
}


def soft(mask: np.ndarray) -> np.ndarray:
    """A mask with a rim of 60 around it, which only a low threshold selects."""
    rim = mask.copy()
    rim[1:] |= mask[:-1]
    return np.where(mask, 200, np.where(rim, 60, 0)).astype(np.uint8)


def expected_mask(meaning: dict, mask: np.ndarray) -> np.ndarray:
    selected = np.zeros(mask.shape, bool)
    for shape in meaning.pop("SHAPES"):
        if shape == "mask":
            selected |= soft(mask) >= meaning["THRESHOLD"]
        elif shape == "rectangle":
            selected[4:16, 3:23] = True
        elif shape == "patch":
            selected[14:22, 20:29] = True
        elif (
            shape == "drawn"
        ):  # a rectangle with a hole, a pixel wider; a pixel beside it; all of that a pixel narrower
            selected[4:16, 3:23] = True
            selected[6:10, 5:9] = False
            selected = ~narrowed(~selected)
            selected[20, 12] = True
            selected = narrowed(selected)
        else:
            selected[:7, :15] = True
    meaning.pop("THRESHOLD", None)
    return ~selected if meaning.pop("INVERT", False) else selected


def narrowed(selected: np.ndarray) -> np.ndarray:
    """Less what has a neighbour that is not selected; the edge of the picture is no border."""
    padded = np.pad(selected, 1, mode="edge")
    return selected & padded[2:, 1:-1] & padded[:-2, 1:-1] & padded[1:-1, 2:] & padded[1:-1, :-2]


def in_depth(picture: np.ndarray, depth: type) -> np.ndarray:
    """An 8-bit picture in another one."""
    if depth is np.float32:
        return picture / np.float32(255)
    return picture.astype(np.uint16) * 257 if depth is np.uint16 else picture


def ids(row: dict) -> str:
    return " ".join(" ".join(words) for words, _ in row.values())


def prepared(folder: Path) -> set[Path]:
    """Puts pictures into the folder that the options name, and says what is in it then."""
    Path("on-source.png").write_bytes(encoded(soft(MASK)))
    Path("on-destination.png").write_bytes(encoded(soft(DESTINATION_MASK)))
    Path("edges.png").write_bytes(encoded(DESTINATION[:, :, 0]))
    Path("source-edges.png").write_bytes(encoded(SOURCE[:, :, 0]))
    patch = np.zeros(DESTINATION.shape[:2], np.uint8)
    patch[14:22, 20:29] = 255
    Path("patch.png").write_bytes(encoded(patch))
    Path("old.bmp").write_bytes(b"old")
    return set(folder.iterdir())


def split(row: dict, mask_name: str) -> tuple[list[str], dict]:
    words = [word.format(mask=mask_name) for option, _ in row.values() for word in option]
    meaning = {name: value for _, option in row.values() for name, value in option.items()}
    return words, meaning


def check_saved(folder: Path, words: list[str], image: np.ndarray, existing: set[Path]) -> None:
    output = folder / words[words.index("-o") + 1]
    saved = load(output) if image.dtype == np.uint8 else tifffile.imread(output)
    assert saved.dtype == image.dtype
    np.testing.assert_array_equal(saved, image)
    assert set(folder.iterdir()) == {*existing, output}


def check_said(ran, words: list[str]) -> None:
    assert bool(ran.out) == ("--json" in words)
    aside = ("poisson: hint: ", "poisson: note: ")
    lines = [line for line in ran.err.splitlines() if not line.startswith(aside)]
    assert len(lines) > 4 if "-v" in words else len(lines) == ("-q" not in words)


@pytest.mark.parametrize(
    ("tool", "row"),
    [(tool, row) for tool, choices in (("clone", CLONED), ("mix", IMPORTED)) for row in all_pairs(choices)],
    ids=lambda value: value if isinstance(value, str) else ids(value),
)
def test_options_of_clone_and_mix_mean_what_the_keywords_mean(folder, poisson, tool, row):
    existing = prepared(folder)
    words, meaning = split(row, "on-{}.png".format("destination" if "destination" in ids(row) else "source"))
    mask = expected_mask(meaning, MASK if meaning["mask_on"] == "source" else DESTINATION_MASK)
    depth = meaning.pop("DEPTH", np.uint8)
    destination, source = in_depth(DESTINATION, depth), in_depth(SOURCE, depth)

    ran = poisson(tool, "source.png", "destination.png", *words)

    assert ran.code == 0, ran.err
    check_saved(folder, words, getattr(editing, tool)(destination, source, mask, **meaning).image, existing)
    check_said(ran, words)


@pytest.mark.parametrize(
    ("tool", "row"),
    [(tool, row) for tool, choices in IN_PLACE.items() for row in all_pairs(choices)],
    ids=lambda value: value if isinstance(value, str) else ids(value),
)
def test_options_of_the_other_tools_mean_what_the_keywords_mean(folder, poisson, tool, row):
    existing = prepared(folder)
    words, meaning = split(row, "on-destination.png")
    masks = [expected_mask(meaning, DESTINATION_MASK)] if "SHAPES" in meaning else []
    destination = in_depth(DESTINATION, meaning.pop("DEPTH", np.uint8))

    ran = poisson(tool, "destination.png", *words)

    assert ran.code == 0, ran.err
    check_saved(folder, words, getattr(editing, tool)(destination, *masks, **meaning).image, existing)
    check_said(ran, words)


@pytest.mark.parametrize("tool", [*IN_PLACE, "clone", "mix"])
def test_every_tool_reads_a_page_and_writes_a_quality(folder, poisson, tool):
    """The two options that ask for files of their own kinds."""
    pages = [Image.fromarray(DESTINATION[::-1]), Image.fromarray(DESTINATION)]
    pages[0].save("pages.tif", save_all=True, append_images=pages[1:])
    words = {"tile": [], "tonemap": [], "heal": ["--rect", "20,14,9,8"]}.get(tool, ["--rect", "5,4,12,10"])
    words += ["--amount", "2"] if tool == "focus" else []
    sources = ["source.png"] if tool in ("clone", "mix") else []
    assert poisson(tool, *sources, "destination.png", *words, "-o", "one.png").code == 0
    assert poisson(tool, *sources, "pages.tif", *words, "--page", "2", "-o", "two.png").code == 0
    np.testing.assert_array_equal(load("two.png"), load("one.png"))
    for quality in ("20", "90"):
        outcome = poisson(
            tool, *sources, "destination.png", *words, "--quality", quality, "-o", f"{quality}.jpg"
        )
        assert outcome.code == 0
    assert Path("20.jpg").stat().st_size < Path("90.jpg").stat().st_size
    off = [np.abs(load(f"{quality}.jpg").astype(int) - load("one.png")).mean() for quality in (20, 90)]
    assert off[1] < off[0] < 30


def test_every_option_is_crossed_with_every_tool():
    """Nothing that a command can be told is missing above, but for what says nothing of the picture."""
    alone = {"page", "quality", "previews", "show"}  # the test above; `test_cli_outputs`
    impossible = {"heal": {"invert"}}  # next to all of a picture has no place in it
    for tool, choices in {"clone": CLONED, "mix": IMPORTED, **IN_PLACE}.items():
        said = {
            word for options in choices.values() for words, _ in options for word in words if word[0] == "-"
        }
        said = {word.partition("=")[0] for word in said}
        command = cli.get_command(click.Context(cli), tool)
        for parameter in command.params:
            if isinstance(parameter, click.Option) and parameter.name not in alone | impossible.get(
                tool, set()
            ):
                assert said & {*parameter.opts, *parameter.secondary_opts}, (tool, parameter.opts)


def test_pairs_are_complete():
    for choices in (IMPORTED, CLONED, *IN_PLACE.values()):
        rows = [ids(row) for row in all_pairs(choices)]
        values = {
            name: [" ".join(words) for words, _ in options if words] for name, options in choices.items()
        }
        for a, b in itertools.combinations(values, 2):
            for x, y in itertools.product(values[a], values[b]):
                assert any(x in row and y in row for row in rows), (x, y)


def test_one_line_says_what_was_done(folder, poisson):
    rows, cols = np.nonzero(MASK)
    assert (rows.min(), np.ptp(rows) + 1, cols.min(), np.ptp(cols) + 1) == (5, 15, 6, 19)
    ran = poisson(*CLONE, "--at", "-2,3", "-o", "out.png")
    assert re.fullmatch(
        rf"clone: {MASK.sum():,} pixels at 4,8 \(19x15\), multigrid F x \d+, error < 0\.000\d+ levels, "
        r"(\d+ values? clipped, )?\d+ ms -> out\.png\n",
        ran.err,
    )


def test_quiet_says_nothing(folder, poisson):
    assert poisson(*FILL, "-o", "out.png", "-q") == (0, "", "")


def test_verbose_says_more(folder, poisson):
    ran = poisson(*CLONE, "--at", "30,0", "-o", "out.png", "-v")
    first, *rest = ran.err.splitlines()
    assert first.startswith("clone: ")
    assert [text.split()[0] for text in rest] == [
        "selected",
        "mismatch",
        "method",
        "error",
        "clipped",
        "stages",
    ]
    assert re.search(rf"selected +{MASK.sum()} pixels, \d+ of them inside the picture", rest[0])
    assert re.search(r"stages +read .* ms, select .* ms, guidance .*, solve .*, paste .*, write .*", rest[-1])


def test_json_is_one_object_with_everything(folder, poisson):
    ran = poisson(*CLONE, "--at", "-12,5", "-o", "out.png", "--json", "--tolerance", "0.001")
    told = json.loads(ran.out)
    assert ran.out.count("\n") == 1
    report = editing.clone(DESTINATION, SOURCE, MASK, offset=(5, -12), tolerance=0.001).report
    seconds = told.pop("seconds")
    assert told == {
        "tool": "clone",
        "output": "out.png",
        "beside": {},
        "region": int(MASK.sum()),
        "rectangle": {"x": 0, "y": 10, "width": 13, "height": 15},
        "unknowns": report.unknowns,
        "solver": "multigrid",
        "cycle": "F",
        "method": "multigrid F",
        "iterations": report.iterations,
        "tolerance": 0.001,
        "error_estimate": report.error_estimate,
        "error_bound": None,
        "advice": None,
        "hints": [],
        "floating": False,
        "boundary_mismatch": list(report.boundary_mismatch),
        "boundary_shift": list(report.boundary_shift),
        "outliers": report.outliers,
        "space": "rgb",
        "overshoot": report.overshoot,
        "clipped": report.clipped,
        "scale": 1.0,
        "offset": None,
        "edge_share": None,
        "profile_dropped": False,
        "notices": [],
    }
    assert told["unknowns"] < told["region"]
    assert list(seconds) == ["read", "select", "guidance", "solve", "paste", "write", "total"]
    assert seconds["total"] == pytest.approx(sum(seconds.values()) / 2)


def test_json_of_a_tool_without_source_and_of_sor(folder, poisson):
    told = json.loads(poisson(*FILL, "-o", "out.png", "--json", "--solver", "sor").out)
    assert (told["boundary_mismatch"], told["solver"], told["cycle"]) == (None, "sor", None)


def test_a_picture_without_known_pixels_is_said_in_the_line(folder, poisson):
    ran = poisson("fill", "grey.png", "--rect", "0,0,48,40", "-o", "out.png")
    assert "no known pixel around a part: its mean is kept" in ran.err


def test_clipped_values_are_said_in_the_line(folder, poisson):
    rng = np.random.default_rng(1)
    Path("harsh.png").write_bytes(encoded(rng.integers(0, 2, (24, 30), np.uint8) * 255))
    ran = poisson("clone", "harsh.png", "grey.png", "-m", "mask.png", "-o", "out.png")
    clipped = editing.clone(GREY, load("harsh.png"), MASK).report.clipped
    assert clipped > 1
    assert f", {clipped:,} values clipped, " in ran.err


def test_masks_are_joined(folder, poisson):
    left, right = np.zeros((2, 40, 48), np.uint8)
    left[5:20, 4:10] = right[12:30, 8:40] = 255
    Path("left.png").write_bytes(encoded(left))
    Path("right.png").write_bytes(encoded(right))
    assert poisson("fill", "grey.png", "-m", "left.png", "--mask", "right.png", "-o", "out.png").code == 0
    np.testing.assert_array_equal(load("out.png"), editing.fill(GREY, (left | right) > 0).image)


def test_alpha_of_the_destination_is_kept(folder, poisson):
    assert poisson("clone", "source.png", "alpha.png", "-m", "mask.png", "-o", "out.png").code == 0
    out = load("out.png")
    np.testing.assert_array_equal(out[..., 3], ALPHA[..., 3])
    np.testing.assert_array_equal(out[..., :3], editing.clone(DESTINATION, SOURCE, MASK).image)


def test_grey_source_into_colour_and_colour_into_grey(folder, poisson):
    Path("note.png").write_bytes(encoded(SOURCE[:, :, 0]))
    assert poisson("mix", "note.png", "destination.png", "-m", "mask.png", "-o", "colour.png").code == 0
    np.testing.assert_array_equal(load("colour.png"), editing.mix(DESTINATION, SOURCE[:, :, 0], MASK).image)
    ran = poisson("clone", "source.png", "grey.png", "-m", "mask.png", "--monochrome", "-o", "grey-out.png")
    assert ran.code == 0
    np.testing.assert_array_equal(
        load("grey-out.png"), editing.clone(GREY, SOURCE, MASK, monochrome=True).image
    )


def test_an_opaque_alpha_of_the_source_is_no_obstacle(folder, poisson):
    Path("opaque.png").write_bytes(encoded(np.dstack((SOURCE, np.full(SOURCE.shape[:2], 255, np.uint8)))))
    assert poisson("clone", "opaque.png", "destination.png", "-m", "mask.png", "-o", "out.png").code == 0
    np.testing.assert_array_equal(load("out.png"), editing.clone(DESTINATION, SOURCE, MASK).image)


def test_the_output_may_replace_an_input(folder, poisson):
    ran = poisson("fill", "destination.png", "-m", "dest-mask.png", "-o", "destination.png", "--overwrite")
    assert ran.code == 0
    np.testing.assert_array_equal(load("destination.png"), editing.fill(DESTINATION, DESTINATION_MASK).image)


def test_a_profile_that_the_format_cannot_hold_is_said_to_be_dropped(folder, poisson):
    Path("tagged.png").write_bytes(encoded(DESTINATION, icc_profile=b"a profile"))
    assert (
        "colour profile dropped" in poisson("fill", "tagged.png", "-m", "dest-mask.png", "-o", "out.bmp").err
    )
    assert "profile" not in poisson("fill", "tagged.png", "-m", "dest-mask.png", "-o", "out.png").err
