"""Which pixels a selection selects."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from poisson_cli.errors import InputError
from poisson_cli.images import Picture, reading
from poisson_cli.masks import Canvas, draw_rectangle, select, strength
from poisson_cli.settings import Rectangle, Selection
from tests.small_pictures import DESTINATION, GREY, MASK, SOURCE, encoded

WHITE = MASK.astype(np.uint8) * 255


def strength_of(data: bytes) -> np.ndarray:
    return strength(reading.decode(data, "mask"))


def selected(data: bytes, threshold: int = 128) -> np.ndarray:
    return strength_of(data) >= threshold


@pytest.mark.parametrize("form", ["PNG", "TIFF", "BMP"])
def test_a_one_bit_mask(form):
    np.testing.assert_array_equal(selected(encoded(MASK, form), 255), MASK)


@pytest.mark.parametrize(
    ("threshold", "expected"), [(1, [0, 1, 1, 1]), (128, [0, 0, 1, 1]), (255, [0, 0, 0, 1])]
)
def test_a_grey_mask_has_a_threshold(threshold, expected):
    data = encoded(np.array([[0, 127, 128, 255]], np.uint8))
    np.testing.assert_array_equal(selected(data, threshold), [expected])


def test_any_bright_channel_selects():
    red_green_blue = np.eye(3, dtype=np.uint8)[None] * 200
    np.testing.assert_array_equal(selected(encoded(red_green_blue)), [[True] * 3])
    np.testing.assert_array_equal(selected(encoded(red_green_blue), 201), [[False] * 3])


@pytest.mark.parametrize("channels", [1, 3])
def test_a_lossy_mask_selects_what_was_drawn(channels):
    drawn = np.zeros((64, 64), np.uint8)
    drawn[13:45, 9:42] = 255
    data = encoded(drawn if channels == 1 else np.dstack([drawn] * 3), "JPEG", quality=60)
    assert (strength_of(data)[drawn == 0] > 0).any()
    np.testing.assert_array_equal(selected(data), drawn > 0)


def palette_mask(indices: np.ndarray, colours: list[tuple[int, int, int]], **settings) -> bytes:
    image = Image.fromarray(indices.astype(np.uint8), "P")
    image.putpalette([value for colour in colours for value in colour])
    file = io.BytesIO()
    image.save(file, "PNG", **settings)
    return file.getvalue()


def test_every_label_of_a_map_of_labels_but_black_selects():
    """The colours of Pascal VOC: dark ones are labels as good as bright ones."""
    voc = [(0, 0, 0), (128, 0, 0), (0, 128, 0), (64, 0, 0), (0, 0, 64), (224, 224, 192)]
    labels = np.array([[0, 1, 2, 3, 4, 5]])
    for threshold in (1, 128, 255):
        np.testing.assert_array_equal(
            selected(palette_mask(labels, voc), threshold), [[False, True, True, True, True, True]]
        )


def test_a_palette_of_greys_is_a_grey_mask():
    """An optimiser may sort the colours by use: the index means nothing."""
    data = palette_mask(np.array([[0, 1, 2]]), [(255, 255, 255), (0, 0, 0), (90, 90, 90)])
    np.testing.assert_array_equal(selected(data), [[True, False, False]])


def test_what_is_opaque_is_selected_whatever_its_colour():
    cut_out = np.dstack((SOURCE // 8, WHITE))
    np.testing.assert_array_equal(selected(encoded(cut_out)), MASK)
    black_on_nothing = np.dstack((np.zeros_like(WHITE), WHITE))
    np.testing.assert_array_equal(selected(encoded(black_on_nothing)), MASK)
    soft = np.dstack((WHITE, np.full_like(WHITE, 127)))
    soft[0, 0, 1] = 128
    expected = np.zeros_like(MASK)
    expected[0, 0] = True
    np.testing.assert_array_equal(selected(encoded(soft)), expected)


@pytest.mark.parametrize("opacity", [0, 60, 255])
def test_an_alpha_that_is_the_same_everywhere_says_nothing(opacity):
    data = encoded(np.dstack([WHITE] * 3 + [np.full_like(WHITE, opacity)]))
    np.testing.assert_array_equal(selected(data), MASK)


def test_a_mask_is_turned_upright_as_its_picture_is():
    exif = Image.Exif()
    exif[0x0112] = 6
    data = encoded(np.ascontiguousarray(np.rot90(WHITE, 1)), exif=exif)
    np.testing.assert_array_equal(selected(data), MASK)


@pytest.mark.parametrize(
    ("rectangle", "rows", "cols"),
    [
        (Rectangle(2, 3, 4, 5), slice(2, 6), slice(3, 8)),
        (Rectangle(0, 0, 24, 30), slice(None), slice(None)),
        (Rectangle(-3, -2, 5, 4), slice(0, 2), slice(0, 2)),
        (Rectangle(20, 28, 99, 99), slice(20, None), slice(28, None)),
        (Rectangle(-9, 0, 5, 30), slice(0, 0), slice(0, 0)),
        (Rectangle(0, -9, 24, 5), slice(0, 0), slice(0, 0)),
        (Rectangle(24, 0, 1, 1), slice(0, 0), slice(0, 0)),
        (Rectangle(-9, -9, 99, 99), slice(None), slice(None)),
    ],
)
def test_rectangles(rectangle, rows, cols):
    expected = np.zeros((24, 30), bool)
    expected[rows, cols] = True
    mask = np.zeros((24, 30), bool)
    draw_rectangle(mask, rectangle)
    np.testing.assert_array_equal(mask, expected)


@pytest.fixture
def canvas(folder) -> Canvas:
    return Canvas("source", Picture("s.png", SOURCE), ("destination", Picture("d.png", DESTINATION)))


def paths(*names: str) -> tuple[Path, ...]:
    return tuple(map(Path, names))


def test_union_then_inversion(canvas):
    np.testing.assert_array_equal(select(Selection(paths("mask.png")), canvas), MASK)
    corner = Rectangle(0, 0, 3, 2)
    union = MASK.copy()
    union[:3, :2] = True
    both = Selection(paths("mask.png", "mask.png"), (corner, Rectangle(-5, -5, 1, 1)))
    np.testing.assert_array_equal(select(both, canvas), union)
    inverted = Selection(paths("mask.png"), (corner,), invert=True)
    np.testing.assert_array_equal(select(inverted, canvas), ~union)


def test_an_empty_union_inverted_selects_everything(canvas):
    assert select(Selection((), (Rectangle(-5, -5, 1, 1),), invert=True), canvas).all()


@pytest.mark.parametrize(
    ("selection", "text"),
    [
        (Selection((), (Rectangle(-5, -5, 1, 1),)), "no --rect meets the source, which is 30x24"),
        (
            Selection((), (Rectangle(0, 0, 24, 30),), invert=True),
            "everything was selected, so --invert-mask leaves nothing",
        ),
    ],
)
def test_an_empty_selection_is_refused_with_the_reason(canvas, selection, text):
    with pytest.raises(InputError, match=f"^the selection is empty: {text}$"):
        select(selection, canvas)


def test_a_mask_of_another_size_is_refused_with_the_way_out(canvas):
    with pytest.raises(
        InputError, match="dest-mask.png is 48x40, but the source s.png is 30x24; it has the size of"
    ):
        select(Selection(paths("dest-mask.png")), canvas)
    alone = Canvas("image", Picture("i.png", GREY))
    with pytest.raises(
        InputError, match="mask.png is 30x24, but the image i.png is 48x40; a mask must have the size"
    ):
        select(Selection(paths("mask.png")), alone)
