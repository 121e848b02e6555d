"""JPEGs whose data end before the picture does, which every decoder fills up with grey; and those that are in order."""

import io
import itertools
import struct

import cv2
import numpy as np
import pytest
from PIL import Image

from poisson_cli import images
from poisson_cli.errors import InputError
from poisson_cli.images.codecs.jpeg_scans import scans_of
from tests.kinds import RGB, pillow
from tests.small_pictures import smooth

PHOTO = smooth(203, 310, 3)
KINDS = {
    "plain": {},
    "halved colours": {"subsampling": "4:2:0"},
    "colours halved across": {"subsampling": "4:2:2"},
    "best tables": {"optimize": True},
    "progressive": {"progressive": True},
    "restart markers": {"restart_marker_blocks": 3},
    "very coarse": {"quality": 1},
    "very fine": {"quality": 100},
    "stored as RGB": {"keep_rgb": True},
}


def decode(data: bytes) -> np.ndarray:
    return images.decode(data, "a").pixels


def without_its_end(data: bytes, part: float) -> bytes:
    """Cut the data off, and put the marker behind that ends a file."""
    first = next(scans_of(data)).start
    return data[: first + int((len(data) - first) * part)].rstrip(b"\xff") + b"\xff\xd9"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("content", ["photograph", "one colour", "noise"])
def test_what_is_in_order_is_read_as_others_read_it(kind, content):
    rng = np.random.default_rng(3)
    for height, width in ((1, 1), (7, 300), (64, 65), (203, 310), (400, 9)):
        pixels = {
            "photograph": np.resize(PHOTO, (height, width, 3)),
            "one colour": np.full((height, width, 3), 250, np.uint8),
            "noise": rng.integers(0, 256, (height, width, 3), dtype=np.uint8),
        }[content]
        for array in (pixels, pixels[..., 1].copy()):
            settings = {
                key: value for key, value in KINDS[kind].items() if array.ndim == 3 or key != "keep_rgb"
            }
            data = pillow(array, "JPEG", **settings)
            with Image.open(io.BytesIO(data)) as image:
                np.testing.assert_array_equal(decode(data), np.asarray(image))
            for scan in scans_of(data):
                assert scan.bits <= 8 * (scan.end - scan.start)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "progressive"])
@pytest.mark.parametrize("part", [0.02, 0.3, 0.7])
def test_an_early_end_is_found_out(kind, part):
    data = without_its_end(pillow(PHOTO, "JPEG", **KINDS[kind]), part)
    assert cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR).shape == PHOTO.shape  # in part grey
    with pytest.raises(InputError, match="data end early|cannot hold as many pixels"):
        decode(data)


@pytest.mark.parametrize(
    ("kind", "factor"), list(itertools.product(["plain", "halved colours", "progressive"], [20, 60, 90]))
)
def test_a_header_that_claims_more_is_found_out_before_memory_is_asked_for(kind, factor):
    data = bytearray(pillow(PHOTO, "JPEG", quality=98, **KINDS[kind]))
    place = data.index(b"\xff\xc2" if kind == "progressive" else b"\xff\xc0")
    height, width = (factor * side for side in PHOTO.shape[:2])
    data[place + 5 : place + 9] = struct.pack(">HH", height, width)
    with pytest.raises(InputError, match=r"bytes cannot hold as many pixels|claims"):
        decode(bytes(data))


def test_what_stands_behind_the_picture_does_not_matter():
    data = pillow(RGB, "JPEG", quality=90)
    expected = decode(data)
    for behind in (b"a trailer", data, bytes(100), b"\xff\xd9"):
        np.testing.assert_array_equal(decode(data + behind), expected)
    np.testing.assert_array_equal(decode(data[:-2] + b"\xff\xff\xff\xd9"), expected)


def test_any_bytes_are_scans_or_none():
    rng = np.random.default_rng(4)
    whole = pillow(RGB, "JPEG", progressive=True)
    for _ in range(500):
        damaged = bytearray(whole)
        for place in rng.integers(0, 700, 5):
            damaged[place] = rng.integers(256)
        for scan in scans_of(bytes(damaged[: rng.integers(2, len(damaged))])):
            assert scan.bits >= 0
