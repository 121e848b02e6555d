"""What belongs to a picture goes along: orientation, profile, EXIF, XMP, resolution; and pages are chosen."""

import io
import struct

import numpy as np
import pytest
import tifffile
from PIL import Image, ImageCms

from poisson_cli import images
from poisson_cli.errors import InputError
from poisson_cli.images import Picture, exif, formats, profile, reading, writing
from poisson_cli.images.depth import convert
from poisson_cli.images.metadata import Metadata
from tests.kinds import DEEP_RGB, FLOAT_RGB, RGB, opencv, pillow, tiff

PROFILE = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
XMP = b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:Description tiff:Orientation="6" note="ours"/></x:xmpmeta>'
ARTIST, ORIENTATION, MAKE, EXPOSURE = 0x013B, 0x0112, 0x010F, 0x829A


def block(orientation: int, order: str = "<") -> bytes:
    """An EXIF block with an artist, an orientation, an exposure time, and a preview behind it, made by hand."""
    preview = b"\xff\xd8 a preview of what should not be seen \xff\xd9"
    artist = b"Ann Author\0\0"
    first, exposure, second = 8, 8 + 2 + 3 * 12 + 4, 8 + 2 + 3 * 12 + 4 + 2 + 12 + 4 + 8
    texts = second + 2 + 2 * 12 + 4
    pack = lambda form, *values: struct.pack(order + form, *values)  # noqa: E731
    return b"".join(
        (
            b"II" if order == "<" else b"MM",
            pack("HI", 42, first),
            pack("H", 3),
            pack("HHIHH", ORIENTATION, 3, 1, orientation, 0),
            pack("HHII", ARTIST, 2, len(artist) - 1, texts + len(preview)),
            pack("HHII", 0x8769, 4, 1, exposure),
            pack("I", second),
            pack("H", 1),
            pack("HHII", EXPOSURE, 5, 1, exposure + 2 + 12 + 4),
            pack("I", 0),
            pack("II", 1, 125),
            pack("H", 2),
            pack("HHII", 0x0201, 4, 1, texts),
            pack("HHII", 0x0202, 4, 1, len(preview)),
            pack("I", 0),
            preview,
            artist,
        )
    )


def stored(form: str) -> bytes:
    """A picture on its side with everything in it, written by Pillow."""
    mark = exif.MARK if form == "JPEG" else b""
    settings = {"exif": mark + block(6), "icc_profile": PROFILE, "dpi": (300, 150)}
    turned = np.ascontiguousarray(np.rot90(RGB, 1))
    if form == "PNG":
        from PIL.PngImagePlugin import PngInfo

        info = PngInfo()
        info.add_itxt("XML:com.adobe.xmp", XMP.decode())
        return pillow(turned, "PNG", pnginfo=info, **settings)
    if form == "WEBP":
        settings["lossless"] = True
    return pillow(turned, form, xmp=XMP, **settings)


def found(data: bytes) -> tuple[Image.Exif, dict]:
    """What Pillow finds in a file."""
    with Image.open(io.BytesIO(data)) as image:
        image.load()
        return image.getexif(), dict(image.info)


DEEP = np.ascontiguousarray(DEEP_RGB)


@pytest.mark.parametrize("output", ["PNG", "PNG of 16 bits", "JPEG", "TIFF", "TIFF of floats", "WebP"])
@pytest.mark.parametrize("form", ["PNG", "JPEG", "WEBP"])
def test_everything_goes_along_and_the_picture_is_upright(form, output):
    picture = reading.decode(stored(form), "a")
    assert picture.shape == RGB.shape[:2]
    if form != "JPEG":
        np.testing.assert_array_equal(picture.pixels, RGB)
    name, _, depth = output.partition(" of ")
    picture = picture.converted({"16 bits": "16", "floats": "float", "": "8"}[depth])[0]
    known = next(known for known in formats.WRITTEN if known.name == name)
    data = writing.encode(picture, known)
    if depth == "floats":
        with tifffile.TiffFile(io.BytesIO(data)) as file:
            tags = {tag.name: tag.value for tag in file.pages[0].tags.values()}
        assert (tags["Artist"], tags["Orientation"], tags["ExifTag"]["ExposureTime"]) == (
            "Ann Author",
            1,
            (1, 125),
        )
        assert (tags["InterColorProfile"], b'tiff:Orientation="1"' in tags["XMP"]) == (PROFILE, True)
        return
    tags, info = found(data)
    assert (tags[ARTIST], tags.get(ORIENTATION, 1)) == ("Ann Author", 1)
    assert float(tags.get_ifd(0x8769)[EXPOSURE]) == pytest.approx(1 / 125)
    assert info["icc_profile"] == PROFILE
    assert info["xmp"] == XMP.replace(b'"6"', b'"1"')
    assert b"should not be seen" not in data
    if form != "WEBP" and name != "WebP":
        assert info["dpi"] == pytest.approx((300, 150), abs=0.02)


@pytest.mark.parametrize("output", [formats.PNG, formats.JPEG, formats.WEBP, formats.TIFF])
@pytest.mark.parametrize("order", ["<", ">"])
def test_what_a_tiff_tells_goes_along(output, order):
    data = tiff(
        RGB,
        photometric="rgb",
        byteorder=order,
        resolution=(118.11, 118.11),
        resolutionunit="CENTIMETER",
        software="a scanner",
        iccprofile=PROFILE,
        extratags=[(ARTIST, 2, 0, "Ann Author", True), (700, 1, len(XMP), XMP, True)],
        metadata=None,
    )
    tags, info = found(writing.encode(reading.decode(data, "a"), output))
    assert (tags[ARTIST], tags[0x0131]) == ("Ann Author", "a scanner")
    assert info["icc_profile"] == PROFILE
    assert b"note=" in info["xmp"]
    if output is not formats.WEBP:
        assert info["dpi"][0] == pytest.approx(300, abs=0.51)


@pytest.mark.parametrize(
    ("settings", "stays"),
    [
        ({"description": "A bird", "metadata": None}, True),
        ({"photometric": "rgb"}, False),  # tifffile's own: the shape of the array
        ({"imagej": True}, False),
        ({"ome": True}, False),
    ],
)
def test_descriptions_of_a_layout_that_is_no_more_are_left_out(settings, stays):
    """A reader would go by them: ImageJ, for one, would look for all the pages behind the first."""
    data = tiff(np.stack((RGB, RGB)), **settings)
    with tifffile.TiffFile(io.BytesIO(data)) as file:
        before = file.pages[0].tags["ImageDescription"].value
    with tifffile.TiffFile(io.BytesIO(writing.encode(reading.decode(data, "a"), formats.TIFF))) as file:
        after = file.pages[0].tags.get("ImageDescription")
        assert file.asarray().shape == RGB.shape
    assert (after.value if after else None) == (before if stays else None)


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_block_is_changed_in_place(order):
    before = block(6, order)
    after = exif.of_upright(before)
    assert len(after) == len(before)
    assert (exif.orientation(before), exif.orientation(after)) == (6, 1)
    assert b"should not be seen" in before
    assert b"should not be seen" not in after
    assert exif.of_upright(after) == after


IPTC = b"\x1c\x02\x78\x00\x0bA captioned"  # record 2, data set 120, eleven bytes
WIDTH, HEIGHT = 0xA002, 0xA003


def captioned(data: bytes) -> bytes:
    """A JPEG with IPTC's records and, as Photoshop has them, a preview beside."""
    resources = b"".join(
        struct.pack(">4sHHI", b"8BIM", number, 0, len(body)) + body + bytes(len(body) % 2)
        for number, body in ((0x040C, b"\xff\xd8 a preview that should not be seen"), (0x0404, IPTC))
    )
    body = b"Photoshop 3.0\0" + resources
    return data[:2] + struct.pack(">HH", 0xFFED, len(body) + 2) + body + data[2:]


def test_captions_go_along():
    picture = reading.decode(captioned(stored("JPEG")), "a")
    again = writing.encode(picture, formats.JPEG)
    with Image.open(io.BytesIO(again)) as image:
        assert image.info["photoshop"] == {0x0404: IPTC}
    assert b"should not be seen" not in again
    as_tiff = writing.encode(picture, formats.TIFF)
    with tifffile.TiffFile(io.BytesIO(as_tiff)) as file:
        assert bytes(file.pages[0].tags[33723].value) == IPTC
    assert reading.decode(as_tiff, "a").metadata.iptc == IPTC
    assert writing.fitting(picture.metadata, formats.PNG)[1] == ("iptc",)


@pytest.mark.parametrize(
    "output", [formats.PNG, formats.JPEG, formats.WEBP, formats.TIFF], ids=lambda f: f.name
)
def test_the_size_that_is_told_is_that_of_the_output(output):
    """It was turned, and could have been cut out."""
    turned = np.ascontiguousarray(np.rot90(RGB, 1))
    tags = Image.Exif()
    tags[ORIENTATION] = 6
    tags.get_ifd(0x8769).update({WIDTH: turned.shape[1], HEIGHT: turned.shape[0]})
    xmp = (
        b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:Description exif:PixelXDimension="37" tiff:ImageLength=\'53\'>'
        b"<xmp:Thumbnails><rdf:Alt><rdf:li>bm90IHRvIGJlIHNlZW4=</rdf:li></rdf:Alt></xmp:Thumbnails>"
        b"<exif:PixelYDimension>53</exif:PixelYDimension></rdf:Description></x:xmpmeta>"
    )
    picture = reading.decode(pillow(turned, "JPEG", exif=tags.tobytes(), xmp=xmp), "a")
    assert picture.shape == RGB.shape[:2]
    told, info = found(writing.encode(picture, output))
    inner = told.get_ifd(0x8769)
    assert (inner[HEIGHT], inner[WIDTH]) == RGB.shape[:2]
    assert info["xmp"] == (
        b'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:Description exif:PixelXDimension="53" tiff:ImageLength=\'37\'>'
        b"<exif:PixelYDimension>37</exif:PixelYDimension></rdf:Description></x:xmpmeta>"
    )


def test_any_bytes_are_a_block_or_none():
    rng = np.random.default_rng(7)
    for _ in range(2000):
        damaged = bytearray(block(6))
        for place in rng.integers(4, len(damaged), 6):
            damaged[place] = rng.integers(256)
        short = bytes(damaged[: rng.integers(8, len(damaged) + 1)])
        assert len(exif.of_upright(short)) == len(short)
        assert len(exif.of_size(short, 3, 4)) == len(short)
        assert isinstance(exif.orientation(short), int)
    assert exif.bare(b"Exif\0\0") is None
    assert exif.bare(None) is None


def test_what_cannot_go_along_is_named():
    metadata = Metadata(profile=PROFILE, exif=block(1), xmp=XMP, dpi=(72.0, 72.0))
    assert writing.fitting(metadata, formats.PNG) == (metadata, ())
    assert writing.fitting(metadata, formats.BMP) == (Metadata(dpi=(72.0, 72.0)), ("profile", "exif", "xmp"))
    long = Metadata(exif=block(1) + bytes(70_000), xmp=XMP)
    assert writing.fitting(long, formats.JPEG) == (Metadata(xmp=XMP), ("exif",))


def test_profiles_are_told_apart_by_name():
    assert profile.called(None) == "sRGB"
    assert "sRGB" in profile.called(PROFILE)
    assert profile.same_colours(None, PROFILE)
    other = PROFILE.replace("sRGB".encode("utf-16-be"), "wide".encode("utf-16-be")).replace(b"sRGB", b"wide")
    assert not profile.same_colours(other, None)
    for length in range(0, len(PROFILE), 7):
        assert isinstance(profile.called(PROFILE[:length]), str)


def test_a_source_in_another_profile_is_reported(folder, poisson):
    other = PROFILE.replace("sRGB".encode("utf-16-be"), "wide".encode("utf-16-be")).replace(b"sRGB", b"wide")
    (folder / "wide.png").write_bytes(pillow(RGB, "PNG", icc_profile=other))
    ran = poisson("clone", "wide.png", "destination.png", "--rect", "3,3,9,9", "-o", "out.png")
    assert ran.code == 0
    assert ran.err.startswith("poisson: note: the colours of wide.png (wide")
    assert "are taken as if they were those of destination.png (sRGB)" in ran.err


# ---- depths ------------------------------------------------------------------------------------------------------


def test_every_value_survives_a_wider_depth():
    eight, sixteen = np.arange(256, dtype=np.uint8), np.arange(65536, dtype=np.uint16)
    for values, wider in ((eight, "16"), (eight, "float"), (sixteen, "float")):
        there = convert(values, wider).values
        back = convert(there, "8" if values is eight else "16").values
        np.testing.assert_array_equal(back, values)
    np.testing.assert_array_equal(convert(sixteen, "8").values, np.rint(sixteen / 257))


def test_floats_become_integers_and_losses_are_counted():
    odd = np.array([[-1, 0, 0.25, 1, 1.0001, np.nan, np.inf, -np.inf]], np.float32)
    values, clipped, undefined = convert(odd, "16")
    np.testing.assert_array_equal(values, [[0, 0, 16384, 65535, 65535, 0, 65535, 0]])
    assert (clipped, undefined) == (4, 1)


@pytest.mark.parametrize(("depth", "dtype"), [("8", np.uint8), ("16", np.uint16), ("float", np.float32)])
@pytest.mark.parametrize("source", ["8", "16", "float"])
def test_the_output_has_the_depth_asked_for(folder, poisson, depth, dtype, source):
    """Pixels outside the selection are those of the destination in its new depth."""
    pixels = {"8": RGB, "16": DEEP_RGB, "float": FLOAT_RGB}[source]
    (folder / "destination.tif").write_bytes(tiff(pixels, photometric="rgb"))
    words = [
        "clone",
        "grey.png",
        "destination.tif",
        "--rect",
        "3,3,9,9",
        "-o",
        "out.tif",
        "--bit-depth",
        depth,
    ]
    ran = poisson(*words)
    assert ran.code == 0, ran.err
    out = tifffile.imread("out.tif")
    assert out.dtype == dtype
    expected = convert(pixels, depth).values
    outside = np.ones(pixels.shape[:2], bool)
    outside[3:12, 3:12] = False
    np.testing.assert_array_equal(out[outside], expected[outside])
    assert ("destination.tif is converted from" in ran.err) == (depth != source)
    assert ("grey.png is converted from 8 bits per channel to" in ran.err) == (depth != "8")
    assert ("values outside 0 to 1 are clipped" in ran.err) == (source == "float" and depth != "float")


def test_a_deep_destination_brings_the_source_to_its_scale(folder, poisson):
    """The same edit as with a source that was deep from the beginning."""
    deep = np.ascontiguousarray(DEEP_RGB)
    (folder / "deep.tif").write_bytes(tiff(deep, photometric="rgb"))
    (folder / "shallow.png").write_bytes(pillow(RGB, "PNG"))
    (folder / "stretched.tif").write_bytes(tiff(RGB.astype(np.uint16) * 257, photometric="rgb"))
    for source in ("shallow.png", "stretched.tif"):
        assert poisson("clone", source, "deep.tif", "--rect", "3,3,30,20", "-o", f"{source}.tif").code == 0
    one, other = (tifffile.imread(f"{source}.tif") for source in ("shallow.png", "stretched.tif"))
    np.testing.assert_array_equal(one, other)


def test_numbers_that_are_none_are_reported():
    pixels = FLOAT_RGB.copy()
    pixels[3, 4], pixels[5, 6, 0] = np.nan, np.inf
    for data in (tiff(pixels, photometric="rgb"), opencv(".pfm", pixels)):
        with images.asking() as asking:
            images.decode(data, "a")
        assert asking.notices == ["a has 4 values that are NaN or infinite"]


def test_numbers_that_are_none_outside_the_selection_stay_as_they_are(folder, poisson):
    odd = FLOAT_RGB.copy()
    odd[0, 0] = (np.nan, np.inf, -1e30)
    (folder / "odd.tif").write_bytes(tiff(odd, photometric="rgb"))
    assert poisson("fill", "odd.tif", "--rect", "5,5,9,9", "-o", "out.tif").code == 0
    np.testing.assert_array_equal(tifffile.imread("out.tif")[0], odd[0])
    ran = poisson("fill", "odd.tif", "--rect", "1,1,9,9", "-o", "new.tif")
    assert (ran.code, ran.err.count("\n")) == (3, 1)
    assert "NaN, infinite or huge values in or beside the selection" in ran.err


# ---- pages -------------------------------------------------------------------------------------------------------


def pages(form: str) -> bytes:
    frames = [Image.fromarray(np.full((40, 48, 3), 60 * k, np.uint8)) for k in (1, 2, 3)]
    file = io.BytesIO()
    frames[0].save(
        file, form, save_all=True, append_images=frames[1:], **({"lossless": True} if form == "WEBP" else {})
    )
    return file.getvalue()


@pytest.mark.parametrize("form", ["TIFF", "GIF", "PNG", "WEBP"])
def test_pages_are_chosen(folder, poisson, form):
    (folder / "many").write_bytes(pages(form))
    ran = poisson("fill", "many", "--rect", "5,5,9,9", "-o", "first.png")
    kind = "pages" if form == "TIFF" else "frames"
    assert ran.err.startswith(
        f"poisson: note: many holds 3 {kind}: the first one is used; --page N chooses another\n"
    )
    assert poisson("fill", "many", "--rect", "5,5,9,9", "-o", "third.png", "--page", "3").err.count("\n") == 1
    levels = [int(np.asarray(Image.open(name))[0, 0, 0]) for name in ("first.png", "third.png")]
    assert levels == [60, 180]


def test_reduced_copies_are_no_pages(folder):
    file = io.BytesIO()
    with tifffile.TiffWriter(file) as writer:
        writer.write(RGB, photometric="rgb", subfiletype=0)
        writer.write(RGB[::2, ::2].copy(), photometric="rgb", subfiletype=1)
    with images.asking() as asking:
        np.testing.assert_array_equal(images.decode(file.getvalue(), "a").pixels, RGB)
    assert asking.notices == []


def test_premultiplied_colours_are_refused():
    four = np.dstack((DEEP_RGB, np.full_like(DEEP_RGB[..., :1], 65535)))
    four[5, 7, 3] = 65534
    with pytest.raises(InputError, match="premultiplied alpha, transparent in places"):
        images.decode(tiff(four, photometric="rgb", extrasamples=["assocalpha"]), "a")


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1)])
@pytest.mark.parametrize(
    "form", [known for known in formats.WRITTEN if known.codec != "exr"], ids=lambda f: f.name
)
def test_the_smallest_pictures(shape, form):
    pixels = convert(np.full((*shape, 3), 64, np.uint8), form.depths[0]).values
    back = images.decode(writing.encode(Picture("a", pixels), form), "a")
    assert back.pixels.shape == pixels.shape
    assert np.abs(back.pixels.astype(float) - pixels).max() <= {"Radiance HDR": 0.002, "JPEG": 3}.get(
        form.name, 0
    )
