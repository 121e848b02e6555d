"""Files that say which pixels: channels of pictures, annotations, corners of polygons."""

import base64
import io
import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from poisson_cli import images
from poisson_cli.errors import InputError
from poisson_cli.images import Picture
from poisson_cli.masks import Canvas, draw_polygon, read_mask
from poisson_cli.masks.source import locate
from poisson_cli.settings import MaskFile, Polygon
from tests import coco_oracle
from tests.small_pictures import DESTINATION, MASK, SOURCE, encoded

HEIGHT, WIDTH = MASK.shape


@pytest.fixture
def canvas(folder) -> Canvas:
    return Canvas("source", Picture("pictures/s.png", SOURCE), ("destination", Picture("d.png", DESTINATION)))


def drawn(canvas: Canvas, name: str, threshold: int = 128) -> np.ndarray:
    return read_mask(MaskFile(name), canvas, threshold).mask


def refusal(canvas: Canvas, name: str) -> str:
    with pytest.raises(InputError) as caught:
        drawn(canvas, name)
    return str(caught.value)


# Names and parts


@pytest.mark.parametrize(
    ("name", "path", "part"),
    [
        ("a.png", "a.png", None),
        ("a.png:alpha", "a.png", "alpha"),
        ("a.png:b:c/d//e", "a.png", "b:c/d//e"),
        ("a.png:", "a.png", ""),
        ("b:red", "b:red", None),
        ("b:red:red", "b:red", "red"),
        ("b:green", "b:green", None),
        ("none.png:alpha", "none.png:alpha", None),
        (":alpha", ":alpha", None),
        ("", ".", None),
        ("-", "-", None),
        ("-:alpha", "-", "alpha"),
    ],
)
def test_a_file_whose_own_name_has_the_colon_wins(tmp_path, monkeypatch, name, path, part):
    monkeypatch.chdir(tmp_path)
    for file in ("a.png", "b:red"):
        Path(file).touch()
    assert locate(MaskFile(name)) == (Path(path), part)


def test_a_name_that_is_no_unicode(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path(os.fsdecode(b"\xff.png")).touch()
    assert locate(MaskFile(os.fsdecode(b"\xff.png:red"))) == (Path(os.fsdecode(b"\xff.png")), "red")


@pytest.mark.parametrize(("part", "channel"), [("red", 0), ("green", 1), ("blue", 2), ("alpha", 3)])
@pytest.mark.parametrize("threshold", [1, 128, 255])
def test_channels(canvas, part, channel, threshold):
    pixels = np.random.default_rng(3).integers(0, 256, (*MASK.shape, 4), np.uint8)
    Path("p.png").write_bytes(encoded(pixels))
    np.testing.assert_array_equal(
        drawn(canvas, f"p.png:{part}", threshold), pixels[..., channel] >= threshold
    )


def test_an_alpha_that_is_the_same_everywhere_is_what_was_asked_for(canvas):
    Path("p.png").write_bytes(encoded(np.dstack((SOURCE, np.full(MASK.shape, 200, np.uint8)))))
    assert drawn(canvas, "p.png:alpha").all()
    assert not drawn(canvas, "p.png:alpha", 201).any()


@pytest.mark.parametrize("form", ["PNG", "TIFF", "BMP"])
@pytest.mark.parametrize("transparency", [None, 0])
def test_entries_of_a_palette(canvas, form, transparency):
    indices = np.random.default_rng(4).integers(0, 5, MASK.shape).astype(np.uint8)
    image = Image.fromarray(indices, "P")
    image.putpalette([0, 0, 0, 9, 9, 9, 9, 9, 9, 250, 0, 0, 0, 0, 0])
    keywords = {} if transparency is None or form != "PNG" else {"transparency": transparency}
    image.save("labels", form, **keywords)
    for index in range(6):
        np.testing.assert_array_equal(drawn(canvas, f"labels:index={index}"), indices == index)


def test_entries_of_a_palette_are_turned_upright(canvas):
    indices = np.where(MASK, 3, 1).astype(np.uint8)
    image = Image.fromarray(np.ascontiguousarray(np.rot90(indices, 1)), "P")
    image.putpalette(list(range(12)))
    exif = Image.Exif()
    exif[0x0112] = 6
    image.save("turned.png", exif=exif)
    np.testing.assert_array_equal(drawn(canvas, "turned.png:index=3"), MASK)


def test_values_of_a_grey_map_of_labels(canvas):
    labels = np.random.default_rng(4).integers(0, 20, MASK.shape).astype(np.uint8)
    Path("labels.png").write_bytes(encoded(labels))
    np.testing.assert_array_equal(drawn(canvas, "labels.png:index=7"), labels == 7)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("source.png:index=3", "source.png: a picture without a palette; its pixels have no index"),
        ("source.png:alpha", "source.png: the picture is RGB and has no alpha channel"),
        ("mask.png:red", "mask.png: the picture is grey; it has no colours to choose from"),
        (
            "mask.png:index=256",
            "mask.png: a picture has no part called 'index=256'; choose one of alpha, red,",
        ),
        ("mask.png:", "mask.png: a picture has no part called ''"),
        ("none.png:alpha", "none.png:alpha: no such file"),
    ],
)
def test_parts_that_are_not_there(canvas, name, text):
    assert refusal(canvas, name).startswith(text)


# Corners


@pytest.mark.parametrize(
    "text",
    [
        b"2.5,3\n20,4.25\n11,19\n",
        b"\xef\xbb\xbf# a triangle\r\n2.5, 3\r\n20 ,4.25\r\n\r\n  11,19  # the last\r\n",
        b"2.5,3 20,4.25 11,19",
        "2.5,3\n20,4.25\n11,19\n".encode("utf-16"),
        b"x,y\n2.5,3\n20,4.25\n11,19\n",
        b'"X", "Y"\r\n2.5,3\r\n20,4.25\r\n11,19\r\n',
    ],
)
def test_a_text_file_of_corners(canvas, text):
    Path("corners.txt").write_bytes(text)
    expected = draw_polygon(Polygon(((3, 2.5), (4.25, 20), (19, 11))), MASK.shape)
    np.testing.assert_array_equal(drawn(canvas, "corners.txt"), expected)


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"1,2\n3,4\n", "m: a polygon needs at least 3 points X,Y, not 2"),
        (b"1,2\n3,4\n5;6\n", "m: '5;6' in line 3 is not a point X,Y, for example 12,34.5"),
        (b"x,y\n1,2\n3,4\n5;6\n", "m: '5;6' in line 4 is not a point X,Y, for example 12,34.5"),
        (b"1,2\n3,4\n5,6 7\n", "m: '7' in line 3 is not a point X,Y"),
        (b"1,2\n3,4\n5," + b"9" * 500, "m: '5,99999999999999999999999999999999999...' in line 3 is not"),
        (b"", "m: the file is empty; pictures (PNG, "),
        (
            b"Dear diary,",
            "m: not a mask; pictures (PNG, JPEG, TIFF, BMP, WebP, GIF, PNM, PFM, Radiance HDR "
            "and OpenEXR), labelme and COCO JSON, and ",
        ),
        (b"\x00\xff\xfe", "m: not a mask; "),
        (b"8BPS", "m: Photoshop is not read; convert it to one of PNG"),
    ],
)
def test_what_is_no_mask(canvas, data, text):
    Path("m").write_bytes(data)
    assert refusal(canvas, "m").startswith(text)


def test_corners_have_no_parts(canvas):
    Path("corners.txt").write_text("1,1 9,1 9,9")
    assert refusal(canvas, "corners.txt:red") == (
        "corners.txt: a polygon has no parts to choose from, such as 'red'"
    )


# labelme


def base64_png(mask: np.ndarray) -> str:
    file = io.BytesIO()
    Image.fromarray(mask).save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode("ascii")


BITMAP = np.random.default_rng(8).random((4, 6)) < 0.5
LABELME = {
    "version": "5.5.0",
    "flags": {},
    "imagePath": "s.png",
    "imageData": None,
    "imageHeight": HEIGHT,
    "imageWidth": WIDTH,
    "shapes": [
        {"label": "wing", "points": [[2.5, 3], [20, 4.25], [11, 19]], "shape_type": "polygon"},
        {"label": "wing", "points": [[20, 15], [25.5, 20]], "shape_type": "rectangle"},
        {"label": "eye", "points": [[12, 9], [12, 12.2]], "shape_type": "circle"},
        {"label": "bits", "points": [[7, 2], [12, 5]], "shape_type": "mask", "mask": base64_png(BITMAP)},
        {"label": "old", "points": [[1, 1], [4, 1], [4, 5]]},
        {"label": "wire", "points": [[1, 1], [4, 1]], "shape_type": "line"},
    ],
}


def save(document: object, name: str = "a.json") -> None:
    Path(name).write_text(json.dumps(document))


def labelme_by_hand() -> dict[str, np.ndarray]:
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    bits = np.zeros(MASK.shape, bool)
    bits[2:6, 7:13] = BITMAP
    triangle = draw_polygon(Polygon(((3, 2.5), (4.25, 20), (19, 11))), MASK.shape)
    return {
        "wing": triangle | (y >= 15) & (y < 20) & (x >= 20) & (x < 25.5),
        "eye": (y - 9) ** 2 + (x - 12) ** 2 < 3.2**2,
        "bits": bits,
        "old": draw_polygon(Polygon(((1, 1), (1, 4), (5, 4))), MASK.shape),
    }


@pytest.mark.parametrize("label", ["wing", "eye", "bits", "old"])
def test_labels_of_labelme(canvas, label):
    save(LABELME)
    np.testing.assert_array_equal(drawn(canvas, f"a.json:{label}"), labelme_by_hand()[label])


def test_all_shapes_of_labelme(canvas):
    union = np.logical_or.reduce(list(labelme_by_hand().values()))
    save(LABELME)
    with images.asking() as asking:
        np.testing.assert_array_equal(drawn(canvas, "a.json"), union)
    assert asking.notices == [
        "left out, because only areas can be selected: 1 of the shapes, for one "
        'shape 6 ("wire") is a "line" of 2 points, which has no inside'
    ]


def changed(**keys: object) -> dict:
    """The polygon of labelme's example alone, with other values."""
    return {**LABELME, "shapes": [{**LABELME["shapes"][0], **keys}]}


@pytest.mark.parametrize(
    ("document", "name", "text"),
    [
        (
            LABELME,
            "a.json:tail",
            'no shape has the label "tail"; the labels are: "bits", "eye", "old", "wing", "w',
        ),
        (LABELME, "a.json:wire", 'shape 6 ("wire") is a "line" of 2 points, which has no inside'),
        (
            {"shapes": [{"label": "a", "shape_type": "point", "points": [[1, 2]]}] * 2},
            "a.json",
            'shape 2 ("a") is a "point" of 1 points, which has no inside',
        ),
        (
            {**LABELME, "imageWidth": 48, "imageHeight": 40},
            "a.json",
            "it is for a picture of 48x40, but the source ",
        ),
        (
            {**LABELME, "imageWidth": "48"},
            "a.json",
            'the document is for a picture whose height or width is "48"',
        ),
        ({"shapes": 3}, "a.json", '"shapes" is 3, not a list'),
        ({"shapes": [3]}, "a.json", "shape 1 is 3, not an object"),
        (changed(points=[[1, 2], [3, 4]]), "a.json", 'shape 1 ("wing") is a "polygon" of 2 points'),
        (changed(points=[[1, 2], [3, 4], [5]]), "a.json", 'shape 1 ("wing") has a point that is not x and y'),
        (changed(points=[[1, 2], [3, 4], [5, "6"]]), "a.json", 'shape 1 ("wing") has "6" where a coordinate'),
        (changed(points=[[1, 2], [3, 4], [5, 1e10]]), "a.json", 'shape 1 ("wing") has 10000000000.0 where'),
        (
            changed(shape_type="mask"),
            "a.json",
            'shape 1 ("wing") is a mask without its bitmap or its two corners',
        ),
        (
            changed(shape_type="mask", points=[[0, 0], [5, 9]], mask=base64_png(BITMAP)),
            "a.json",
            'the bitmap of shape 1 ("wing") is not a PNG of 6x10 pixels',
        ),
        (
            changed(shape_type="mask", points=[[26, 0], [31, 3]], mask=base64_png(BITMAP)),
            "a.json",
            'shape 1 ("wing") does not lie on the picture',
        ),
        (changed(shape_type="mask", points=[[0, 0], [5, 3]], mask="%"), "a.json", "the bitmap of shape 1"),
    ],
)
def test_what_is_wrong_with_labelme_is_said(canvas, document, name, text):
    save(document)
    assert refusal(canvas, name).startswith(f"a.json: {text}")


# COCO


RING = np.zeros(MASK.shape, bool)
RING[3:18, 5:25] = True
RING[8:12, 10:20] = False
SQUARE = [2, 3, 9, 3, 9, 11, 2, 11]
TRIANGLE = [15.2, 2.7, 28.9, 4.1, 20.3, 20.6]


def listed(mask: np.ndarray) -> dict:
    """Run lengths by the definition: a loop down the columns."""
    counts, last = [0], False
    for value in mask.T.ravel().tolist():
        if value != last:
            counts.append(0)
            last = value
        counts[-1] += 1
    return {"size": list(mask.shape), "counts": counts}


COCO = {
    "images": [
        {"id": 7, "file_name": "train/s.png", "height": HEIGHT, "width": WIDTH},
        {"id": 8, "file_name": "other.png", "height": 5, "width": 5},
    ],
    "categories": [{"id": 1, "name": "cat"}, {"id": 2, "name": "hot dog"}, {"id": 3, "name": "4"}],
    "annotations": [
        {"id": 1, "image_id": 7, "category_id": 1, "segmentation": [SQUARE, TRIANGLE]},
        {"id": 2, "image_id": 7, "category_id": 2, "segmentation": coco_oracle.encode(RING), "iscrowd": 1},
        {"id": 3, "image_id": 7, "category_id": 1, "segmentation": listed(MASK)},
        {"id": 4, "image_id": 8, "category_id": 1, "segmentation": [[0, 0, 5, 0, 5, 5]]},
        {"id": 5, "image_id": 7, "category_id": 3, "segmentation": [[20, 20, 22, 20, 22, 22, 20, 22]]},
    ],
}


def two_polygons() -> np.ndarray:
    pairs = (np.array(flat, float).reshape(-1, 2)[:, ::-1] for flat in (SQUARE, TRIANGLE))
    square, triangle = (draw_polygon(Polygon(tuple(map(tuple, pair.tolist()))), MASK.shape) for pair in pairs)
    return square | triangle


def small_square() -> np.ndarray:
    square = np.zeros(MASK.shape, bool)
    square[20:22, 20:22] = True
    return square


@pytest.mark.parametrize(
    ("part", "expected"),
    [
        (":1", two_polygons),
        (":2", lambda: RING),
        (":3", lambda: MASK),
        (":cat", lambda: two_polygons() | MASK),
        (":hot dog", lambda: RING),
        (":4", small_square),  # a category's name before an annotation's id
        ("", lambda: two_polygons() | MASK | RING | small_square()),
    ],
)
def test_annotations_of_coco(canvas, part, expected):
    save(COCO)
    np.testing.assert_array_equal(drawn(canvas, f"a.json{part}"), expected())


def test_polygons_that_overlap_are_joined(canvas):
    save({"annotations": [{"id": 1, "segmentation": [SQUARE, SQUARE]}]})
    np.testing.assert_array_equal(drawn(canvas, "a.json"), coco_oracle.draw([SQUARE, SQUARE], MASK.shape))


@pytest.mark.parametrize("density", [0.0, 0.02, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(10))
def test_run_lengths_are_cocos(folder, seed, density):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(1, 90, 2).tolist())
    mask = rng.random(shape) < density
    canvas = Canvas("image", Picture("s.png", np.zeros(shape, np.uint8)))
    for rle in (coco_oracle.encode(mask), listed(mask)):
        np.testing.assert_array_equal(coco_oracle.decode(rle), mask)
        save({"annotations": [{"id": 1, "segmentation": rle}]})
        np.testing.assert_array_equal(drawn(canvas, "a.json"), mask)


def rle(counts: object, size: object = (HEIGHT, WIDTH)) -> dict:
    return {"annotations": [{"id": 1, "segmentation": {"size": size, "counts": counts}}]}


def polygon(*flat: object) -> dict:
    return {"annotations": [{"id": 1, "segmentation": [list(flat)]}]}


@pytest.mark.parametrize(
    ("document", "name", "text"),
    [
        (
            COCO,
            "a.json:4 ",
            'nothing on this picture is a "4 "; the categories on it are: "4", "cat", "hot dog"',
        ),
        (COCO, "a.json:99", 'no category is called "99", and no annotation has that id'),
        (
            {**COCO, "categories": []},
            "a.json:4",
            "it is for a picture of 5x5, but the source pictures/s.png is 30x24",
        ),
        ({**COCO, "images": COCO["images"][1:]}, "a.json", "it is for a picture of 5x5, but the source "),
        (
            {**COCO, "images": [{"id": n, "file_name": f"{n}.png"} for n in range(5000)]},
            "a.json",
            "it is for 5,000 pictures, and none of them is called s.png; name an annotation by its id, or save",
        ),
        (
            {**COCO, "images": COCO["images"][:1] * 2},
            "a.json",
            "it is for 2 pictures, and more than one of them",
        ),
        ({"annotations": {}}, "a.json", "the list of each annotation is an object, not a list"),
        ({"annotations": [{"id": 1, "bbox": [1, 2, 3, 4]}]}, "a.json", "annotation 1 has no segmentation"),
        (polygon(1, 2, 3, 4), "a.json", "annotation 1 has a polygon of 4 numbers"),
        (polygon(1, 2, 3, 4, 5, 6, 7), "a.json", "annotation 1 has a polygon of 7 numbers"),
        (polygon(1, 2, 3, 4, 5, None), "a.json", "annotation 1 has null where a coordinate should be"),
        (polygon(1, 2, 3, 4, 5, float("nan")), "a.json", "annotation 1 has NaN where a coordinate should be"),
        (polygon(1, 2, 3, 4, 5, float("-inf")), "a.json", "annotation 1 has -Infinity where a coordinate"),
        (polygon(1, 2, 3, 4, 5, 10**400), "a.json", "annotation 1 has 10000000000000000000"),
        (polygon(1, 2, 3, 4, 5, True), "a.json", "annotation 1 has true where a coordinate should be"),
        (rle([700, 21]), "a.json", "the counts of annotation 1 do not add up to the 720 pixels of its size"),
        (rle([700, 19]), "a.json", "the counts of annotation 1 do not add up to the 720 pixels of its size"),
        (
            rle([700, -5, 25]),
            "a.json",
            "the counts of annotation 1 have -5 where a number of pixels should be",
        ),
        (
            rle([700, 20.0]),
            "a.json",
            "the counts of annotation 1 have 20.0 where a number of pixels should be",
        ),
        (rle([10**30]), "a.json", "the counts of annotation 1 have 1000000000000000000000000000000 where"),
        (rle("~"), "a.json", "the counts of annotation 1 are not compressed as COCO does it"),
        (rle("0P"), "a.json", "the counts of annotation 1 are not compressed as COCO does it"),
        (
            rle("P" * 20 + "0"),
            "a.json",
            "the counts of annotation 1 have a number that is larger than any picture",
        ),
        (rle("00O"), "a.json", "the counts of annotation 1 do not add up"),
        (rle(""), "a.json", "the counts of annotation 1 do not add up"),
        (rle("ħ"), "a.json", "the counts of annotation 1 are not compressed"),
        (rle(7), "a.json", "the counts of annotation 1 is 7, not a list"),
        (rle([720], [720]), "a.json", "the size of annotation 1 has 1 numbers, not a height and a width"),
        (rle([720], [24.0, 30]), "a.json", "annotation 1 is for a picture whose height or width is 24.0"),
        (
            rle([720], [40, 48]),
            "a.json",
            "annotation 1 is for a picture of 48x40, but the source pictures/s.png is ",
        ),
        (rle([720], [10**9, 10**9]), "a.json", "annotation 1 is for a picture of 1000000000x1000000000, but"),
    ],
)
def test_what_is_wrong_with_coco_is_said(canvas, document, name, text):
    save(document)
    assert refusal(canvas, name).startswith(f"a.json: {text}")


def test_the_way_out_of_another_size_is_that_of_pictures(canvas):
    save(rle([1920], [40, 48]))
    assert refusal(canvas, "a.json").endswith(
        "it has the size of the destination: if it was drawn there, add --mask-on destination"
    )


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("{", "damaged JSON ("),
        ('{"shapes": ' + "[" * 100_000 + "]" * 100_000 + "}", "JSON that is nested too deeply"),
        ('{"shapes": ' + "9" * 5000 + "}", "damaged JSON ("),
        ("[1, 2]", "the document is a list, not an object"),
        ("{}", "JSON that is neither labelme's nor COCO's"),
    ],
)
def test_what_is_no_json_of_ours(canvas, text, complaint):
    Path("a.json").write_text(text)
    assert refusal(canvas, "a.json").startswith(f"a.json: {complaint}")


def test_too_large_a_document_is_not_parsed(canvas, monkeypatch):
    monkeypatch.setattr("poisson_cli.masks.annotations.document.LARGEST", 10)
    Path("a.json").write_text('{"shapes":         []}')
    assert refusal(canvas, "a.json").startswith("a.json: more than 10 characters of JSON")
