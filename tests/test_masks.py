"""Which pixels a selection selects."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from poisson_cli.errors import InputError
from poisson_cli.images import Picture, reading
from poisson_cli.masks import Canvas, draw_rectangle, select, strength
from poisson_cli.settings import Combine, Grow, MaskFile, Rectangle, Selection
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
    np.testing.assert_array_equal(draw_rectangle(rectangle, (24, 30)), expected)


@pytest.fixture
def canvas(folder) -> Canvas:
    return Canvas("source", Picture("s.png", SOURCE), ("destination", Picture("d.png", DESTINATION)))


def added(*areas: str | Rectangle, invert: bool = False) -> Selection:
    steps = (Combine(MaskFile(area) if isinstance(area, str) else area) for area in areas)
    return Selection(tuple(steps), invert=invert)


def mask_of(selection: Selection, canvas: Canvas) -> np.ndarray:
    return select(selection, canvas).mask


OUTSIDE = Rectangle(-5, -5, 1, 1)


def test_union_then_inversion(canvas):
    np.testing.assert_array_equal(mask_of(added("mask.png"), canvas), MASK)
    corner = Rectangle(0, 0, 3, 2)
    union = MASK.copy()
    union[:3, :2] = True
    both = ("mask.png", "mask.png", corner, OUTSIDE)
    np.testing.assert_array_equal(mask_of(added(*both), canvas), union)
    np.testing.assert_array_equal(mask_of(added(*both, invert=True), canvas), ~union)


def test_an_empty_union_inverted_selects_everything(canvas):
    assert mask_of(added(OUTSIDE, invert=True), canvas).all()


def test_steps_are_done_in_their_order(canvas):
    inner = MaskFile("mask.png")
    block, corner = Rectangle(2, 2, 20, 20), Rectangle(0, 0, 6, 6)
    drawn = {area: draw_rectangle(area, MASK.shape) for area in (block, corner)}
    steps = (Combine(block), Combine(inner, "subtract"), Combine(corner))
    np.testing.assert_array_equal(mask_of(Selection(steps), canvas), drawn[block] & ~MASK | drawn[corner])
    steps = (Combine(block), Combine(corner), Combine(inner, "subtract"))
    np.testing.assert_array_equal(mask_of(Selection(steps), canvas), (drawn[block] | drawn[corner]) & ~MASK)
    steps = (Combine(block), Combine(inner, "intersect"), Combine(corner, "subtract"))
    np.testing.assert_array_equal(mask_of(Selection(steps), canvas), drawn[block] & MASK & ~drawn[corner])


def test_growing_is_a_step_like_the_others(canvas):
    block, hole = Rectangle(8, 5, 5, 9), Rectangle(10, 8, 1, 1)
    drawn = draw_rectangle(block, MASK.shape)
    grown = drawn | draw_rectangle(Rectangle(7, 5, 7, 9), MASK.shape)
    grown |= draw_rectangle(Rectangle(8, 4, 5, 11), MASK.shape)
    late = Selection((Combine(block), Grow(1), Combine(hole, "subtract")))
    np.testing.assert_array_equal(mask_of(late, canvas), grown & ~draw_rectangle(hole, MASK.shape))
    early = Selection((Combine(block), Combine(hole, "subtract"), Grow(1)))
    np.testing.assert_array_equal(mask_of(early, canvas), grown)
    closed = Selection((Combine(block), Combine(hole, "subtract"), Grow(1), Grow(-1)))
    np.testing.assert_array_equal(mask_of(closed, canvas), drawn)


@pytest.mark.parametrize(
    ("selection", "text"),
    [
        (added(OUTSIDE), "no --rect meets the source, which is 30x24"),
        (
            added(OUTSIDE, Rectangle(30, 0, 1, 1), invert=False),
            "no --rect meets the source, which is 30x24",
        ),
        (
            added(Rectangle(0, 0, 24, 30), invert=True),
            "everything was selected, so --invert-mask leaves nothing",
        ),
        (
            Selection((Combine(MaskFile("mask.png")), Combine(MaskFile("mask.png"), "subtract"))),
            "--subtract leaves nothing",
        ),
        (
            Selection((Combine(MaskFile("mask.png")), Combine(OUTSIDE, "intersect"))),
            "--intersect leaves nothing",
        ),
        (Selection((Combine(MaskFile("mask.png")), Grow(-40))), "--shrink 40 leaves nothing"),
        (Selection(), "nothing was added to it"),
    ],
)
def test_an_empty_selection_is_refused_with_the_reason(canvas, selection, text):
    with pytest.raises(InputError, match=f"^the selection is empty: {text}$"):
        select(selection, canvas)


def test_a_label_that_is_not_there_is_named(canvas, folder):
    labels = np.zeros(MASK.shape, np.uint8)
    labels[3:9, 4:8] = 3
    Path("labels.png").write_bytes(encoded(labels))
    np.testing.assert_array_equal(mask_of(added(MaskFile("labels.png:index=3")), canvas), labels == 3)
    with pytest.raises(InputError, match="^the selection is empty: no pixel is labels.png:index=4$"):
        select(added(MaskFile("labels.png:index=4")), canvas)


def test_a_mask_of_another_size_is_refused_with_the_way_out(canvas):
    with pytest.raises(
        InputError, match="dest-mask.png is 48x40, but the source s.png is 30x24; it has the size of"
    ):
        select(added("dest-mask.png"), canvas)
    alone = Canvas("image", Picture("i.png", GREY))
    with pytest.raises(
        InputError, match="mask.png is 30x24, but the image i.png is 48x40; a mask must have the size"
    ):
        select(added("mask.png"), alone)


def test_a_mask_on_its_side_is_told_about_orientation(folder):
    Path("turned.png").write_bytes(encoded(np.zeros((48, 40), np.uint8)))
    with pytest.raises(
        InputError, match=r"turned.png is 40x48, but the image i.png is 48x40 \(pictures are turned"
    ):
        select(added("turned.png"), Canvas("image", Picture("i.png", GREY)))


def test_a_lossy_mask_with_grey_edges_is_cut_with_a_notice(canvas, folder):
    ramp = np.repeat(np.arange(100, 220, 4, dtype=np.uint8)[None], 24, axis=0)
    Path("soft.png").write_bytes(encoded(ramp))
    selected = select(added("soft.png"), canvas)
    np.testing.assert_array_equal(selected.mask, ramp >= 128)
    # 112, 116, 120, 124 below and 128, 132, 136, 140 above, in each of 24 rows.
    assert selected.notices == (
        "mask soft.png has grey edges: it is cut at 128, and 192 of its pixels are less than 16 levels from there "
        "(--mask-threshold moves the cut)",
    )


@pytest.mark.parametrize("values", [[0, 255], [0, 120, 255], [0, 130, 200], [0, 111, 144, 255]])
def test_clean_masks_have_no_notice(canvas, folder, values):
    drawn = np.zeros(MASK.shape, np.uint8)
    drawn[0, : len(values)] = values
    Path("clean.png").write_bytes(encoded(drawn))
    assert select(added("clean.png"), canvas).notices == ()
