"""The gallery: that its command lines are real, its pictures are what they say, and its page stands alone."""

import contextlib
import doctest
import importlib
import importlib.util
import io
import json
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
from poisson_cli.demo import naive as ways
from poisson_cli.demo import photographs, sheet
from poisson_cli.demo.command import Command
from poisson_cli.demo.naive import Pasted
from poisson_cli.demo.paste import plain_paste
from poisson_cli.demo.scene import RESULT, SHEET
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
    destination = read(folder / command.pictures[-1]).pixels
    if "-m" not in command.words:
        return np.ones(destination.shape[:2], np.bool_)
    mask = read(folder / command.option("-m", "")).pixels > 0
    if len(command.pictures) == 1:
        return mask
    x, y = map(int, command.option("--at", "0,0").split(","))
    white = np.full(mask.shape, 255, np.uint8)
    mask_on = command.option("--mask-on", "source")
    if mask_on == "destination":
        white = np.full(read(folder / command.pictures[0]).shape, 255, np.uint8)
    black = np.zeros(destination.shape[:2], np.uint8)
    return plain_paste(black, white, mask, offset=(y, x), mask_on=mask_on) > 0


def starting_point(gallery, scene, command):
    """What a command's result is outside the selection, worked out from its words alone."""
    pixels = read(gallery.folder / scene.name / command.pictures[-1]).pixels
    if "--rect" in command.words:
        x, y, width, height = map(int, command.option("--rect", "").split(","))
        return pixels[y : y + height, x : x + width]
    if "--decolor-background" in command.words:
        luma = pixels @ np.array([0.2126, 0.7152, 0.0722])  # BT.709
        return np.repeat(np.rint(luma).astype(np.uint8)[..., None], 3, axis=2)
    return pixels


COMMANDS = [
    pytest.param(scene, command, id=f"{scene.name}:{command.option('-o', '')}")
    for scene in SCENES
    for command in scene.commands
]
PASTES = [
    pytest.param(scene, name, id=f"{scene.name}:{name}")
    for scene in SCENES
    for name, way in scene.naive.items()
    if isinstance(way, Pasted)
    and not way.feather
    and (way.change is None or scene.name.startswith("recolor"))
]
each_scene = pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)


# What is shown


def test_every_tool_is_shown():
    tools = {file.stem for file in Path(commands.__path__[0]).glob("[!_]*.py")} - {
        "batch",
        "demo",
        "mask",
        "warmup",
    }
    assert tools <= {command.words[0] for scene in SCENES for command in scene.commands}


def test_the_variants_of_cloning_are_shown():
    texts = " ".join(command.text for scene in SCENES for command in scene.commands)
    for option in (
        "--monochrome",
        "--gradients average",
        "--mask-on destination",
        "--at",
        "--flatten",
        "--focus",
    ):
        assert option in texts


def test_what_helps_against_bleeding_is_shown():
    texts = " ".join(command.text for scene in SCENES for command in scene.commands)
    for option in ("--screen", "--robust", "--rescale", "--space lab"):
        assert option in texts


def test_every_figure_of_the_paper_is_shown_in_its_order():
    figures = [int(scene.figure.split()[1]) for scene in SCENES if scene.figure.startswith("Figure")]
    assert set(figures) == set(range(2, 13))
    assert figures == sorted(figures)


@each_scene
def test_every_result_stands_beside_a_naive_one(scene):
    assert scene.naive
    assert set(scene.naive) <= {panel.picture for panel in scene.panels}


def test_names_are_unique():
    assert len({scene.name for scene in SCENES}) == len(SCENES)


@each_scene
def test_a_scene_hangs_together(scene):
    outputs = [output for command in scene.commands for output in command.outputs]
    assert scene.commands[-1].outputs[0] == RESULT
    assert len(set(outputs)) == len(outputs)
    made = {*scene.pictures, *scene.selections}
    for command in scene.commands:
        assert {word for word in command.words if word.endswith(".png")} - set(command.outputs) <= made
        assert "--overwrite" in command.words, "pasted, it would be refused"
        made.update(command.outputs)
    assert not made & set(scene.naive)
    made.update(scene.naive)
    assert {panel.picture for panel in scene.panels} <= made
    assert {panel.selection for panel in scene.panels} - {None} == set(scene.selections)
    assert RESULT in {panel.picture for panel in scene.panels}


@each_scene
def test_everyone_is_thanked(scene):
    assert {photograph.file for photograph in scene.pictures.values()} <= set(photographs.CREDITS)


# The pictures


@each_scene
def test_all_files_are_there(gallery, scene):
    files = {path.name for path in (gallery.folder / scene.name).iterdir()}
    outputs = {output for command in scene.commands for output in command.outputs}
    assert files == {*scene.pictures, *scene.selections, *outputs, *scene.naive, SHEET}


@each_scene
def test_selections_have_the_size_of_their_picture(gallery, scene):
    for name, drawn in scene.selections.items():
        mask = read(gallery.folder / scene.name / name)
        assert mask.shape == read(gallery.folder / scene.name / drawn.on).shape
        assert set(np.unique(mask.pixels)) == {0, 255}


@pytest.mark.parametrize(("scene", "command"), COMMANDS)
def test_a_command_changes_its_selection_and_nothing_else(gallery, scene, command):
    before = starting_point(gallery, scene, command)
    after = read(gallery.folder / scene.name / command.option("-o", "")).pixels
    inside = (
        np.ones(after.shape[:2], np.bool_)
        if "--rect" in command.words
        else selection(gallery, scene, command)
    )
    changed = (before != after).reshape(*inside.shape, -1).any(axis=2)
    assert not changed[~inside].any()
    assert changed[inside].mean() > 0.3


@pytest.mark.parametrize(("scene", "name"), PASTES)
def test_the_plain_paste_has_a_seam_and_the_result_has_none(gallery, scene, name):
    folder = gallery.folder / scene.name
    inside = selection(gallery, scene, scene.commands[-1])
    border = inside[:, 1:] != inside[:, :-1]

    def step(picture):
        return np.abs(np.diff(read(folder / picture).pixels.astype(float), axis=1))[border].mean()

    assert step(RESULT) < 0.75 * step(name)


def test_the_patch_that_is_pasted_is_the_one_that_was_found(gallery, capsys):
    scene = next(scene for scene in SCENES if scene.commands[-1].words[0] == "heal")
    (way,) = scene.naive.values()
    line = scene.commands[-1].argv(gallery.folder / scene.name)
    assert main.run([*line, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["offset"]
    assert way.at == (-found["x"], -found["y"])


def test_a_tile_repeats_without_the_steps_of_the_piece(gallery):
    scene = next(scene for scene in SCENES if scene.commands[-1].words[0] == "tile")
    result = read(gallery.folder / scene.name / RESULT).pixels.astype(float)
    piece = starting_point(gallery, scene, scene.commands[-1]).astype(float)
    for axis in (0, 1):
        step = [
            np.abs(np.take(pixels, 0, axis) - np.take(pixels, -1, axis)).mean() for pixels in (result, piece)
        ]
        assert step[0] == 0
        assert step[1] > 10


def test_screening_brings_the_colours_of_the_source_back(gallery):
    scene = next(scene for scene in SCENES if scene.name == "clone-screen")
    folder = gallery.folder / scene.name
    inside = selection(gallery, scene, scene.commands[-1])
    wanted = read(folder / "plain-paste.png").pixels.astype(float)
    cloned, screened = (
        np.abs(read(folder / name).pixels - wanted)[inside].mean() for name in ("clone.png", RESULT)
    )
    assert screened < 0.6 * cloned


def test_rescaling_brings_the_blacks_back(gallery):
    scene = next(scene for scene in SCENES if scene.name == "clone-rescale")
    folder = gallery.folder / scene.name
    inside = selection(gallery, scene, scene.commands[-1])
    clipped, fitted = (read(folder / name).pixels[inside].astype(float) for name in ("clone.png", RESULT))
    dark = fitted @ (0.2126, 0.7152, 0.0722) < 40
    red = [(pixels[:, 0] - pixels[:, 2])[dark].mean() for pixels in (clipped, fitted)]
    assert dark.sum() > 300 and red[1] < red[0] - 25


def test_a_robust_border_keeps_the_light_where_it_is(gallery):
    scene = next(scene for scene in SCENES if scene.name == "clone-robust")
    folder = gallery.folder / scene.name
    inside = selection(gallery, scene, scene.commands[-1])
    inside[:240] = False  # above, the border is plain
    glow = [(read(folder / name).pixels[inside] @ (1.0, 0.0, -1.0)).mean() for name in ("clone.png", RESULT)]
    assert glow[1] < glow[0] - 10  # less orange than blue, by levels


def test_the_page_is_small_enough_to_send(gallery):
    sizes = {name: len(data) for name, data in contents(gallery.folder).items()}
    assert sum(size for name, size in sizes.items() if name.endswith((".html", ".jpg"))) < 12_000_000
    assert sum(sizes.values()) < 40_000_000


def test_no_temporary_file_is_left(gallery):
    names = {path.name for path in gallery.folder.rglob("*") if path.is_file()}
    assert all(re.fullmatch(r"[a-z][a-z-]*\.(png|jpg|html)", name) for name in names)


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
        assert f"{scene.name}/{SHEET}" in page.links
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


@pytest.mark.parametrize("missing", ["skimage", "cv2"])
def test_without_an_extra_it_says_what_to_install(tmp_path, monkeypatch, capsys, missing):
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *a: None if name == missing else find_spec(name, *a)
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


def test_an_alpha_blend_goes_smoothly_from_one_picture_to_the_other():
    destination, source = np.full((40, 60), 20, np.uint8), np.full((40, 60), 220, np.uint8)
    mask = np.zeros((40, 60), np.bool_)
    mask[:, 30:] = True
    row = plain_paste(destination, source, mask, feather=4)[20].astype(int)
    assert row[0] == 20
    assert row[-1] == 220
    assert (np.diff(row) >= 0).all()
    assert np.diff(row).max() < 30  # the hard step has 200 levels
    assert row[29] + row[30] == pytest.approx(240, abs=4)


def grey_ramp():
    """(8, 8) uint8, 0 to 252."""
    return np.arange(0, 256, 4, dtype=np.uint8).reshape(8, 8)


def test_naive_changes_do_what_they_say():
    ramp = grey_ramp()
    colour = np.stack([ramp, ramp // 2, 255 - ramp], axis=2)
    assert (ways.Brightened(0.5)(ramp)[1:] > ramp[1:]).all()
    np.testing.assert_allclose(ways.Brightened(2)(ramp), ramp.astype(float) ** 2 / 255, atol=0.5)
    mean = ramp.mean()
    np.testing.assert_allclose(
        ways.Contrasted(1.5)(ramp), np.clip(mean + 1.5 * (ramp - mean), 0, 255), atol=0.5
    )
    assert np.ptp(ways.Grey()(colour).astype(int), axis=2).max() == 0
    red = np.full((2, 2, 3), (255, 0, 0), np.uint8)
    np.testing.assert_allclose(ways.Hue(120)(red), np.broadcast_to((0, 255, 0), red.shape), atol=8)
    np.testing.assert_allclose(ways.Hue(240)(red), np.broadcast_to((0, 0, 255), red.shape), atol=8)
    dot = np.zeros((15, 15), np.uint8)
    dot[7, 7] = 255
    assert 0 < ways.Blurred(2)(dot)[7, 7] < 30
    assert ways.Median(3)(dot).max() == 0


def naive(way, line, pictures, **masks):
    """A naive way to do a command, on arrays."""
    return way.draw(
        Command(line), pictures.__getitem__, {f"{name}.png": mask for name, mask in masks.items()}
    )


def test_a_naive_edit_changes_the_selection_alone():
    ramp = grey_ramp()
    mask = ramp > 100
    result = naive(Pasted(change=ways.Brightened(0.5)), "relight a.png -m m.png", {"a.png": ramp}, m=mask)
    np.testing.assert_array_equal(result, np.where(mask, ways.Brightened(0.5)(ramp), ramp))


def test_a_naive_copy_takes_its_place_from_the_command_or_from_the_scene():
    ramp, other = grey_ramp(), 255 - grey_ramp()
    pictures, mask = {"a.png": other, "b.png": ramp}, np.zeros((8, 8), np.bool_)
    mask[2:4, 2:4] = True
    result = naive(Pasted(), "clone a.png b.png -m m.png --at 3,1", pictures, m=mask)
    expected = ramp.copy()
    expected[3:5, 5:7] = other[2:4, 2:4]
    np.testing.assert_array_equal(result, expected)
    result = naive(Pasted(at=(-2, 1)), "heal b.png -m m.png", pictures, m=mask)
    expected = ramp.copy()
    expected[2:4, 2:4] = ramp[1:3, 4:6]
    np.testing.assert_array_equal(result, expected)


def test_a_backdrop_is_changed_outside_only():
    colour = np.stack([grey_ramp(), grey_ramp() // 2, grey_ramp() // 3], axis=2)
    mask = grey_ramp() > 100
    line = "recolor a.png -m m.png --decolor-background"
    result = naive(Pasted(backdrop=ways.Grey()), line, {"a.png": colour}, m=mask)
    np.testing.assert_array_equal(result[mask], colour[mask])
    np.testing.assert_array_equal(result[~mask], ways.Grey()(colour)[~mask])


@pytest.mark.parametrize("colour", [False, True], ids=["grey", "colour"])
def test_a_piece_is_repeated_as_it_is(colour):
    ramp = grey_ramp()
    picture = np.stack([ramp] * 3, axis=2) if colour else ramp
    result = naive(ways.Repeated(), "tile a.png --rect 2,1,4,3", {"a.png": picture})
    assert result.shape[:2] == (9, 12)
    for row in range(9):
        for col in range(12):
            np.testing.assert_array_equal(result[row, col], picture[1 + row % 3, 2 + col % 4])


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
