"""OpenEXR, against its own library; and what is said where that is not installed."""

import io
import sys

import numpy as np
import OpenEXR
import pytest

from poisson_cli import images
from poisson_cli.errors import InputError, OutputError
from poisson_cli.images import Picture, formats, writing
from tests.kinds import FLOAT_GREY, FLOAT_RGB, HEIGHT, WIDTH

OPAQUE = np.ones((HEIGHT, WIDTH), np.float32)


def made(planes: dict[str, np.ndarray], **more: object) -> bytes:
    """A file by the library itself."""
    file = io.BytesIO()
    header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.scanlineimage, **more}
    OpenEXR.File(header, {name: np.ascontiguousarray(plane) for name, plane in planes.items()}).write(file)
    return file.getvalue()


def rgb(pixels: np.ndarray) -> dict[str, np.ndarray]:
    return {name: pixels[..., k] for k, name in enumerate("RGB")}


def found(data: bytes, names: str) -> np.ndarray:
    channels = OpenEXR.File(io.BytesIO(data), separate_channels=True).channels()
    assert set(channels) == set(names)
    return np.stack([channels[name].pixels for name in names], axis=2)


def refusal(data: bytes) -> str:
    with pytest.raises(InputError) as caught:
        images.decode(data, "a file")
    return str(caught.value)


def test_floats_and_halves_are_read_as_they_are():
    np.testing.assert_array_equal(images.decode(made(rgb(FLOAT_RGB)), "a").pixels, FLOAT_RGB)
    np.testing.assert_array_equal(images.decode(made({"Y": FLOAT_GREY}), "a").pixels, FLOAT_GREY)
    halves = FLOAT_RGB.astype(np.float16)
    picture = images.decode(made(rgb(halves)), "a")
    np.testing.assert_array_equal(picture.pixels, halves.astype(np.float32))
    assert (picture.depth, picture.alpha) == ("float", None)


@pytest.mark.parametrize("name", ["NO", "RLE", "ZIPS", "ZIP", "PIZ"])
@pytest.mark.parametrize("tiled", [False, True])
def test_compressions_and_tiles(name, tiled):
    more = {"compression": getattr(OpenEXR, f"{name}_COMPRESSION")}
    if tiled:
        more |= {"type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
    np.testing.assert_array_equal(images.decode(made(rgb(FLOAT_RGB), **more), "a").pixels, FLOAT_RGB)


def test_a_part_of_a_larger_picture_is_told():
    window = (np.array([-3, -4], np.int32), np.array([99, 98], np.int32))
    with images.asking() as asking:
        picture = images.decode(made(rgb(FLOAT_RGB), displayWindow=window), "a")
    np.testing.assert_array_equal(picture.pixels, FLOAT_RGB)
    assert asking.notices == [
        "a is part of a larger picture, or a larger one than is shown: the output says no longer which"
    ]
    with images.asking() as asking:
        images.decode(made(rgb(FLOAT_RGB)), "a")
    assert asking.notices == []


def test_its_library_reads_ours():
    np.testing.assert_array_equal(
        found(writing.encode(Picture("a", FLOAT_RGB), formats.EXR), "RGB"), FLOAT_RGB
    )
    grey = found(writing.encode(Picture("a", FLOAT_GREY), formats.EXR), "Y")
    np.testing.assert_array_equal(grey[..., 0], FLOAT_GREY)


def test_an_opaque_alpha_is_kept_and_any_other_refused():
    picture = images.decode(made({**rgb(FLOAT_RGB), "A": OPAQUE}), "a")
    np.testing.assert_array_equal(picture.alpha, OPAQUE)
    again = found(writing.encode(picture, formats.EXR), "RGBA")
    np.testing.assert_array_equal(again, np.dstack((FLOAT_RGB, OPAQUE)))
    assert "an OpenEXR that is transparent in places" in refusal(made({**rgb(FLOAT_RGB), "A": OPAQUE / 2}))
    with pytest.raises(OutputError, match="transparent in places"):
        writing.encode(Picture("a", FLOAT_RGB, OPAQUE / 2), formats.EXR)


def test_other_layouts_are_refused():
    assert "with the channels Z; save R, G and B, or Y" in refusal(made({"Z": FLOAT_GREY}))
    assert "of whole numbers" in refusal(made({"Y": np.ones((HEIGHT, WIDTH), np.uint32)}))


def test_the_size_is_asked_first():
    with images.asking(largest=HEIGHT * WIDTH - 1), pytest.raises(InputError, match="more than the 1,960"):
        images.decode(made(rgb(FLOAT_RGB)), "a")


def test_damaged_files_are_read_or_refused_in_one_line(capfd):
    data = made(rgb(FLOAT_RGB))
    rng = np.random.default_rng(3)
    damages = [data[: len(data) * part // 20] for part in range(1, 20)]
    for _ in range(20):
        damaged = bytearray(data)
        for place in rng.integers(4, 400, 3):
            damaged[place] ^= 1 << rng.integers(8)
        damages.append(bytes(damaged))
    refused = 0
    for damaged in damages:
        try:
            images.decode(damaged, "a file")
        except InputError as error:
            refused += 1
            assert "\n" not in str(error)
    assert refused > 10
    assert capfd.readouterr() == ("", "")


@pytest.fixture
def without_library(monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)


def test_without_the_library_the_extra_is_named(folder, poisson, without_library):
    (folder / "a.exr").write_bytes(b"\x76\x2f\x31\x01" + bytes(40))
    advice = "OpenEXR needs a further package: pip install 'poisson-cli[exr]'"
    ran = poisson("fill", "a.exr", "--rect", "1,1,9,9", "-o", "out.png")
    assert (ran.code, ran.err) == (3, f"poisson: error: a.exr: {advice}\n")
    ran = poisson("fill", "grey.png", "--rect", "1,1,9,9", "-o", "out.exr", "--bit-depth", "float")
    assert (ran.code, ran.err) == (4, f"poisson: error: out.exr: {advice}\n")
