"""The gallery: that its command lines are real, its pictures are what they say, and its page stands alone."""

import contextlib
import doctest
import importlib
import importlib.util
import io
import os
import re
import shlex
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import poisson_cli
from poisson_cli import commands, demo, main
from poisson_cli.demo import photographs, scenes, sheet
from poisson_cli.demo.command import Command
from poisson_cli.demo.paste import plain_paste
from poisson_cli.demo.scenes import SCENES
from poisson_cli.demo.shapes import Brush, Lasso, draw_mask
from poisson_cli.errors import InputError, NotConverged, OutputError, PoissonError
from poisson_cli.images import read

NAME = "a friend's gallery"  # a space and a quote, to be minded by whoever writes command lines


@pytest.fixture(scope="module")
def gallery(tmp_path_factory):
    """A finished gallery, made from the folder that it lies in; not to be changed."""
    start = tmp_path_factory.mktemp("start")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(start)
        with contextlib.redirect_stdout(io.StringIO()) as said:
            assert main.run(["demo", NAME]) == 0
    texts = map(str.strip, said.getvalue().splitlines())
    return SimpleNamespace(
        start=start, folder=start / NAME, lines=[text for text in texts if text.startswith("poisson ")]
    )


def contents(folder):
    """The bytes of every file, by its path within the folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def selection(gallery, scene, command):
    """What a command may change: (H, W) bool of its destination, worked out from its words alone."""
    folder = gallery.folder / scene.name
    mask = read(folder / command.option("-m", "")).pixels > 0
    destination = read(folder / command.pictures[-1]).pixels
    if len(command.pictures) == 1:
        return mask
    x, y = map(int, command.option("--at", "0,0").split(","))
    white = np.full(mask.shape, 255, np.uint8)
    mask_on = command.option("--mask-on", "source")
    if mask_on == "destination":
        white = np.full(read(folder / command.pictures[0]).shape, 255, np.uint8)
    black = np.zeros(destination.shape[:2], np.uint8)
    return plain_paste(black, white, mask, offset=(y, x), mask_on=mask_on) > 0


COMMANDS = [
    pytest.param(scene, command, id=f"{scene.name}:{command.option('-o', '')}")
    for scene in SCENES
    for command in scene.commands
]
each_scene = pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)


# What is shown


def test_every_tool_is_shown():
    tools = {file.stem for file in Path(commands.__path__[0]).glob("[!_]*.py")} - {"demo", "mask", "warmup"}
    assert tools <= {command.words[0] for scene in SCENES for command in scene.commands}


def test_the_variants_of_cloning_are_shown():
    texts = " ".join(command.text for scene in SCENES for command in scene.commands)
    for option in ("--monochrome", "--gradients average", "--mask-on destination", "--at"):
        assert option in texts


def test_names_are_unique():
    assert len({scene.name for scene in SCENES}) == len(SCENES)


@each_scene
def test_a_scene_hangs_together(scene):
    outputs = [command.option("-o", "") for command in scene.commands]
    assert outputs[-1] == scenes.RESULT
    assert len(set(outputs)) == len(outputs)
    made = {*scene.pictures, *scene.selections}
    for command in scene.commands:
        assert {word for word in command.words if word.endswith(".png")} - {command.option("-o", "")} <= made
        assert "--overwrite" in command.words, "pasted, it would be refused"
        made.add(command.option("-o", ""))
    if scene.has_paste:
        made.add(scenes.PASTE)
    assert {panel.picture for panel in scene.panels} <= made
    assert {panel.selection for panel in scene.panels} - {None} == set(scene.selections)
    assert scenes.RESULT in {panel.picture for panel in scene.panels}
    assert scene.has_paste == (scenes.PASTE in {panel.picture for panel in scene.panels})


@each_scene
def test_everyone_is_thanked(scene):
    assert {photograph.file for photograph in scene.pictures.values()} <= set(photographs.CREDITS)


# The pictures


@each_scene
def test_all_files_are_there(gallery, scene):
    files = {path.name for path in (gallery.folder / scene.name).iterdir()}
    outputs = {command.option("-o", "") for command in scene.commands}
    paste = {scenes.PASTE} if scene.has_paste else set()
    assert files == {*scene.pictures, *scene.selections, *outputs, *paste, scenes.SHEET}


@each_scene
def test_selections_have_the_size_of_their_picture(gallery, scene):
    for name, drawn in scene.selections.items():
        mask = read(gallery.folder / scene.name / name)
        assert mask.shape == read(gallery.folder / scene.name / drawn.on).shape
        assert set(np.unique(mask.pixels)) == {0, 255}


@pytest.mark.parametrize(("scene", "command"), COMMANDS)
def test_a_command_changes_its_selection_and_nothing_else(gallery, scene, command):
    folder = gallery.folder / scene.name
    before = read(folder / command.pictures[-1]).pixels
    after = read(folder / command.option("-o", "")).pixels
    inside = selection(gallery, scene, command)
    changed = (before != after).reshape(*inside.shape, -1).any(axis=2)
    assert not changed[~inside].any()
    assert changed[inside].mean() > 0.3


@pytest.mark.parametrize(
    "scene", [scene for scene in SCENES if scene.has_paste], ids=lambda scene: scene.name
)
def test_the_plain_paste_has_a_seam_and_the_result_has_none(gallery, scene):
    folder = gallery.folder / scene.name
    inside = selection(gallery, scene, scene.commands[-1])
    border = inside[:, 1:] != inside[:, :-1]

    def step(name):
        return np.abs(np.diff(read(folder / name).pixels.astype(float), axis=1))[border].mean()

    assert step(scenes.RESULT) < 0.75 * step(scenes.PASTE)


def test_the_gallery_is_small_enough_to_send(gallery):
    assert sum(map(len, contents(gallery.folder).values())) < 15_000_000


def test_no_temporary_file_is_left(gallery):
    names = {path.name for path in gallery.folder.rglob("*") if path.is_file()}
    assert all(re.fullmatch(r"[a-z][a-z-]*\.(png|html)", name) for name in names)


# The command lines


def test_all_lines_are_printed_in_order(gallery):
    expected = [command.line(Path(NAME, scene.name)) for scene in SCENES for command in scene.commands]
    assert gallery.lines == expected


def test_each_line_makes_the_same_file_again(gallery, monkeypatch):
    monkeypatch.chdir(gallery.start)
    for line in gallery.lines:
        words = shlex.split(line)
        output = Path(words[words.index("-o") + 1])
        made = output.read_bytes()
        output.unlink()
        assert words[0] == "poisson"
        assert main.run(words[1:]) == 0
        assert output.read_bytes() == made, line


def test_a_line_pasted_into_a_shell_makes_the_same_file(gallery):
    line = gallery.lines[-1]
    words = shlex.split(line)
    output = gallery.start / words[words.index("-o") + 1]
    made = output.read_bytes()
    output.unlink()
    home = str(Path(poisson_cli.__file__).parents[1])
    shell = f'poisson() {{ {shlex.quote(sys.executable)} -m poisson_cli "$@"; }}\n{line}\n'
    done = subprocess.run(
        ["sh", "-c", shell],
        cwd=gallery.start,
        env={**os.environ, "PYTHONPATH": home},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert output.read_bytes() == made


# The page


class Page(HTMLParser):
    """Links, anchors and text of a page; raises where the tags do not match."""

    VOID = frozenset({"meta", "img", "br", "link", "input"})

    def __init__(self, text):
        super().__init__()
        self.links, self.ids, self.open, self.code = [], set(), [], ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.links += [values[key] for key in ("href", "src") if key in values]
        self.ids |= {values["id"]} if "id" in values else set()
        if tag == "img":
            assert values["alt"]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "code" in self.open:
            self.code += data + "\n"


def test_the_page_stands_alone(gallery):
    text = (gallery.folder / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    assert "@import" not in text
    assert "url(" not in text
    for link in page.links:
        if link.startswith("#"):
            assert link[1:] in page.ids
        else:
            assert (gallery.folder / link).is_file(), link


def test_the_page_shows_every_scene_and_line(gallery):
    text = (gallery.folder / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    assert page.code.split("\n")[:-1] == gallery.lines
    for scene in SCENES:
        assert f"{scene.name}/{scenes.SHEET}" in page.links
        assert scene.figure in text


# Again, and when it cannot be done


def test_a_second_run_needs_leave_and_makes_the_same_bytes(gallery, monkeypatch, capsys):
    monkeypatch.chdir(gallery.start)
    before = contents(gallery.folder)
    assert main.run(["demo", NAME]) == 4
    assert "--overwrite" in capsys.readouterr().err
    assert contents(gallery.folder) == before
    own = gallery.folder / "mine.txt"
    own.write_text("keep")
    try:
        assert main.run(["demo", NAME, "--overwrite"]) == 0
        assert own.read_text() == "keep"
    finally:
        own.unlink()
    assert contents(gallery.folder) == before


def test_without_scikit_image_it_says_what_to_install(tmp_path, monkeypatch, capsys):
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *a: None if name == "skimage" else find_spec(name, *a)
    )
    assert main.run(["demo", str(tmp_path / "gallery")]) == 3
    assert "pip install 'poisson-cli[demo]'" in capsys.readouterr().err
    assert not (tmp_path / "gallery").exists()


def test_scikit_image_itself_is_not_imported(tmp_path):
    script = "import sys, poisson_cli.demo; sys.exit('skimage' in sys.modules)"
    home = str(Path(poisson_cli.__file__).parents[1])
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env={**os.environ, "PYTHONPATH": home}, check=False
    )
    assert done.returncode == 0


@pytest.mark.parametrize("inside", [False, True], ids=["a file", "in a file"])
def test_a_file_in_the_way_is_left_alone(tmp_path, capsys, inside):
    file = tmp_path / "gallery"
    file.write_text("keep")
    assert main.run(["demo", str(file / "deeper" if inside else file), "--overwrite"]) == 4
    assert str(file) in capsys.readouterr().err
    assert file.read_text() == "keep"


def test_folders_on_the_way_are_made(tmp_path, monkeypatch):
    monkeypatch.setattr(demo, "SCENES", ())
    assert main.run(["demo", str(tmp_path / "a" / "b")]) == 0
    assert (tmp_path / "a" / "b" / "index.html").is_file()


@pytest.mark.parametrize(
    ("code", "kind"),
    [(3, InputError), (4, OutputError), (5, NotConverged), (1, PoissonError), (2, PoissonError)],
)
def test_a_command_that_fails_stops_the_demo(tmp_path, monkeypatch, code, kind):
    monkeypatch.setattr(main, "run", lambda _argv: code)
    with pytest.raises(PoissonError) as raised:
        demo.run(tmp_path / "gallery", False)
    assert type(raised.value) is kind
    assert SCENES[0].commands[0].line(tmp_path / "gallery" / SCENES[0].name) in str(raised.value)
    assert not (tmp_path / "gallery" / "index.html").exists()


def test_a_closed_pipe_is_not_an_unwritable_folder(tmp_path, monkeypatch):
    def closed(*_args, **_keywords):
        raise BrokenPipeError

    monkeypatch.setattr(demo, "print", closed, raising=False)
    with pytest.raises(BrokenPipeError):
        demo.run(tmp_path / "gallery", False)


# The parts


@pytest.mark.parametrize("module", ["command", "paste", "shapes"])
def test_examples_in_docstrings(module):
    tried = doctest.testmod(importlib.import_module(f"poisson_cli.demo.{module}"))
    assert tried.attempted > 0
    assert tried.failed == 0


@pytest.mark.parametrize("mask_on", ["source", "destination"])
@pytest.mark.parametrize(
    "offset", [(0, 0), (2, 3), (-2, 1), (1, -3), (4, 6), (-4, -5), (9, 0), (0, -9), (-9, 9)]
)
@pytest.mark.parametrize("colour", [False, True], ids=["grey", "colour"])
def test_plain_paste_copies_selected_pixels(mask_on, offset, colour):
    rng = np.random.default_rng(7)
    destination = rng.integers(0, 256, (6, 8, 3) if colour else (6, 8), np.uint8)
    source = rng.integers(0, 256, (5, 7), np.uint8)
    mask = rng.random(source.shape if mask_on == "source" else destination.shape[:2]) < 0.5
    expected = destination.copy()
    for row in range(6):
        for col in range(8):
            y, x = row - offset[0], col - offset[1]
            if 0 <= y < 5 and 0 <= x < 7 and (mask[y, x] if mask_on == "source" else mask[row, col]):
                expected[row, col] = source[y, x]
    kept = destination.copy()
    result = plain_paste(destination, source, mask, offset=offset, mask_on=mask_on)
    np.testing.assert_array_equal(result, expected)
    np.testing.assert_array_equal(destination, kept)


def test_a_lasso_runs_through_its_points_and_selects_its_inside():
    points = ((10, 4), (30, 6), (34, 20), (20, 28), (6, 18))
    mask = draw_mask([Lasso(points)], 32, 40)
    for x, y in points:
        assert mask[y - 1 : y + 2, x - 1 : x + 2].any()
        assert not mask[y - 1 : y + 2, x - 1 : x + 2].all()
    assert mask[16, 20]
    assert not mask[0].any()
    assert not mask[:, -1].any()


def test_a_selection_is_a_union():
    left, right = Brush(((2, 2), (2, 8)), 3), Brush(((9, 2), (9, 8)), 3)
    both = draw_mask([left, right], 12, 12)
    np.testing.assert_array_equal(both, draw_mask([left], 12, 12) | draw_mask([right], 12, 12))
    assert both.sum() > draw_mask([left], 12, 12).sum()


@pytest.mark.parametrize(
    "how",
    [
        {"crop": (10, 20, 110, 80)},
        {"size": (64, 48)},
        {"crop": (10, 20, 110, 80), "size": (50, 30), "quarter_turns": 1, "mirrored": True, "margin": 5},
    ],
    ids=["crop", "size", "all"],
)
def test_a_photograph_is_cropped_scaled_and_turned(how):
    pixels = photographs.load(photographs.Photograph("coffee.png", **how), photographs.folder())
    whole = photographs.load(photographs.Photograph("coffee.png"), photographs.folder())
    if "size" not in how:
        np.testing.assert_array_equal(pixels, whole[20:80, 10:110])
    elif "crop" not in how:
        assert pixels.shape == (48, 64, 3)
    else:
        assert pixels.shape == (60, 40, 3)
        assert (pixels[:5] == 255).all()
        assert (pixels[:, -5:] == 255).all()


def test_levels_can_make_a_negative():
    files = photographs.folder()
    grey = photographs.load(photographs.Photograph("brick.png"), files)
    negative = photographs.load(photographs.Photograph("brick.png", levels=(255, 0)), files)
    np.testing.assert_array_equal(negative, 255 - grey)
    stretched = photographs.load(photographs.Photograph("brick.png", levels=(90, 150)), files)
    assert (stretched[grey <= 90] == 0).all()
    assert (stretched[grey >= 150] == 255).all()


def test_a_coat_gives_a_grey_photograph_colour():
    coat = photographs.Coat((255, 0, 100), 0.5)
    files = photographs.folder()
    grey = photographs.load(photographs.Photograph("brick.png"), files).astype(float)
    painted = photographs.load(photographs.Photograph("brick.png", coat=coat), files)
    for channel, paint in enumerate(coat.colour):
        np.testing.assert_allclose(painted[..., channel], (grey + paint) / 2, atol=0.5)


def test_creases_stay_within_the_brush_that_mends_them():
    scene = next(scene for scene in SCENES if scene.name == "fill-creases")
    (photograph,), (drawn,) = scene.pictures.values(), scene.selections.values()
    files = photographs.folder()
    whole = photographs.load(photographs.Photograph(photograph.file), files)
    folded = photographs.load(photograph, files)
    mask = draw_mask(drawn.shapes, *whole.shape[:2])
    damaged = (whole != folded).any(axis=2)
    assert damaged.sum() > 1000
    assert not damaged[~mask].any()
    # Not even beside the selection: the border that the membrane meets is undamaged by two pixels at least.
    near = np.lib.stride_tricks.sliding_window_view(np.pad(damaged, 1), (3, 3)).any(axis=(2, 3))
    assert not near[~mask].any()


def test_a_line_hides_nothing_that_is_selected():
    grey = np.full((120, 160, 3), 200, np.uint8)
    mask = np.zeros((120, 160), np.bool_)
    mask[40:80, 50:110] = True
    drawn = sheet.draw_sheet("t", "s", [sheet.Cell("l", "n", grey, mask)], columns=1)
    place = np.asarray(drawn)[
        80 : 80 + 852, 32 : 32 + 1136
    ]  # margins and header of the sheet; 1136 = 7.1 * 160
    assert (place[300:550, 375:760] == 200).all()
    assert (place[5:200, 5:200] == 110).all()
    yellow = (place[..., 0] > 200) & (place[..., 2] < 60)
    rows, cols = np.nonzero(yellow)
    assert abs(rows.min() - 40 * 7.1) < 8
    assert abs(rows.max() - 80 * 7.1) < 8
    assert abs(cols.min() - 50 * 7.1) < 8
    assert abs(cols.max() - 110 * 7.1) < 8


def test_a_sheet_has_a_place_for_every_panel():
    red, blue = np.zeros((30, 40, 3), np.uint8), np.zeros((30, 40, 3), np.uint8)
    red[..., 0], blue[..., 2] = 200, 200
    cells = [sheet.Cell("a", "", red), sheet.Cell("b", "", red), sheet.Cell("c", "", blue, result=True)]
    drawn = sheet.draw_sheet("title", "source", cells, columns=2)
    assert drawn.shape[1] == 1200
    assert drawn.dtype == np.uint8
    rows, cols = np.nonzero((drawn == (0, 0, 200)).all(axis=2))
    assert cols.max() < 600 < np.nonzero((drawn == (200, 0, 0)).all(axis=2))[1].max()
    assert rows.min() > np.nonzero((drawn == (200, 0, 0)).all(axis=2))[0].max()


def test_an_option_without_a_word_has_its_default():
    command = Command("fill a.png -m b.png -o c.png")
    assert command.option("--at", "0,0") == "0,0"
    assert command.pictures == ["a.png"]
    assert command.argv(Path("x")) == [
        "fill",
        str(Path("x/a.png")),
        "-m",
        str(Path("x/b.png")),
        "-o",
        str(Path("x/c.png")),
    ]
