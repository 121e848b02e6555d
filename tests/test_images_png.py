"""PNG files that we put together ourselves, taken apart by the standard's own words."""

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from poisson_cli.images import Picture, formats, writing
from poisson_cli.images.codecs import png_writer
from tests.photographs import photograph
from tests.small_pictures import ALPHA, GREY, SOURCE, encoded


def blocks(data: bytes) -> list[tuple[bytes, bytes]]:
    """Name and content of each block; their checksums are checked."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    found, at = [], 8
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        name, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert struct.unpack_from(">I", data, at + 8 + length) == (zlib.crc32(name + content),)
        found.append((name, content))
        at += 12 + length
    return found


def unfiltered(data: bytes, row: int, distance: int) -> tuple[bytes, list[int]]:
    """The rows of a file byte by byte (PNG specification, 9.2), and the filter of each."""
    packed = zlib.decompress(b"".join(content for name, content in blocks(data) if name == b"IDAT"))
    rows, filters = [bytes(row)], []
    for at in range(0, len(packed), row + 1):
        number, rest, line = packed[at], packed[at + 1 : at + 1 + row], bytearray()
        for i in range(row):
            a = line[i - distance] if i >= distance else 0
            b = rows[-1][i]
            foreseen = (0, a, b, (a + b) // 2)[number]
            line.append((rest[i] + foreseen) % 256)
        filters.append(number)
        rows.append(bytes(line))
    return b"".join(rows[1:]), filters


def picture(pixels: np.ndarray) -> Picture:
    """Alpha by itself."""
    if pixels.ndim == 2 or pixels.shape[2] == 3:
        return Picture("a.png", pixels)
    colours = np.ascontiguousarray(pixels[..., :-1])
    return Picture(
        "a.png",
        colours[..., 0] if colours.shape[2] == 1 else colours,
        alpha=np.ascontiguousarray(pixels[..., -1]),
    )


DEEP = (SOURCE.astype(np.uint16) << 8) | SOURCE[::-1]


@pytest.mark.parametrize("band", [1, 200, 1 << 18])
@pytest.mark.parametrize(
    "pixels",
    [GREY, ALPHA[..., 2:], SOURCE, ALPHA, DEEP, DEEP[..., 0], SOURCE[:, :1], SOURCE[:1], DEEP[:1, :1]],
    ids=lambda pixels: f"{pixels.dtype} {pixels.shape}",
)
def test_the_rows_are_those_of_the_picture(pixels, band, monkeypatch):
    """In however many bands they are filtered."""
    pixels = np.ascontiguousarray(pixels)
    monkeypatch.setattr(png_writer, "_BAND", band)
    data = writing.encode(picture(pixels), formats.PNG)
    height, width = pixels.shape[:2]
    distance = pixels.itemsize * pixels[0, 0].size
    rows, _ = unfiltered(data, width * distance, distance)
    assert rows == pixels.astype(pixels.dtype.newbyteorder(">")).tobytes()
    header = dict(blocks(data))[b"IHDR"]
    assert struct.unpack(">IIBB", header[:10]) == (
        width,
        height,
        8 * pixels.itemsize,
        {1: 0, 2: 4, 3: 2, 4: 6}[pixels[0, 0].size],
    )
    assert all(content for name, content in blocks(data) if name == b"IDAT")


@pytest.mark.parametrize("band", [1, 1 << 18])
def test_every_row_has_the_filter_that_suits_it(band, monkeypatch):
    monkeypatch.setattr(png_writer, "_BAND", band)
    random = np.random.default_rng(5)
    ramp = np.arange(100, dtype=np.uint8) * 2
    noise = random.integers(0, 256, 100, np.uint8)
    sparse = np.zeros(100, np.uint8)
    sparse[::7] = 1
    slope = (noise.astype(int) + np.arange(100)) // 2  # between the row above and what is on the left
    rows = [sparse, ramp, noise, noise, slope.astype(np.uint8)]
    for _ in range(3):
        between = np.empty(100, np.uint8)
        for i in range(100):
            between[i] = (int(between[i - 1] if i else 0) + int(rows[-1][i])) // 2
        rows.append(between)
    data = writing.encode(Picture("a.png", np.stack(rows)), formats.PNG)
    _, filters = unfiltered(data, 100, 1)
    assert filters[0] == 0
    assert filters[1] == 1
    assert filters[3] == 2
    assert filters[5:] == [3, 3, 3]


@pytest.mark.parametrize("name", ["astronaut.png", "chelsea.png", "coffee.png", "rocket.jpg", "camera.png"])
def test_files_of_photographs_are_about_as_small_as_pillows(name):
    pixels = photograph(name)
    ours = len(writing.encode(Picture("a.png", pixels), formats.PNG))
    assert ours < 1.05 * len(encoded(pixels, compress_level=1, compress_type=zlib.Z_RLE))
    assert ours < 1.10 * len(encoded(pixels))


def test_flat_pictures_take_next_to_nothing():
    mask = np.zeros((512, 512), np.uint8)
    mask[100:300, 50:400] = 255
    data = writing.encode(Picture("a.png", mask), formats.PNG)
    assert len(data) < 2000
    np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(data))), mask)
