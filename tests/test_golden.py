"""Every golden case, and the harness that keeps them: see `tests.golden`."""

import numpy as np
import pytest

import poisson_cli
from tests.golden import Stored, all_cases
from tests.golden.__main__ import main
from tests.golden.case import ORACLES, read_png, write_png
from tests.oracles_spaces import SPACES
from tests.photographs import crop
from tests.regions import lasso

every_case = pytest.mark.parametrize("folder", all_cases(), ids=lambda folder: folder.name)


@every_case
def test_golden(folder, tmp_path):
    stored = Stored.load(folder)
    case = stored.case
    stored.check(case.given_to(getattr(poisson_cli, case.tool)), tmp_path)


@every_case
def test_the_expected_picture_is_the_oracles(folder, tmp_path):
    """Nobody mended a failure by storing what our code gave."""
    stored = Stored.load(folder)
    stored.check(stored.case.expected, tmp_path)
    np.testing.assert_array_equal(stored.near_ties, stored.case.near_ties())


@every_case
def test_a_case_is_small(folder):
    assert sum(path.stat().st_size for path in folder.iterdir()) < 40_000


def test_every_tool_has_a_case_in_every_space():
    cases = {
        (case.tool, case.arguments.get("space", "rgb"))
        for case in (Stored.load(folder).case for folder in all_cases())
    }
    assert cases == {(tool, space) for tool in ORACLES for space in SPACES}


# --- the harness ------------------------------------------------------------------------------------


@pytest.fixture
def inputs(tmp_path):
    """Three files as a user of `add` has them."""
    write_png(tmp_path / "d.png", crop("coffee.png", 30, 40, top=150))
    write_png(tmp_path / "s.png", crop("astronaut.png", 30, 40))
    write_png(tmp_path / "m.png", lasso(30, 40).astype(np.uint8) * 255)
    return tmp_path


def add(folder, *arguments):
    files = [f"--{name}={folder / name[0]}.png" for name in ("destination", "source", "mask")]
    main([f"--cases={folder / 'cases'}", "add", "new", *arguments, *files])
    return folder / "cases" / "new"


def test_a_case_that_was_added_passes(inputs):
    stored = Stored.load(add(inputs, "clone", "--offset", "4", "-6", "--gradients", "average"))
    assert stored.case.arguments == {"offset": (4, -6), "gradients": "average"}
    edited = poisson_cli.clone(*stored.case.pictures, stored.case.mask, offset=(4, -6), gradients="average")
    stored.check(edited, inputs)


def test_a_case_with_edges_a_space_and_other_arguments(inputs):
    write_png(inputs / "e.png", np.eye(30, 40, dtype=np.uint8) * 255)
    files = [f"--{name}={inputs / name[0]}.png" for name in ("destination", "mask", "edges")]
    main([f"--cases={inputs / 'cases'}", "add", "new", "flatten", "--space=lab", *files])
    stored = Stored.load(inputs / "cases" / "new")
    assert stored.case.arguments == {"space": "lab"}
    assert np.count_nonzero(stored.case.edges) == 30
    stored.check(stored.case.given_to(poisson_cli.flatten), inputs)


def test_a_case_without_a_mask(inputs):
    given = [f"--destination={inputs / 'd.png'}", "--set", "rect=[2, 3, 20, 30]", "--set", 'axis="x"']
    main([f"--cases={inputs / 'cases'}", "add", "new", "tile", *given])
    stored = Stored.load(inputs / "cases" / "new")
    assert stored.case.mask is None and stored.case.arguments == {"rect": (2, 3, 20, 30), "axis": "x"}
    assert stored.expected.shape == (20, 30, 3)
    stored.check(stored.case.given_to(poisson_cli.tile), inputs)


@pytest.mark.parametrize(
    ("tool", "files"),
    [
        ("clone", ["destination", "mask"]),
        ("focus", ["destination"]),
        ("tile", ["destination", "mask"]),
        ("flatten", ["destination", "mask"]),
        ("focus", ["destination", "mask", "edges"]),
    ],
    ids=str,
)
def test_files_that_do_not_fit_the_tool_are_refused(inputs, tool, files):
    write_png(inputs / "e.png", np.eye(30, 40, dtype=np.uint8) * 255)
    with pytest.raises(SystemExit, match="--source|--mask|--edges"):
        main(
            [
                f"--cases={inputs / 'cases'}",
                "add",
                "new",
                tool,
                *[f"--{f}={inputs / f[0]}.png" for f in files],
            ]
        )


def test_adding_twice_is_refused(inputs):
    add(inputs, "mix")
    with pytest.raises(SystemExit, match="exists"):
        add(inputs, "mix")


def test_a_fill_with_a_source_is_refused(inputs):
    with pytest.raises(SystemExit, match="source"):
        add(inputs, "fill")


def test_refreshing_makes_the_expected_picture_anew(inputs):
    folder = add(inputs, "mix")
    right = read_png(folder / "expected.png")
    write_png(folder / "expected.png", np.zeros_like(right))
    main([f"--cases={inputs / 'cases'}", "refresh", "new"])
    np.testing.assert_array_equal(read_png(folder / "expected.png"), right)


def test_a_failure_says_where_and_leaves_two_pictures(inputs):
    stored = Stored.load(add(inputs, "mix"))
    wrong = stored.expected.copy()
    wrong[7, 9, 1] ^= 0x40
    wrong[8, 9, 2] ^= 1
    with pytest.raises(AssertionError) as failure:
        stored.check(wrong, inputs)
    message = str(failure.value)
    assert "2 values differ" in message and "row 7, column 9, channel 1" in message
    assert f"{wrong[7, 9, 1]} instead of {stored.expected[7, 9, 1]}" in message
    np.testing.assert_array_equal(read_png(inputs / "actual.png"), wrong)
    difference = read_png(inputs / "difference.png")
    assert difference[7, 9, 1] == 255 and difference[8, 9, 2] == 3 and np.count_nonzero(difference) == 2


def test_a_near_tie_may_go_either_way_but_by_one_only(inputs):
    stored = Stored.load(add(inputs, "mix"))
    tie = Stored(stored.case, stored.expected, np.array([[7, 9, 1]]))
    other = stored.expected.copy()
    other[7, 9, 1] ^= 1
    tie.check(other, inputs)
    with pytest.raises(AssertionError, match="1 values differ"):
        stored.check(other, inputs)
    other[7, 9, 1] ^= 16
    with pytest.raises(AssertionError, match="row 7"):
        tie.check(other, inputs)
