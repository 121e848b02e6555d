"""Selections described in JSON mean what the same words mean on the command line."""

import json
import shlex

import click
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from poisson_cli import options
from poisson_cli.errors import InputError
from poisson_cli.masks.plan import selection_of
from poisson_cli.settings import Selection
from tests.test_mask_parsers import places, replaced, values


def from_words(*words: str) -> Selection:
    seen = []

    @click.command()
    @options.selection
    def probe(selection):
        seen.append(selection)

    probe.main(list(words), standalone_mode=False)
    return seen[0]


WHOLE = {
    "mask": ["a.png", "b.json:c"],
    "selection": [
        {"rect": [1, 2, 3, 4]},
        {"subtract": {"ellipse": [-5, 6, 7, 8]}},
        {"grow": 3},
        {"intersect": {"polygon": [[1, 2], [3.5, 4], [5, -6]]}},
        {"add": {"lasso": [[1, 2], [3, 4], [5, 6]]}},
        {"mask": "d.png:alpha"},
        {"shrink": 2},
    ],
    "invert_mask": True,
    "mask_threshold": 9,
}


@pytest.mark.parametrize(
    ("description", "words"),
    [
        ({"mask": "a.png"}, ["-m", "a.png"]),
        ({"selection": [{"rect": [1, 2, 3, 4]}]}, ["--rect", "1,2,3,4"]),
        (
            WHOLE,
            shlex.split(
                "-m a.png -m b.json:c --rect 1,2,3,4 --subtract --ellipse -5,6,7,8 --grow 3 "
                "--intersect --polygon '1,2 3.5,4 5,-6' --add --lasso '1,2 3,4 5,6' -m d.png:alpha "
                "--shrink 2 --invert-mask --mask-threshold 9"
            ),
        ),
    ],
)
def test_it_means_what_the_words_mean(description, words):
    assert selection_of(json.loads(json.dumps(description))) == from_words(*words)


@pytest.mark.parametrize(
    ("description", "text"),
    [
        ({}, 'no selection: name a mask with "mask", or shapes with "selection"'),
        ({"mask": 3}, '"mask" is 3, not a list'),
        ({"mask": [3]}, '"mask" is 3, not the name of a file'),
        ({"mask": "a\0b"}, '"mask" is "a\\u0000b", not the name of a file'),
        ({"selection": {}}, '"selection" is an object, not a list'),
        ({"selection": ["rect"]}, 'step 1 of the selection is "rect", not an object'),
        (
            {"selection": [{}]},
            'step 1 of the selection has 0 keys, not one, as in {"rect": [10, 20, 300, 200]}',
        ),
        (
            {"selection": [{"rectangle": [1, 2, 3, 4]}]},
            'a selection has no "rectangle"; it has mask, rect, ellipse',
        ),
        ({"selection": [{"rect": [1, 2, 3]}]}, '"rect" has 3 numbers, not x, y, width and height'),
        ({"selection": [{"rect": [1, 2, 3, 0]}]}, '"rect" has 0, not a whole number from 1 to 999999999'),
        ({"selection": [{"ellipse": [1.5, 2, 3, 4]}]}, '"ellipse" has 1.5, not a whole number'),
        (
            {"selection": [{"polygon": [[1, 2], [3, 4]]}]},
            '"polygon" has 2 points, not 3 to 1,000,000 of x and y',
        ),
        (
            {"selection": [{"lasso": [[1, 2], [3, 4], [5]]}]},
            '"lasso" has 3 points, not 3 to 1,000,000 of x and y',
        ),
        (
            {"selection": [{"lasso": [[1, 2], [3, 4], [5, "6"]]}]},
            '"lasso" has "6" where a coordinate should be',
        ),
        (
            {"selection": [{"grow": 1}]},
            "the first step of the selection works on what was selected before it",
        ),
        ({"selection": [{"subtract": {"mask": "a"}}]}, "the first step of the selection works on what was"),
        (
            {"mask": "a", "selection": [{"grow": 0}]},
            '"grow" of step 1 of the selection has 0, not a whole number',
        ),
        ({"mask": "a", "selection": [{"add": {"grow": 1}}]}, 'a selection has no "grow"; it has mask, rect'),
        ({"mask": "a", "invert_mask": 1}, '"invert_mask" is 1, not true or false'),
        ({"mask": "a", "mask_threshold": 256}, '"mask_threshold" has 256, not a whole number from 1 to 255'),
    ],
)
def test_what_makes_no_sense_is_said(description, text):
    with pytest.raises(InputError) as caught:
        selection_of(description)
    assert str(caught.value).startswith(text)


@given(st.data())
@settings(max_examples=200, deadline=None)
def test_any_value_at_any_place(data):
    description = replaced(WHOLE, data.draw(st.sampled_from(places(WHOLE))), data.draw(values))
    try:
        selection = selection_of(description)
    except InputError as error:
        assert "\n" not in str(error)
    else:
        assert isinstance(selection, Selection)
        hash(selection)  # plain and frozen all the way down
