"""Picture files: read without loss or refused by name; written whole or not at all."""

import io
import os
import re
import stat
import struct
import warnings
import zlib
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from poisson_cli import images
from poisson_cli.defaults import MAX_PIXELS
from poisson_cli.errors import InputError, OutputError
from poisson_cli.images import Picture, formats, reading, writing
from poisson_cli.images.metadata import Metadata
from poisson_cli.images.orientation import upright
from tests.small_pictures import ALPHA, GREY, SOURCE, encoded

RGB = SOURCE
GREY_ALPHA = ALPHA[:, :, 2:]
EXACT = [formats.PNG, formats.TIFF, formats.BMP, formats.WEBP]
EIGHT_BITS = [formats.PNG, formats.JPEG, formats.TIFF, formats.BMP, formats.WEBP, formats.PNM]
WITH_ALPHA = [formats.PNG, formats.TIFF, formats.WEBP]


def by_name(form: formats.Format) -> str:
    return form.name


def picture(pixels: np.ndarray, **more) -> Picture:
    return Picture("a.png", np.ascontiguousarray(pixels), **more)


def decode(data: bytes) -> Picture:
    """Decodes; a warning of the decoder would reach the user's terminal, so here it fails the test."""
    return reading.decode(data, "a file")


def refusal(data: bytes) -> str:
    with pytest.raises(InputError) as caught:
        decode(data)
    text = str(caught.value)
    assert text.startswith("a file: ")
    assert "\n" not in text
    return text


# ---- there and back ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(24, 30), (1, 1), (1, 2), (3, 1), (7, 4)])
@pytest.mark.parametrize("form", EXACT, ids=by_name)
def test_pixels_come_back_as_they_were(form, shape):
    height, width = shape
    back = decode(writing.encode(picture(RGB[:height, :width]), form))
    np.testing.assert_array_equal(back.pixels, RGB[:height, :width])
    assert (back.alpha, back.metadata.profile, back.palette) == (None, None, False)
    back = decode(writing.encode(picture(GREY[:height, :width]), form))
    expected = GREY[:height, :width]
    np.testing.assert_array_equal(back.pixels, expected if form.grey else np.dstack([expected] * 3))


@pytest.mark.parametrize("form", WITH_ALPHA, ids=by_name)
def test_alpha_and_the_colours_under_it_come_back_as_they_were(form):
    alpha = ALPHA[:, :, 3].copy()
    alpha[:20] = 0
    back = decode(writing.encode(picture(ALPHA[:, :, :3], alpha=alpha), form))
    np.testing.assert_array_equal(back.alpha, alpha)
    np.testing.assert_array_equal(back.pixels, ALPHA[:, :, :3])
    back = decode(writing.encode(picture(GREY, alpha=alpha), form))
    np.testing.assert_array_equal(back.alpha, alpha)
    np.testing.assert_array_equal(back.pixels, GREY if form.grey else np.dstack([GREY] * 3))


def test_jpeg_is_close_and_keeps_full_colour_resolution():
    stripes = np.zeros((32, 32, 3), np.uint8)
    stripes[:, ::2, 0] = 200
    data = writing.encode(picture(stripes), formats.JPEG)
    assert np.abs(decode(data).pixels.astype(int) - stripes).max() < 20
    grey = decode(writing.encode(picture(GREY), formats.JPEG))
    assert grey.pixels.shape == GREY.shape
    assert np.abs(grey.pixels.astype(int) - GREY).max() < 12


@pytest.mark.parametrize("form", [f for f in formats.WRITTEN if "profile" in f.carries], ids=by_name)
def test_a_profile_goes_along(form):
    metadata = Metadata(profile=b"x" * 16 + b"RGB " + b"y" * 5000)
    assert decode(writing.encode(picture(RGB, metadata=metadata), form)).metadata.profile == metadata.profile


def test_a_profile_that_cannot_go_along_is_known():
    assert not formats.BMP.can_hold_profile(b"x" * 16 + b"RGB ")
    assert not formats.WEBP.can_hold_profile(b"x" * 16 + b"GRAY")
    assert formats.WEBP.can_hold_profile(b"x" * 16 + b"RGB ")
    assert formats.PNG.can_hold_profile(b"x" * 16 + b"GRAY")
    grey = picture(GREY, metadata=Metadata(profile=b"x" * 16 + b"GRAY"))
    for form in (formats.WEBP, formats.BMP):
        assert decode(writing.encode(grey, form)).metadata.profile is None


# ---- what is read ------------------------------------------------------------------------------------------------


def png(depth: int, colour: int, rows: list[bytes], width: int, *extra: tuple[bytes, bytes]) -> bytes:
    """A PNG file made by hand: any depth and colour type."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width, len(rows), depth, colour, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    middle = b"".join(chunk(*one) for one in extra)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + middle + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")
    )


@pytest.mark.parametrize(
    ("depth", "row", "expected"),
    [(1, b"\x40", [0, 255]), (2, b"\x60", [85, 170]), (4, b"\x3f", [51, 255]), (8, b"\x07\xff", [7, 255])],
)
def test_grey_of_few_bits_fills_the_range(depth, row, expected):
    np.testing.assert_array_equal(decode(png(depth, 0, [row], 2)).pixels, [expected])


def tiff(array: np.ndarray, **settings) -> bytes:
    file = io.BytesIO()
    tifffile.imwrite(file, array, **settings)
    return file.getvalue()


@pytest.mark.parametrize(("byteorder", "bigtiff"), [("<", False), (">", False), ("<", True)])
@pytest.mark.parametrize("planar", ["contig", "separate"])
def test_kinds_of_tiff(byteorder, bigtiff, planar):
    stored = RGB if planar == "contig" else np.moveaxis(RGB, 2, 0)
    data = tiff(stored, byteorder=byteorder, bigtiff=bigtiff, planarconfig=planar, photometric="rgb")
    np.testing.assert_array_equal(decode(data).pixels, RGB)


@pytest.mark.parametrize("compression", ["tiff_lzw", "packbits", "tiff_adobe_deflate", "raw"])
def test_compressions_of_tiff(compression):
    np.testing.assert_array_equal(decode(encoded(RGB, "TIFF", compression=compression)).pixels, RGB)


def test_a_tiff_where_zero_is_white():
    np.testing.assert_array_equal(decode(tiff(255 - GREY, photometric="miniswhite")).pixels, GREY)


def test_a_one_bit_tiff_fills_the_range():
    bits = GREY > 128
    file = io.BytesIO()
    Image.fromarray(bits).save(file, "TIFF")
    np.testing.assert_array_equal(decode(file.getvalue()).pixels, np.where(bits, 255, 0))


@pytest.mark.parametrize("form", ["PNG", "TIFF", "BMP"])
def test_a_palette_is_applied(form):
    indexed = Image.fromarray(RGB).quantize(7)
    file = io.BytesIO()
    indexed.save(file, form)
    back = decode(file.getvalue())
    np.testing.assert_array_equal(back.pixels, np.asarray(indexed.convert("RGB")))
    assert back.palette


def test_a_palette_with_transparent_colours_gives_alpha():
    palette = (b"PLTE", bytes([10, 20, 30, 40, 50, 60]))
    back = decode(png(8, 3, [b"\0\1"], 2, palette, (b"tRNS", b"\x80")))
    np.testing.assert_array_equal(back.pixels, [[[10, 20, 30], [40, 50, 60]]])
    np.testing.assert_array_equal(back.alpha, [[128, 255]])


def test_one_transparent_colour_gives_alpha():
    back = decode(png(8, 2, [bytes([1, 2, 3, 4, 5, 6])], 2, (b"tRNS", struct.pack(">HHH", 1, 2, 3))))
    np.testing.assert_array_equal(back.pixels, [[[1, 2, 3], [4, 5, 6]]])
    np.testing.assert_array_equal(back.alpha, [[0, 255]])
    back = decode(png(8, 0, [bytes([1, 2])], 2, (b"tRNS", struct.pack(">H", 2))))
    np.testing.assert_array_equal(back.pixels, [[1, 2]])
    np.testing.assert_array_equal(back.alpha, [[255, 0]])


def test_the_first_picture_of_a_multi_picture_jpeg_is_the_picture():
    file = io.BytesIO()
    Image.fromarray(RGB).save(
        file, "MPO", save_all=True, append_images=[Image.fromarray(RGB[:4, :4])], quality=95
    )
    assert decode(file.getvalue()).shape == RGB.shape[:2]


def test_the_ending_plays_no_part(tmp_path):
    path = tmp_path / "really-a-png.jpg"
    path.write_bytes(encoded(RGB))
    np.testing.assert_array_equal(images.read(path).pixels, RGB)


ORIENTED = {
    1: RGB,
    2: RGB[:, ::-1],
    3: RGB[::-1, ::-1],
    4: RGB[::-1],
    5: RGB.transpose(1, 0, 2),
    6: np.rot90(RGB, 1),
    7: RGB[::-1, ::-1].transpose(1, 0, 2),
    8: np.rot90(RGB, -1),
}
"""How a camera stores the upright picture `RGB` under each tag: 6 is stored turned to the left, 8 to the right."""


@pytest.mark.parametrize("tag", ORIENTED)
@pytest.mark.parametrize("form", ["PNG", "TIFF", "WEBP"])
def test_pictures_are_turned_upright(form, tag):
    exif = Image.Exif()
    exif[0x0112] = tag
    settings = {"lossless": True} if form == "WEBP" else {}
    back = decode(encoded(np.ascontiguousarray(ORIENTED[tag]), form, exif=exif, **settings))
    np.testing.assert_array_equal(back.pixels, RGB)
    assert back.pixels.flags.c_contiguous


def test_a_jpeg_and_a_palette_are_turned_upright_too():
    exif = Image.Exif()
    exif[0x0112] = 6
    turned = np.ascontiguousarray(ORIENTED[6])
    jpeg = decode(encoded(turned, "JPEG", exif=exif, quality=95))
    assert np.abs(jpeg.pixels.astype(int) - RGB).mean() < 5
    indexed = Image.fromarray(turned).quantize(256)
    file = io.BytesIO()
    indexed.save(file, "PNG", exif=exif)
    expected = np.rot90(np.asarray(indexed.convert("RGB")), -1)
    np.testing.assert_array_equal(decode(file.getvalue()).pixels, expected)


@pytest.mark.parametrize("tag", [0, 9, 65535])
def test_an_unknown_orientation_is_none(tag):
    np.testing.assert_array_equal(upright(RGB, tag), RGB)


def test_the_tag_is_not_written_again():
    exif = Image.Exif()
    exif[0x0112] = 3
    first = decode(encoded(np.ascontiguousarray(ORIENTED[3]), exif=exif))
    np.testing.assert_array_equal(decode(writing.encode(first, formats.TIFF)).pixels, RGB)


# ---- what is refused ---------------------------------------------------------------------------------------------

DEEP = np.full((4, 5), 40000, np.uint16)


@pytest.mark.parametrize(
    ("array", "what"),
    [
        (DEEP.astype(np.uint32), "a 32-bit TIFF"),
        (DEEP.astype(np.float64), "a 64-bit floating-point TIFF"),
        (DEEP.astype(np.float16), "a 16-bit floating-point TIFF"),
    ],
)
def test_a_tiff_that_is_deeper_than_any_output_is_refused(array, what):
    assert refusal(tiff(array, photometric="minisblack")) == (
        f"a file: {what}; convert it to 8 or 16 bits per channel, or 32-bit floating point, first"
    )


def test_other_tiffs_are_refused():
    four = np.dstack((RGB, RGB[:, :, :1]))
    assert "a TIFF of signed or complex numbers" in refusal(
        tiff(GREY.astype(np.int8), photometric="minisblack")
    )
    assert "premultiplied alpha" in refusal(tiff(four, photometric="rgb", extrasamples=["assocalpha"]))
    assert "extra channels" in refusal(tiff(four, photometric="rgb", extrasamples=["unspecified"]))
    five = np.dstack((four, four[:, :, :1]))
    assert "extra channels" in refusal(
        tiff(five, photometric="rgb", extrasamples=["unassalpha", "unspecified"])
    )
    assert "a CMYK TIFF" in refusal(tiff(four, photometric="separated"))
    assert "a CIE-Lab TIFF" in refusal(encoded_mode("LAB", "TIFF"))


def encoded_mode(mode: str, form: str, **settings) -> bytes:
    file = io.BytesIO()
    Image.new(mode, (8, 6)).save(file, form, **settings)
    return file.getvalue()


@pytest.mark.parametrize(
    ("compression", "name"), [(50001, "WebP"), (34712, "JPEG 2000"), (34887, "LERC"), (4711, "method 4711")]
)
def test_a_tiff_that_is_packed_in_another_way_is_refused_by_its_name(compression, name):
    data = tiff(RGB, photometric="rgb")
    packed = data.replace(struct.pack("<HHII", 259, 3, 1, 1), struct.pack("<HHII", 259, 3, 1, compression))
    assert packed != data
    assert refusal(packed) == (
        f"a file: a TIFF compressed with {name}, which is not read; save it with LZW or Deflate first"
    )


def raw_file(kind: str) -> bytes:
    """As cameras write them: a preview, and what the sensor saw somewhere else."""
    if kind == "CR2":
        data = tiff(RGB, photometric="rgb")
        return data[:8] + b"CR\2\0" + data[8:]
    tags = [(50706, "B", 4, (1, 4, 0, 0), True)] if kind == "DNG" else []
    file = io.BytesIO()
    with tifffile.TiffWriter(file) as writer:
        writer.write(RGB, photometric="rgb", subfiletype=1, subifds=1, extratags=tags)
        writer.write(np.zeros((64, 64), np.uint16), photometric="cfa", subfiletype=0)
    return file.getvalue()


@pytest.mark.parametrize("compression", [None, "zlib", "lzma"])
@pytest.mark.parametrize(
    ("tag", "side"), [("TileWidth", 16_908_288), ("TileLength", 2**31), ("TileWidth", 300_000)]
)
def test_tiles_that_claim_far_more_than_the_picture_are_refused(compression, tag, side):
    data = bytearray(tiff(RGB.astype(np.uint16), photometric="rgb", tile=(16, 32), compression=compression))
    with tifffile.TiffFile(io.BytesIO(bytes(data))) as file:
        found = file.pages[0].tags[tag]
    data[found.offset + 2 : found.offset + 12] = struct.pack("<HII", 4, 1, side)
    assert refusal(bytes(data)) in (
        f"a file: damaged, its tiles are far larger than its {RGB.shape[1]}x{RGB.shape[0]} pixels",
        f"a file: damaged, {len(data):,} bytes cannot hold as many pixels as its header claims",
    ) or (side == 300_000 and compression == "lzma")


@pytest.mark.parametrize("kind", ["DNG", "NEF", "CR2"])
def test_the_preview_in_a_raw_file_is_not_taken_for_the_picture(kind):
    data = raw_file(kind)
    if kind == "CR2":  # the mark is in the way of the first directory, which Canon puts behind it
        data = data[:4] + struct.pack("<I", struct.unpack_from("<I", data, 4)[0] + 4) + data[8:]
    assert refusal(data) == "a file: a camera's raw file; develop it, and save a TIFF of 16 bits first"


@pytest.mark.parametrize("name", ["profile", "compressed text"])
def test_a_png_may_have_long_texts(name):
    long = bytes(range(256)) * 8192  # 2 MiB
    block = b"zTXt", b"plan\0\0" + zlib.compress(long)
    if name == "profile":
        block = b"iCCP", b"wide\0\0" + zlib.compress(long)
    data = encoded(RGB)
    body = struct.pack(">I", len(block[1])) + b"".join(block) + struct.pack(">I", zlib.crc32(b"".join(block)))
    picture = decode(data[:33] + body + data[33:])
    np.testing.assert_array_equal(picture.pixels, RGB)
    assert picture.metadata.profile == (long if name == "profile" else None)


def test_inks_are_refused():
    assert refusal(encoded_mode("CMYK", "JPEG")) == ("a file: a CMYK JPEG; convert it to RGB or grey first")


@pytest.mark.parametrize(
    ("start", "name"),
    [
        (b"8BPS\0\1", "Photoshop"),
        (b"%PDF-1.7", "PDF"),
        (b"\0\0\0\x20ftypheic", "HEIC"),
        (b"\0\0\0\x20ftypavif", "AVIF"),
        (b"\0\0\0\x20ftypisom", "a video"),
        (b"\0\0\0\x20ftypcrx ", "a camera's raw file"),
        (b"FUJIFILMCCD-RAW 0201", "a camera's raw file"),
        (b"\xff\x0a", "JPEG XL"),
        (b"PK\x03\x04", "ZIP archive"),
    ],
)
def test_other_formats_are_named(start, name):
    text = refusal(start + bytes(40))
    assert text == f"a file: {name} is not read; convert it to one of {formats.listed()}"


def test_what_is_no_picture_at_all():
    assert refusal(b"#!/bin/sh\n") == (
        "a file: not a picture; PNG, JPEG, TIFF, BMP, WebP, GIF, PNM, PFM, Radiance HDR and OpenEXR are read"
    )
    assert refusal(b"") == f"a file: the file is empty; {formats.listed()} are read"


@pytest.mark.parametrize("form", EIGHT_BITS, ids=by_name)
def test_a_truncated_file_is_refused(form):
    data = writing.encode(picture(RGB), form)
    for length in (len(data) // 2, len(data) * 4 // 5, 40, 20, 13):
        text = refusal(data[:length])
        assert "a file: damaged" in text or "not a picture" in text


@pytest.mark.parametrize("form", EIGHT_BITS, ids=by_name)
def test_a_damaged_file_is_read_or_refused_but_nothing_else(form):
    """Bytes changed at random: some fifteen types of exceptions come out of the decoders, none of them out of ours."""
    data = writing.encode(picture(RGB, metadata=Metadata(profile=b"p" * 200)), form)
    rng = np.random.default_rng(5)
    refused = 0
    for _ in range(150):
        damaged = bytearray(data)
        # Most of what can go wrong is in the header.
        reach = 300 if rng.integers(3) else len(data)
        for place in rng.integers(2, min(reach, len(data)), rng.integers(1, 6)):
            damaged[place] = rng.integers(256)
        try:
            decode(bytes(damaged))
        except InputError:
            refused += 1
    assert refused > 10


def huge_bmp() -> bytes:
    data = bytearray(encoded(RGB, "BMP"))
    data[18:26] = struct.pack("<ii", 200_000, 200_000)
    return bytes(data)


def huge_tiff() -> bytes:
    data = bytearray(tiff(GREY, photometric="minisblack"))
    with tifffile.TiffFile(io.BytesIO(bytes(data))) as file:
        places = [file.pages[0].tags[name].valueoffset for name in ("ImageWidth", "ImageLength")]
    for place in places:
        data[place : place + 4] = struct.pack("<I", 200_000)
    return bytes(data)


def huge_png() -> bytes:
    data = bytearray(png(8, 0, [b"\0"], 1))
    data[16:24] = struct.pack(">II", 200_000, 200_000)
    data[29:33] = struct.pack(">I", zlib.crc32(bytes(data[12:29])))
    return bytes(data)


@pytest.mark.parametrize("data", [huge_bmp(), huge_tiff(), huge_png()], ids=["BMP", "TIFF", "PNG"])
def test_a_size_that_makes_no_sense_is_refused_from_the_header(data):
    assert refusal(data) == (
        f"a file: its header claims 200000x200000 pixels, more than the {MAX_PIXELS:,} that are read; "
        "--max-pixels allows more"
    )


def test_a_large_picture_is_read_without_a_warning(monkeypatch):
    """Pillow's own limit must neither refuse nor warn, and must be back in force afterwards."""
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_array_equal(decode(encoded(RGB)).pixels, RGB)
    assert Image.MAX_IMAGE_PIXELS == 10


def test_warnings_about_metadata_do_not_reach_the_terminal():
    data = encoded(RGB, "JPEG", exif=b"Exif\0\0II*\0\x08\0\0\0\x05\0\x12\x01")
    with pytest.warns(UserWarning, match="Corrupt EXIF"), Image.open(io.BytesIO(data)) as image:
        image.getexif()
    assert decode(data).shape == RGB.shape[:2]


@pytest.mark.parametrize(
    ("start", "size", "text"),
    [
        (b"", 1 << 40, "not a picture; PNG, JPEG"),
        (b"8BPS", 1 << 40, "Photoshop is not read"),
        (encoded(RGB), 1 << 40, "1,099,511,627,776 bytes are more than 500,000,000 pixels take"),
        (encoded(RGB), 5 << 30, "damaged, most of its 5,368,709,120 bytes were never written"),
    ],
)
def test_a_file_that_is_mostly_nothing_is_refused_before_it_is_read(tmp_path, start, size, text):
    path = tmp_path / "a"
    path.write_bytes(start)
    os.truncate(path, size)
    with pytest.raises(InputError, match=re.escape(f"{path}: {text}")):
        images.read(path)


def test_a_large_file_is_read_from_its_beginning(tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "_UNKNOWN", 10)
    (tmp_path / "a").write_bytes(encoded(RGB))
    np.testing.assert_array_equal(images.read(tmp_path / "a").pixels, RGB)


def test_a_png_with_a_second_header_is_refused():
    data = png(8, 0, [b"\0\1"], 2)
    second = bytearray(data[8:33])
    second[8:16] = struct.pack(">II", 30_000, 30_000)
    second[21:25] = struct.pack(">I", zlib.crc32(bytes(second[4:21])))
    assert "damaged" in refusal(data[:33] + bytes(second) + data[33:])


def test_a_name_is_only_ever_a_file(tmp_path, monkeypatch):
    """The library under us would open the first three of these."""
    monkeypatch.chdir(tmp_path)
    for name in ("imageio:chelsea.png", "<screen>", "http://localhost/a.png", "a.zip/b.png"):
        with pytest.raises(InputError, match="no such file"):
            images.read(Path(name))


# ---- writing -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "form"),
    [
        ("a.png", formats.PNG),
        ("a.b.PNG", formats.PNG),
        ("a.jpg", formats.JPEG),
        ("a.JPEG", formats.JPEG),
        ("a.tif", formats.TIFF),
        ("a.tiff", formats.TIFF),
        ("a.bmp", formats.BMP),
        ("a.webp", formats.WEBP),
    ],
)
def test_the_ending_says_the_format(tmp_path, name, form):
    target = images.prepare(tmp_path / name, overwrite=False)
    assert target.form is form
    images.write(target, picture(RGB))
    assert formats.recognise((tmp_path / name).read_bytes()) is form


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(params=["nameless", "named"])
def temporary(request, monkeypatch):
    """The two ways to write a file that is not there before all of it is: not every system has the first."""
    if request.param == "named":
        monkeypatch.delattr(os, "O_TMPFILE")
    return request.param


@pytest.fixture
def when_forced(monkeypatch):
    """Have something done before a file or a folder, whichever `is_one` tells, is forced to the disk."""
    sync = os.fsync

    def listen(is_one, look) -> None:
        def look_and_sync(descriptor: int) -> None:
            if is_one(os.fstat(descriptor).st_mode):
                look()
            sync(descriptor)

        monkeypatch.setattr(os, "fsync", look_and_sync)

    return listen


@pytest.mark.parametrize("overwrite", [False, True])
def test_there_is_nothing_to_be_seen_before_all_is_on_the_disk(tmp_path, when_forced, temporary, overwrite):
    """So that SIGKILL, which nothing can tidy up after, leaves nothing either."""
    seen = []
    when_forced(stat.S_ISREG, lambda: seen.append([path.read_bytes() for path in tmp_path.iterdir()]))
    writing.save(b"new", tmp_path / "a", overwrite=overwrite)
    assert seen == [[] if temporary == "nameless" else [b"new"]]
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"new"}


@pytest.mark.usefixtures("temporary")
@pytest.mark.parametrize("overwrite", [False, True])
def test_the_name_is_forced_to_the_disk_as_well_now_or_later(tmp_path, monkeypatch, when_forced, overwrite):
    forced = []
    when_forced(stat.S_ISDIR, lambda: forced.append(sorted(path.name for path in tmp_path.iterdir())))
    monkeypatch.setattr(writing, "_later", False)  # to be what it was when the test is over
    writing.save(b"new", tmp_path / "a", overwrite=overwrite)
    assert forced == [["a"]]
    writing.settle_later()
    writing.save(b"new", tmp_path / "b", overwrite=overwrite)
    assert forced == [["a"]]
    writing.settle(tmp_path)
    assert forced == [["a"], ["a", "b"]]


@pytest.mark.usefixtures("temporary")
@pytest.mark.parametrize("umask", [0o022, 0o077, 0o002])
def test_a_new_file_has_the_mode_that_the_umask_leaves(tmp_path, umask):
    usual = os.umask(umask)
    try:
        writing.save(b"new", tmp_path / "a", overwrite=False)
    finally:
        os.umask(usual)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o666 & ~umask


@pytest.mark.usefixtures("temporary")
def test_a_replaced_file_keeps_its_mode(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"old")
    path.chmod(0o640)
    writing.save(b"new", path, overwrite=True)
    assert (path.read_bytes(), stat.S_IMODE(path.stat().st_mode)) == (b"new", 0o640)
    assert names(tmp_path) == ["a"]


@pytest.mark.usefixtures("temporary")
def test_a_replaced_file_keeps_its_owner(tmp_path, monkeypatch):
    """Whom it belongs to is for root to say, so what the system is asked is looked at."""
    path = tmp_path / "a"
    path.write_bytes(b"old")
    asked = []
    monkeypatch.setattr(os, "chown", lambda _, *whose: asked.append(whose))
    writing.save(b"new", path, overwrite=True)
    assert asked == [(path.stat().st_uid, path.stat().st_gid)]
    monkeypatch.setattr(os, "chown", failing(PermissionError(1, "Operation not permitted")))
    writing.save(b"newer", path, overwrite=True)
    assert path.read_bytes() == b"newer"


def failing(error):
    def fail(*_):
        raise error

    return fail


def test_a_link_is_followed_and_stays_a_link(tmp_path):
    (tmp_path / "folder").mkdir()
    real, link = tmp_path / "folder" / "real.png", tmp_path / "link.png"
    link.symlink_to(real)
    images.write(images.prepare(link, overwrite=False), picture(RGB))
    images.write(images.prepare(link, overwrite=True), picture(GREY))
    assert link.is_symlink()
    np.testing.assert_array_equal(images.read(real).pixels, GREY)
    assert names(tmp_path) == ["folder", "link.png"]
    assert names(tmp_path / "folder") == ["real.png"]


@pytest.mark.usefixtures("temporary")
@pytest.mark.parametrize(
    ("module", "step", "overwrite"),
    [
        (writing, "open", False),
        (writing, "open", True),
        (os, "chmod", True),
        (os, "fsync", False),
        (os, "fsync", True),
        (os, "link", False),
        (os, "replace", True),
    ],
)
@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), KeyboardInterrupt(), SystemExit(143)]
)
def test_nothing_is_left_whatever_happens(tmp_path, monkeypatch, module, step, overwrite, error):
    path = tmp_path / "a.png"
    if overwrite:
        path.write_bytes(b"old")

    def fail(*_, **__):
        raise error

    monkeypatch.setattr(module, step, fail, raising=False)
    if step == "link":  # without hard links there is another way; let that fail as well
        monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OutputError if isinstance(error, OSError) else type(error)):
        images.write(images.prepare(path, overwrite=overwrite), picture(RGB))
    monkeypatch.undo()
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == (
        {"a.png": b"old"} if overwrite else {}
    )


@pytest.mark.parametrize("name", ["a.jpg", "a.webp"])
@pytest.mark.parametrize("kind", [OSError, ValueError])
def test_an_encoder_that_fails_leaves_nothing(tmp_path, monkeypatch, name, kind):
    def fail(*_, **__):
        raise kind("encoding error 6")

    target = images.prepare(tmp_path / name, overwrite=False)
    monkeypatch.setattr(Image.Image, "save", fail)
    with pytest.raises(OutputError, match=rf"{name}: cannot be written \(encoding error 6\)"):
        images.write(target, picture(RGB))
    assert names(tmp_path) == []


def without_links(*_, **__):
    raise PermissionError(1, "Operation not permitted")


def test_a_file_system_without_hard_links(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "link", without_links)
    writing.save(b"new", tmp_path / "a", overwrite=False)
    assert (tmp_path / "a").read_bytes() == b"new"
    with pytest.raises(FileExistsError):
        writing.save(b"newer", tmp_path / "a", overwrite=False)
    assert (tmp_path / "a").read_bytes() == b"new"
    monkeypatch.setattr(os, "replace", without_links)
    with pytest.raises(PermissionError):
        writing.save(b"new", tmp_path / "b", overwrite=False)
    assert names(tmp_path) == ["a"]


@pytest.mark.usefixtures("temporary")
def test_a_file_is_never_replaced_without_leave(tmp_path):
    (tmp_path / "a").write_bytes(b"old")
    with pytest.raises(FileExistsError):
        writing.save(b"new", tmp_path / "a", overwrite=False)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"old"}
    assert names(tmp_path) == ["a"]


def test_what_a_format_cannot_hold_is_refused_by_the_writer_too(tmp_path):
    target = images.prepare(tmp_path / "a.jpg", overwrite=False)
    with pytest.raises(OutputError, match="JPEG cannot hold the 2 channels"):
        images.write(target, picture(GREY_ALPHA[:, :, 0], alpha=np.ascontiguousarray(GREY_ALPHA[:, :, 1])))
    assert names(tmp_path) == []


@pytest.mark.parametrize("name", ["a.jpg", "a.bmp", "a.ppm", "a.pfm"])
def test_an_alpha_that_is_opaque_everywhere_is_no_obstacle(folder, poisson, name):
    """Screenshots and animations have one; nothing is lost without it."""
    opaque = np.dstack((RGB, np.full_like(RGB[..., 0], 255)))
    Path("opaque.png").write_bytes(encoded(opaque))
    depth = ["--bit-depth", "float"] if name == "a.pfm" else []
    assert poisson("fill", "opaque.png", "--rect", "2,2,5,5", *depth, "-o", name).code == 0
    assert images.read(Path(name)).channels == 3
    assert poisson("fill", "opaque.png", "--rect", "2,2,5,5", "-o", "a.png").code == 0
    assert (images.read(Path("a.png")).alpha == 255).all()
    opaque[7, 8, 3] = 254
    Path("opaque.png").write_bytes(encoded(opaque))
    ran = poisson("fill", "opaque.png", "--rect", "2,2,5,5", *depth, "--overwrite", "-o", name)
    assert (ran.code, "(RGB with alpha, transparent in places)" in ran.err) == (4, True)


@pytest.mark.parametrize("form", [formats.JPEG, formats.WEBP], ids=by_name)
def test_quality_trades_size_for_exactness(tmp_path, form):
    sizes, errors = [], []
    for quality in (10, 60, 95, None):
        target = images.prepare(tmp_path / f"{quality}{form.extensions[0]}", quality=quality)
        images.write(target, picture(RGB))
        sizes.append(target.path.stat().st_size)
        errors.append(np.abs(images.read(target.path).pixels.astype(int) - RGB).mean())
    assert sizes[:3] == sorted(sizes[:3])
    assert errors[:3] == sorted(errors[:3], reverse=True)
    assert (sizes[3], errors[3]) == (sizes[2], errors[2]) if form is formats.JPEG else errors[3] == 0


def test_indices_are_read_as_they_are_stored():
    indexed = Image.fromarray(RGB).quantize(7)
    file = io.BytesIO()
    indexed.save(file, "PNG")
    np.testing.assert_array_equal(images.decode_indices(file.getvalue(), "a"), np.asarray(indexed))
    np.testing.assert_array_equal(images.decode_indices(encoded(GREY), "a"), GREY)
    with pytest.raises(InputError, match="a picture without a palette; its pixels have no index"):
        images.decode_indices(encoded(RGB), "a")
