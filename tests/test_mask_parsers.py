"""Whatever a mask file holds: a mask of the picture's size or one `InputError` on one line, in bounded memory."""

import copy
import json
import re
import tracemalloc

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from poisson_cli.errors import InputError
from poisson_cli.images import Picture
from poisson_cli.masks import Canvas, decode_mask, parse_points
from poisson_cli.masks.annotations.rle import decode_counts
from tests import coco_oracle
from tests.small_pictures import MASK, encoded
from tests.test_mask_files import COCO, LABELME

CANVAS = Canvas("image", Picture("s.png", np.zeros(MASK.shape, np.uint8)))
parts = (
    st.none() | st.sampled_from(["alpha", "red", "index=1", "wing", "cat", "1", "3"]) | st.text(max_size=5)
)


def mask_or_refusal(data: bytes, part: str | None = None) -> np.ndarray | None:
    """What the file selects, None if it is refused; anything else fails the test."""
    try:
        mask = decode_mask(data, "file", part, CANVAS, 128).mask
    except InputError as error:
        assert re.match("(mask )?file[: ]", str(error))
        assert "\n" not in str(error)
        return None
    assert mask.shape == MASK.shape
    assert mask.dtype == np.bool_
    return mask


@given(st.binary(max_size=300), parts)
@settings(max_examples=300, deadline=None)
def test_any_bytes(data, part):
    mask_or_refusal(data, part)


PNG = encoded(MASK.astype(np.uint8) * 255)


@given(st.lists(st.tuples(st.integers(0, len(PNG) - 1), st.integers(0, 255)), min_size=1, max_size=4), parts)
@settings(max_examples=100, deadline=None)
def test_a_damaged_picture(changes, part):
    data = bytearray(PNG)
    for place, value in changes:
        data[place] = value
    mask_or_refusal(bytes(data), part)


points_text = st.text(alphabet="0123456789.,+-eE #\n\t\rnaif", max_size=60)


@given(points_text)
@settings(max_examples=300, deadline=None)
@example("1,2 3,4 1e308,1e-308")
@example("," * 50)
@example("1,1" + " " * 50 + ",")
def test_any_text_of_points(text):
    try:
        points = parse_points(text)
    except InputError as error:
        assert "\n" not in str(error)
    else:
        assert len(points) >= 3
        assert all(abs(number) <= 1e9 for point in points for number in point)
    mask_or_refusal(text.encode())


@given(st.lists(st.tuples(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9)), min_size=3, max_size=8))
@settings(max_examples=150, deadline=None)
def test_points_are_read_as_they_are_written(points):
    assert parse_points("\n".join(f"{x!r},{y!r}" for x, y in points)) == tuple((y, x) for x, y in points)
    assert mask_or_refusal(" ".join(f"{x!r},{y!r}" for x, y in points).encode()) is not None


# JSON

scalars = (
    st.none()
    | st.booleans()
    | st.integers(-3, 40)
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from([10**9, 10**400, 1e300, "mask", "circle", "wing", "cat", 2**63])
)
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=7) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=12,
)


def places(value: object, path: tuple = ()) -> list[tuple]:
    """The ways to every value inside."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path] * bool(path) + [place for key, one in inner for place in places(one, (*path, key))]


def replaced(document: dict, place: tuple, value: object) -> dict:
    document = copy.deepcopy(document)
    inside = document
    for key in place[:-1]:
        inside = inside[key]
    inside[place[-1]] = value
    return document


@pytest.mark.parametrize("document", [LABELME, COCO], ids=["labelme", "coco"])
@given(data=st.data())
@settings(max_examples=300, deadline=None)
def test_any_value_at_any_place(document, data):
    for _ in range(data.draw(st.integers(1, 2))):
        place = data.draw(st.sampled_from(places(document)))
        document = replaced(document, place, data.draw(values))
        if not places(document):
            return
    mask_or_refusal(json.dumps(document).encode(), data.draw(parts))


@given(st.dictionaries(st.sampled_from(["shapes", "annotations", "images", "categories"]), values), parts)
@settings(max_examples=200, deadline=None)
def test_any_document(document, part):
    mask_or_refusal(json.dumps(document).encode(), part)


@given(st.text(alphabet='{}[]":,0123456789eE.-shapenotil\\u', max_size=80))
@settings(max_examples=200, deadline=None)
def test_any_text_that_looks_like_json(text):
    mask_or_refusal(b'{"shapes": [' + text.encode())


# Run lengths


def of_counts(counts: object) -> bytes:
    return json.dumps(
        {"annotations": [{"id": 1, "segmentation": {"size": list(MASK.shape), "counts": counts}}]}
    ).encode()


@given(st.text(alphabet=[chr(code) for code in range(44, 116)], max_size=40))
@settings(max_examples=300, deadline=None)
def test_any_compressed_counts(text):
    mask_or_refusal(of_counts(text))


@given(st.lists(st.integers(-2, 800), max_size=9))
@settings(max_examples=200, deadline=None)
def test_any_counts(counts):
    mask = mask_or_refusal(of_counts(counts))
    good = sum(counts) == MASK.size and all(count >= 0 for count in counts)
    assert (mask is not None) == good
    if good:
        assert mask.sum() == sum(counts[1::2])


@given(st.lists(st.booleans(), min_size=MASK.size, max_size=MASK.size))
@settings(max_examples=60, deadline=None)
def test_what_coco_compresses_is_read_back(pixels):
    mask = np.array(pixels).reshape(MASK.shape)
    np.testing.assert_array_equal(mask_or_refusal(of_counts(coco_oracle.encode(mask)["counts"])), mask)


def test_compressed_counts_by_the_definition():
    """The decoder of the format's description, a loop over the digits."""
    text = coco_oracle.encode(np.random.default_rng(2).random((300, 400)) < 0.003)["counts"]
    numbers: list[int] = []
    value = digits = 0
    for character in text:
        digit = ord(character) - 48
        value |= (digit & 31) << 5 * digits
        digits += 1
        if not digit & 32:
            value -= (digit & 16) << 5 * (digits - 1) + 1
            numbers.append(value + (numbers[-2] if len(numbers) > 2 else 0))
            value = digits = 0
    assert sum(numbers) == 300 * 400
    assert decode_counts(text, "it").tolist() == numbers


# Large ones

ZIGZAG = [number for n in range(100_000) for number in (n / 10, 1e9 * (n % 2))]


@pytest.mark.parametrize(
    ("document", "text"),
    [
        ({"annotations": [{"id": 1, "segmentation": [ZIGZAG]}]}, "too intricate"),
        (
            {"annotations": [{"segmentation": {"size": [2000, 3000], "counts": [6_000_001]}}]},
            "6000001 where a",
        ),
        (
            {"annotations": [{"segmentation": {"size": [2000, 3000], "counts": "oooooo0" * 9}}]},
            "do not add up",
        ),
        (
            {"annotations": [{"segmentation": {"size": [10**9, 10**9], "counts": [10**18]}}]},
            "for a picture of",
        ),
        (
            {"shapes": [{"points": [[0, 0], [10**9, 10**9]], "shape_type": "mask", "mask": "iVBORw0KGgo="}]},
            "does not lie on the picture",
        ),
    ],
)
def test_lying_files_take_no_memory(document, text):
    canvas = Canvas("image", Picture("s.png", np.zeros((2000, 3000), np.uint8)))
    data = json.dumps(document).encode()
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=text):
            decode_mask(data, "file", None, canvas, 128)
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()


def test_a_thousand_annotations_of_a_large_picture_are_painted_once():
    """Each on its own would take six megabytes, a thousand times over."""
    canvas = Canvas("image", Picture("s.png", np.zeros((2000, 3000), np.uint8)))
    annotations = [
        {"segmentation": {"size": [2000, 3000], "counts": [n, 1, 6_000_000 - n - 1]}} for n in range(1000)
    ]
    mask = decode_mask(json.dumps({"annotations": annotations}).encode(), "file", None, canvas, 128).mask
    assert mask.sum() == 1000
    assert mask[:1000, 0].all()
