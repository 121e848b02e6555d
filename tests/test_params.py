"""Command-line values: X,Y becomes row, column, here and nowhere else."""

import inspect
from pathlib import Path

import click
import pytest

from poisson_cli import editing, params
from poisson_cli.editing.numbers import LARGEST_FACTOR
from poisson_cli.editing.solving import solve
from poisson_cli.errors import InputError
from poisson_cli.settings import (
    Combine,
    Edges,
    Ellipse,
    MaskFile,
    Placement,
    Polygon,
    Rectangle,
    Relight,
    Selection,
    Solver,
    Then,
)
from tests.small_pictures import DESTINATION, DESTINATION_MASK


@pytest.mark.parametrize(
    ("text", "row_col"),
    [
        ("40,-12", (-12, 40)),
        ("-5,3", (3, -5)),
        ("0,0", (0, 0)),
        ("+7,08", (8, 7)),
        (" 1 , 2 ", (2, 1)),
        ("999999999,-999999999", (-999999999, 999999999)),
    ],
)
def test_points(text, row_col):
    assert params.POINT.convert(text, None, None) == row_col


@pytest.mark.parametrize(
    "text",
    [
        "",
        ",",
        "1",
        "1,",
        ",1",
        "1,2,3",
        "1;2",
        "1.0,2",
        "1e3,2",
        "0x1,2",
        "one,two",
        "1_0,2",
        "١,2",
        "1234567890,1",
        "--1,2",
        "1 2,3",
    ],
)
def test_what_is_no_point(text):
    with pytest.raises(click.BadParameter, match="is not X,Y: whole numbers of pixels, for example 40,-12"):
        params.POINT.convert(text, None, None)


def test_rectangles():
    expected = Rectangle(row=-2, col=1, height=4, width=3)
    assert params.RECTANGLE.convert("1,-2,3,4", None, None) == expected
    assert params.RECTANGLE.convert(expected, None, None) is expected


def test_ellipses():
    expected = Ellipse(Rectangle(row=-2, col=1, height=4, width=3))
    assert params.ELLIPSE.convert("1,-2,3,4", None, None) == expected
    assert params.ELLIPSE.convert(expected, None, None) is expected


@pytest.mark.parametrize(("kind", "rule"), [(params.POLYGON, "even-odd"), (params.LASSO, "nonzero")])
def test_polygons(kind, rule):
    expected = Polygon(((2.0, 1.0), (-4.5, 3.0), (0.5, 1e3)), rule)
    for text in ("1,2 3,-4.5 1e3,.5", " 1 , 2\t3,-4.5\n1e3 ,.5 "):
        assert kind.convert(text, None, None) == expected
    assert kind.convert(expected, None, None) is expected


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "a polygon needs at least 3 points X,Y, not 0"),
        ("1,2 3,4", "at least 3 points X,Y, not 2"),
        ("1,2 3,4 5", "'5' is not a point X,Y, for example 12,34.5"),
        ("1,2,3 4,5 6,7", "'1,2,3' is not a point"),
        ("1,2 3,4 nan,1", "'nan,1' is not a point"),
        ("1,2 3,4 inf,1", "'inf,1' is not a point"),
        ("1,2 3,4 1_0,1", "'1_0,1' is not a point"),
        ("1,2 3,4 ١,1", "'١,1' is not a point"),
        ("1,2 3,4 1e999,1", "the point 1e999,1 is farther away than 1,000,000,000 pixels"),
        ("1,2 3,4 -1,1000000001", "the point -1,1000000001 is farther away"),
    ],
)
def test_what_is_no_polygon(text, complaint):
    with pytest.raises(click.BadParameter) as caught:
        params.POLYGON.convert(text, None, None)
    assert complaint in caught.value.message


def test_masks_are_kept_as_they_are_typed():
    assert params.MASK.convert("./a b.json:road//x/", None, None) == MaskFile("./a b.json:road//x/")
    with pytest.raises(click.BadParameter, match="null character"):
        params.MASK.convert("a\0b", None, None)


@pytest.mark.parametrize("text", ["1,2,0,4", "1,2,3,0", "1,2,-3,4"])
def test_rectangles_without_area(text):
    with pytest.raises(click.BadParameter, match="W and H must be at least 1"):
        params.RECTANGLE.convert(text, None, None)


@pytest.mark.parametrize("words", [["--at", "-5,3"], ["--at=-5,3"]])
def test_negative_numbers_are_no_options(words):
    seen = []
    at = click.Option(["--at"], type=params.POINT)
    click.Command("c", params=[at], callback=lambda at: seen.append(at)).main(words, standalone_mode=False)
    assert seen == [(3, -5)]


@pytest.mark.parametrize(("text", "number"), [("1e-3", 1e-3), ("5", 5.0), ("0.0001", 1e-4)])
def test_positive_numbers(text, number):
    assert params.POSITIVE.convert(text, None, None) == number


@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "0", "-0.0", "-1", "", "tiny", "1e999"])
def test_what_is_no_positive_number(text):
    with pytest.raises(click.BadParameter, match="is not a number greater than 0"):
        params.POSITIVE.convert(text, None, None)


@pytest.mark.parametrize(("text", "number"), [("-30", -30.0), ("0", 0.0), ("1e2", 100.0)])
def test_numbers(text, number):
    assert params.NUMBER.convert(text, None, None) == number


@pytest.mark.parametrize("text", ["nan", "inf", "-inf", "", "warm", "1,5"])
def test_what_is_no_number(text):
    with pytest.raises(click.BadParameter, match=f"'{text}' is not a number$"):
        params.NUMBER.convert(text, None, None)


@pytest.mark.parametrize(("text", "number"), [("0", 0.0), ("1.5", 1.5)])
def test_numbers_that_are_not_negative(text, number):
    assert params.NOT_NEGATIVE.convert(text, None, None) == number


@pytest.mark.parametrize("text", ["nan", "inf", "-0.1", ""])
def test_what_is_negative_or_no_number(text):
    with pytest.raises(click.BadParameter, match="is not a number, 0 or greater"):
        params.NOT_NEGATIVE.convert(text, None, None)


def test_factors():
    assert params.FACTORS.convert("1.5,.5, 0", None, None) == (1.5, 0.5, 0.0)
    assert params.FACTORS.convert((1.0, 2.0, 3.0), None, None) == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("text", ["", "1", "1,2", "1,2,3,4", "1,-1,1", "1,nan,1", "red,1,1", "1;1;1"])
def test_what_are_no_factors(text):
    with pytest.raises(click.BadParameter, match="is not R,G,B: three numbers from 0 to 1000"):
        params.FACTORS.convert(text, None, None)


@pytest.mark.parametrize(("text", "number"), [("1", 1), ("255", 255), ("+12", 12)])
def test_whole_numbers(text, number):
    assert params.EIGHT_BIT.convert(text, None, None) == number


@pytest.mark.parametrize("text", ["0", "256", "-1", "1.5", "", "x"])
def test_what_is_out_of_range(text):
    with pytest.raises(click.BadParameter, match="is not a whole number from 1 to 255"):
        params.EIGHT_BIT.convert(text, None, None)


def default(function, name: str) -> object:
    return inspect.signature(function).parameters[name].default


def test_settings_have_the_defaults_of_the_functions():
    """What is not said on the command line means what it means when it is not said in Python."""
    solver = Solver()
    for name in ("solver", "cycle", "tolerance", "max_iterations", "threads"):
        assert getattr(solver, name) == default(solve, name), name
    for tool in (editing.clone, editing.mix):
        assert Placement().offset == default(tool, "offset")
        assert Placement().mask_on == default(tool, "mask_on")

    for name in ("low", "high", "sigma"):
        assert getattr(Edges(), name) == default(editing.find_edges, name) == default(editing.flatten, name)
    assert Relight() == Relight(default(editing.relight, "alpha"), default(editing.relight, "beta"))
    assert Relight() == Relight(editing.Attenuate().alpha, editing.Attenuate().beta)


def then(*words: str) -> Then:
    """What ``clone`` makes of its options for imported gradients."""
    from poisson_cli import options

    seen = []
    command = click.Command("c", callback=options.then(lambda then: seen.append(then)), params=[])
    command.params = list(reversed(command.callback.__click_params__))
    command.main(list(words), standalone_mode=False)
    return seen[0]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], Then()),
        (["--flatten"], Then(flatten=Edges())),
        (["--focus", "0"], Then(focus=0.0)),
        (["--relight", "--beta=-.1"], Then(relight=Relight(beta=-0.1))),
        (
            ["--relight", "--flatten", "--edges", "e.png", "--show-edges", "s.png", "--focus", "2"],
            Then(Edges(file=Path("e.png"), show=Path("s.png")), 2.0, Relight()),
        ),
    ],
    ids=str,
)
def test_what_is_done_to_imported_gradients(words, expected):
    assert then(*words) == expected


def test_options_have_the_defaults_of_the_settings():
    from poisson_cli.commands.clone import command

    words = "a.png b.png -m m.png -o o.png".split()
    given = command.make_context("clone", words).params
    solver = Solver(
        **{name: given[name] for name in ("solver", "cycle", "tolerance", "max_iterations", "threads")}
    )
    assert solver == Solver()
    assert Placement(given["at"], given["mask_on"]) == Placement()
    steps = tuple(map(Combine, given["mask"]))
    assert Selection(steps, given["invert"], given["threshold"]) == Selection((Combine(MaskFile("m.png")),))
    assert given["gradients"] == default(editing.clone, "gradients")
    assert given["monochrome"] == default(editing.clone, "monochrome")


RANGES = [  # of an option, its function's keyword, and the last number on either side that is allowed
    ("relight", "--alpha", "alpha", (1e-9, 1000)),
    ("relight", "--beta", "beta", (-1, 1)),
    ("focus", "--amount", "amount", (0, 1000)),
    ("recolor", "--saturation", "saturation", (0, 1000)),
    ("tonemap", "--alpha", "alpha", (1e-9, 1000)),
    ("tonemap", "--beta", "beta", (0, 1)),
    ("tonemap", "--saturation", "saturation", (0, 10)),
    ("tonemap", "--black", "black", (0, 99.4)),
    ("tonemap", "--white", "white", (1, 100)),
    ("tonemap", "--floor", "floor", (1e-9, 1000)),
    ("tonemap", "--gamma", "gamma", (0.5, 10)),
]


@pytest.mark.parametrize(("tool", "option", "keyword", "bounds"), RANGES)
def test_an_option_and_its_keyword_have_one_range(folder, poisson, tool, option, keyword, bounds):
    """The options are checked before anything is read, and so know the range a second time."""
    masks = [] if tool == "tonemap" else [DESTINATION_MASK]
    words = [tool, "destination.png", *([] if tool == "tonemap" else ["-m", "dest-mask.png"])]
    words += ["--overwrite", "-o", "out.png"]
    for number in bounds:
        assert poisson(*words, f"{option}={number}").code in (0, 5)
    for number in (bounds[0] - 1, bounds[1] + 1):
        ran = poisson(*words, f"{option}={number}")
        assert ran.code == 2 and "is not a number" in ran.err
        with pytest.raises(InputError, match=f"{keyword} is"):
            getattr(editing, tool)(DESTINATION, *masks, **{keyword: number})


def test_factors_have_one_range():
    assert params.LARGEST_FACTOR == LARGEST_FACTOR
