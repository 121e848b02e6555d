"""The matrix of formats: files of other programs read as they are, and ours read as they are by other programs."""

import io
from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from poisson_cli import defaults
from poisson_cli.errors import OutputError
from poisson_cli.images import Picture, formats, reading, target, writing
from tests import formats_table
from tests.kinds import (
    DEEP_GREY,
    DEEP_GREY_ALPHA,
    DEEP_RGB,
    DEEP_RGBA,
    FLOAT_GREY,
    FLOAT_RGB,
    FLOAT_RGBA,
    GREY,
    GREY_ALPHA,
    KINDS,
    RGB,
    RGBA,
)


@pytest.mark.parametrize("name", KINDS)
def test_files_of_others_are_read_as_they_are(name, monkeypatch):
    kind = KINDS[name]()
    monkeypatch.setattr(
        Image, "MAX_IMAGE_PIXELS", 10
    )  # of no effect: a picture of 100 megapixels is none too many
    picture = reading.decode(kind.data, "a file")
    assert picture.pixels.dtype == kind.pixels.dtype
    assert picture.pixels.shape == kind.pixels.shape
    difference = np.abs(picture.pixels.astype(np.float64) - kind.pixels)
    assert difference.max() <= kind.close
    assert (picture.alpha is None) == (kind.alpha is None)
    if kind.alpha is not None:
        assert picture.alpha.dtype == picture.pixels.dtype
        np.testing.assert_array_equal(picture.alpha, kind.alpha)


def by_opencv(data: bytes) -> np.ndarray:
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if pixels.ndim == 2:
        return pixels
    order = {3: [2, 1, 0], 4: [2, 1, 0, 3]}[pixels.shape[2]]
    return pixels[..., order]


def by_pillow(data: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image)


def by_tifffile(data: bytes) -> np.ndarray:
    return tifffile.imread(io.BytesIO(data))


def by_opencv_as_grey(data: bytes) -> np.ndarray:
    """Grey with alpha, which OpenCV spreads to RGB with alpha."""
    rgba = by_opencv(data)
    assert (rgba[..., 0] == rgba[..., 1]).all()
    return rgba[..., [0, 3]]


READERS = {"TIFF": by_tifffile, "BMP": by_pillow, "WebP": by_pillow, "JPEG": by_pillow}
STACKS = [
    GREY,
    GREY_ALPHA,
    RGB,
    RGBA,
    DEEP_GREY,
    DEEP_GREY_ALPHA,
    DEEP_RGB,
    DEEP_RGBA,
    FLOAT_GREY,
    FLOAT_RGB,
    FLOAT_RGBA,
]


def picture_of(stack: np.ndarray) -> Picture:
    if stack.ndim == 2 or stack.shape[2] == 3:
        return Picture("a", stack)
    colours = stack[..., 0] if stack.shape[2] == 2 else stack[..., :3]
    return Picture("a", np.ascontiguousarray(colours), np.ascontiguousarray(stack[..., -1]))


def stack_of(picture: Picture, form: formats.Format) -> np.ndarray:
    """What a file holds: grey spread to RGB where the format has no grey."""
    pixels = picture.pixels
    if pixels.ndim == 2 and not form.grey:
        pixels = np.dstack([pixels] * 3)
    return pixels if picture.alpha is None else np.dstack((pixels, picture.alpha))


CASES = [
    pytest.param(
        form, picture_of(stack), id=f"{form.name}, {picture_of(stack).layout}, {picture_of(stack).depth}"
    )
    for form in formats.WRITTEN
    for stack in STACKS
    if form.codec != "exr"
    and picture_of(stack).depth in form.depths
    and (form.alpha or picture_of(stack).alpha is None)
]


@pytest.mark.parametrize(("form", "picture"), CASES)
def test_others_read_our_files_as_they_are(form, picture):
    """And so do we, which is why a pipe of several commands loses nothing."""
    if form is formats.HDR:  # what the format can hold of it
        picture = reading.decode(writing.encode(picture, form), "rounded")
    before = picture.pixels.copy()
    data = writing.encode(picture, form)
    np.testing.assert_array_equal(picture.pixels, before)
    expected = stack_of(picture, form)
    reader = READERS.get(form.name, by_opencv)
    if form is formats.PNG and picture.channels == 2:
        reader = by_opencv_as_grey
    found = reader(data)
    assert (found.dtype, found.shape) == (expected.dtype, expected.shape)
    if form is formats.JPEG:
        assert np.abs(found.astype(int) - expected).mean() < 8
        return
    np.testing.assert_array_equal(found, expected)
    back = reading.decode(data, "ours")
    np.testing.assert_array_equal(stack_of(back, form), expected)
    assert back.channels == picture.channels or not form.grey


def test_a_name_that_says_grey_is_kept_to(tmp_path):
    grey, colours = Picture("grey.png", GREY), Picture("colours.png", RGB)
    target.prepare(tmp_path / "a.pgm").check_fits(grey)
    with pytest.raises(OutputError, match="a.pgm: a PGM is grey, and colours.png is RGB; name it .ppm"):
        target.prepare(tmp_path / "a.pgm").check_fits(colours)
    target.prepare(tmp_path / "a.pgm", form="ppm").check_fits(colours)
    with pytest.raises(OutputError, match="the ending .pbm does not tell a picture format"):
        target.prepare(tmp_path / "a.pbm")


def test_radiance_rounds_to_the_nearest_it_has():
    """Eight bits for the largest channel: off by half a unit of the last place, a 256th, at most."""
    picture = picture_of(np.abs(FLOAT_RGB))
    back = reading.decode(writing.encode(picture, formats.HDR), "rounded").pixels
    assert (np.abs(back - picture.pixels) <= picture.pixels.max(axis=2, keepdims=True) / 256).all()
    odd = np.array([[[np.nan, -1, 0.5], [np.inf, 0, 1], [0, 0, 0]]], np.float32)
    back = reading.decode(writing.encode(Picture("odd", odd), formats.HDR), "odd").pixels
    assert back[0, 0].tolist() == [0, 0, 0.5]
    assert back[0, 1, 0] > 1e38
    assert back[0, 2].tolist() == [0, 0, 0]


def test_the_page_about_formats_is_up_to_date():
    page = formats_table.PAGE.read_text(encoding="utf-8")
    assert formats_table.with_tables(page) == page


def test_endings_on_the_command_line_are_those_of_the_formats():
    assert {formats.by_extension(Path(f"a.{ending}")) for ending in defaults.FORMATS} == set(formats.WRITTEN)
