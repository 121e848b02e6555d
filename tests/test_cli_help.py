"""What `--help` shows works: its examples are run, its defaults are those of the functions."""

import inspect
import json
import re
import shlex
from pathlib import Path

import click
import numpy as np
import pytest

from poisson_cli import editing
from poisson_cli.main import cli
from poisson_cli.settings import MaskFile
from tests.small_pictures import blob, encoded, load, smooth

CONTEXT = click.Context(cli, info_name="poisson")
COMMANDS = {name: cli.get_command(CONTEXT, name) for name in cli.list_commands(CONTEXT)}
TOOLS = {name: command for name, command in COMMANDS.items() if hasattr(editing, name)}
EDITORS = {**TOOLS, "mask": COMMANDS["mask"]}
"""Those that work on pictures."""

OTHERS = {"batch", "demo", "warmup"}

IMAGE, SOURCE = (480, 640), (300, 400)
"""(H, W) of the pictures that the examples name: they say where things lie in them."""


def examples(command: click.Command) -> list[list[str]]:
    """The words after ``poisson`` of every command line in a help text."""
    text = inspect.cleandoc(command.help or "").partition("\b")[2].replace("\\\n", " ")
    return [shlex.split(line)[1:] for line in text.splitlines() if line.startswith("  poisson ")]


EXAMPLES = [
    pytest.param(words, id=" ".join(words))
    for command in (cli, *EDITORS.values())
    for words in examples(command)
]


def test_every_tool_has_an_example_and_its_function():
    assert set(COMMANDS) == {*EDITORS, *OTHERS}
    assert all(any(words[0] == name for words in examples(command)) for name, command in EDITORS.items())


def named(words: list[str], *parameters: str) -> list[Path]:
    """The files that some parameters name."""
    with EDITORS[words[0]].make_context(words[0], words[1:]) as context:
        given = [context.params.get(parameter) for parameter in parameters]
    return [
        Path(one.name.partition(":")[0]) if isinstance(one, MaskFile) else one
        for value in given
        if value is not None
        for one in (value if isinstance(value, tuple) else (value,))
    ]


def save(path: Path, pixels: np.ndarray) -> None:
    """A picture, or where it is not dark as an annotation with a label after the file."""
    if path.suffix == ".json":
        row, col = np.nonzero(pixels)
        corners = [[int(col.min()), int(row.min())], [int(col.max()), int(row.max())]]
        shape = {"label": path.stem, "shape_type": "rectangle", "points": corners}
        height, width = pixels.shape
        path.write_text(json.dumps({"shapes": [shape], "imageHeight": height, "imageWidth": width}))
    else:
        path.write_bytes(encoded(pixels, "JPEG" if path.suffix == ".jpg" else "PNG"))


@pytest.mark.parametrize("words", EXAMPLES)
def test_examples_run(tmp_path, monkeypatch, poisson, words):
    monkeypatch.chdir(tmp_path)
    for path in named(words, "image", "images", "destination"):
        save(path, smooth(*IMAGE, 3))
    sources = named(words, "source")
    for path in sources:
        save(path, smooth(*SOURCE, 3))
    for path in named(words, "mask", "file"):
        mask = np.zeros(SOURCE if sources else IMAGE, np.uint8)
        mask[180:220, 130:190] = blob(40, 60) * np.uint8(255)
        save(path, mask)
    given = named(words, "image", "images", "destination")
    outputs = named(words, "path", "paths")
    if len(given) > len(outputs):  # into a folder
        outputs[0].mkdir()
        outputs = [outputs[0] / path.name for path in given]
    outputs += named(words, "show", "previews")

    ran = poisson(*words)

    assert ran.code == 0, ran.err
    assert outputs
    for path in outputs:
        assert load(path).size


@pytest.mark.parametrize("name", TOOLS)
def test_options_have_the_defaults_of_the_keywords(name):
    """Those that are handed over as they are; `test_params` looks at the others."""
    keywords = inspect.signature(getattr(editing, name)).parameters
    arguments = [argument.name for argument in TOOLS[name].params if isinstance(argument, click.Argument)]
    required = ["--amount", "1"] if name == "focus" else []
    with TOOLS[name].make_context(name, [*arguments, "-o", "out.png", *required]) as context:
        given = {option: value for option, value in context.params.items() if option not in arguments}
    shared = given.keys() & keywords.keys() - {"amount", "mask"}
    assert len(shared) >= (name != "fill") + 1
    for option in shared:
        assert given[option] == keywords[option].default, option


@pytest.mark.parametrize("name", TOOLS)
def test_every_keyword_of_a_tool_can_be_said_on_the_command_line(name):
    elsewhere = {"destination", "source", "image", "mask", "options"}
    written_otherwise = {"edges": "file", "offset": "at", "then": "flatten"}
    names = {parameter.name for parameter in TOOLS[name].params}
    for keyword in inspect.signature(getattr(editing, name)).parameters.keys() - elsewhere:
        assert keyword in names or written_otherwise[keyword] in names, keyword


@pytest.mark.parametrize("name", COMMANDS)
def test_help_is_made_of_sentences(name):
    for parameter in COMMANDS[name].params:
        if isinstance(parameter, click.Option):
            assert re.fullmatch(r"[A-Z].*\.", parameter.help or "", re.DOTALL), parameter.name


@pytest.mark.parametrize(
    ("name", "warning"),
    [
        ("focus", "It does not blur"),
        ("focus", "no depth of field"),
        ("heal", "Leave a margin of a few pixels around what is to go"),
        ("recolor", "to make it blue, use --hue"),
        ("recolor", "--screen .0005 keeps them"),
        ("recolor", "where it crosses strong colours"),
    ],
)
def test_help_says_what_to_beware_of(poisson, name, warning):
    assert warning in " ".join(poisson(name, "--help").out.split())
