"""Every error has its code and a text that says what to do; none leaves a file, and none harms an existing one."""

import errno
import os
import resource
import socket
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from poisson_cli import errors
from tests.small_pictures import ALPHA, DESTINATION, GREY, SOURCE, encoded

CLONE = "clone source.png destination.png -m mask.png -o out.png".split()
FILL = "fill destination.png -m dest-mask.png -o out.png".split()
FLATTEN = "flatten destination.png -m dest-mask.png -o out.png".split()
RELIGHT = "relight destination.png -m dest-mask.png -o out.png".split()
RECOLOR = "recolor destination.png -m dest-mask.png -o out.png".split()
FOCUS = "focus destination.png -m dest-mask.png --amount 2 -o out.png".split()
HEAL = "heal destination.png --rect 20,14,9,8 -o out.png".split()
TILE = "tile destination.png -o out.png".split()
TONEMAP = "tonemap destination.png -o out.png".split()


def replaced(words: list[str], old: str, *new: str) -> list[str]:
    at = words.index(old)
    return [*words[:at], *new, *words[at + 1 :]]


def contents(folder: Path) -> dict[Path, bytes | None]:
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


USAGE = {
    "no command": ([], "Usage: poisson [OPTIONS] COMMAND"),
    "unknown command": (["frobnicate"], "No such command 'frobnicate'"),
    "hidden module": (["__init__"], "No such command '__init__'"),
    "no arguments": (["clone"], "Missing argument 'SOURCE'"),
    "no destination": (["mix", "source.png"], "Missing argument 'DESTINATION'"),
    "no output": (["fill", "grey.png", "-m", "dest-mask.png"], "Missing option '-o' / '--output'"),
    "no selection": (
        "fill grey.png -o out.png".split(),
        "No selection given: name a mask with -m, or draw one with --rect, --ellipse, --polygon or --lasso.",
    ),
    "only inverted": (
        "clone source.png grey.png -o out.png --invert-mask".split(),
        "No selection given: name a mask with -m",
    ),
    "one number": (
        [*CLONE, "--at", "12"],
        "'--at': '12' is not X,Y: whole numbers of pixels, for example 40,-12",
    ),
    "fraction": ([*CLONE, "--at", "1.5,2"], "'1.5,2' is not X,Y"),
    "long number": ([*CLONE, "--at", "1,12345678901"], "'1,12345678901' is not X,Y"),
    "three numbers": (
        [*FILL, "--rect", "1,2,3"],
        "'1,2,3' is not X,Y,W,H: whole numbers of pixels, for example 10,20,300,200",
    ),
    "no width": ([*FILL, "--rect", "1,2,0,5"], "'1,2,0,5' has no area: W and H must be at least 1"),
    "ellipse without width": ([*FILL, "--ellipse", "1,2,0,5"], "'--ellipse': '1,2,0,5' has no area"),
    "polygon of two": ([*FILL, "--polygon", "1,2 3,4"], "'--polygon': a polygon needs at least 3 points X,Y"),
    "lasso with a word": ([*FILL, "--lasso", "1,2 3,4 a,b"], "'--lasso': 'a,b' is not a point X,Y"),
    "subtracted from nothing": (
        "fill grey.png --subtract --rect 1,2,3,4 -o out.png".split(),
        "--subtract works on what was selected before it, and nothing was.",
    ),
    "intersected with nothing": (
        "fill grey.png --intersect -m dest-mask.png -o out.png".split(),
        "--intersect works on what was selected before it, and nothing was.",
    ),
    "nothing grown": (
        "fill grey.png --grow 3 -m dest-mask.png -o out.png".split(),
        "--grow works on what was selected before it, and nothing was.",
    ),
    "switch at the end": (
        [*FILL, "--subtract"],
        "--subtract has no effect: put it before the masks and shapes",
    ),
    "switch after switch": (
        [*FILL, "--intersect", "--grow", "1", "--add", "--rect", "1,2,3,4"],
        "--intersect has no effect: put it before the masks and shapes",
    ),
    "shrunk by nothing": ([*FILL, "--shrink", "0"], "'0' is not a whole number from 1"),
    "negative height": ([*FILL, "--rect", "1,2,5,-5"], "'1,2,5,-5' has no area"),
    "tolerance nan": ([*FILL, "--tolerance", "nan"], "'--tolerance': 'nan' is not a number greater than 0"),
    "tolerance inf": ([*FILL, "--tolerance", "inf"], "'inf' is not a number greater than 0"),
    "tolerance negative": ([*FILL, "--tolerance", "-1"], "'-1' is not a number greater than 0"),
    "tolerance zero": ([*FILL, "--tolerance", "0"], "'0' is not a number greater than 0"),
    "tolerance word": ([*FILL, "--tolerance", "fine"], "'fine' is not a number greater than 0"),
    "threshold 0": ([*FILL, "--mask-threshold", "0"], "'0' is not a whole number from 1 to 255"),
    "threshold 256": ([*FILL, "--mask-threshold", "256"], "'256' is not a whole number from 1 to 255"),
    "no iterations": ([*FILL, "--max-iterations", "0"], "'0' is not a whole number from 1"),
    "no threads": ([*FILL, "--threads", "0"], "'0' is not a whole number from 1"),
    "unknown solver": ([*FILL, "--solver", "jacobi"], "'jacobi' is not one of 'multigrid', 'sor'"),
    "unknown cycle": ([*FILL, "--cycle", "X"], "'X' is not one of 'V', 'F', 'W'"),
    "cycle of sor": ([*FILL, "--solver", "sor", "--cycle", "F"], "--cycle belongs to --solver multigrid"),
    "unknown gradients": ([*CLONE, "--gradients", "mixed"], "'mixed' is not one of 'source', 'average'"),
    "mask on nothing": ([*CLONE, "--mask-on", "output"], "'output' is not one of 'source', 'destination'"),
    "json beside the picture": (
        [*replaced(FILL, "out.png", "-"), "--format", "png", "--json"],
        "--json prints on the standard output, where the picture goes: name a file with -o.",
    ),
    "unknown format": ([*FILL, "--format", "gif"], "'gif' is not one of"),
    "unknown depth": ([*FILL, "--bit-depth", "12"], "'12' is not one of '8', '16', 'float'"),
    "quality 0": ([*FILL, "--quality", "0"], "'0' is not a whole number from 1 to 100"),
    "page 0": ([*FILL, "--page", "0"], "'0' is not a whole number from 1"),
    "quiet and verbose": ([*FILL, "-q", "-v"], "--quiet and --verbose contradict each other."),
    "placement of fill": ([*FILL, "--at", "1,2"], "No such option"),
    "edges found and given": (
        [*FLATTEN, "--edges", "grey.png", "--low", "3"],
        "--low is for finding edges; with --edges there is nothing to find.",
    ),
    "low above high": ([*FLATTEN, "--low", "13"], "--low is 13, above --high, which is 9."),
    "low negative": ([*FLATTEN, "--low", "-1"], "'-1' is not a number, 0 or greater"),
    "edges of no flattening": ([*CLONE, "--edges", "grey.png"], "--edges belongs to --flatten; add that."),
    "sigma of no flattening": ([*CLONE, "--focus", "2", "--sigma", "1"], "--sigma belongs to --flatten"),
    "alpha of no relighting": ([*CLONE, "--alpha", ".1"], "--alpha belongs to --relight; add that."),
    "beta nan": ([*RELIGHT, "--beta", "nan"], "'--beta': 'nan' is not a number"),
    "beta too large": ([*RELIGHT, "--beta", "1.5"], "'--beta': '1.5' is not a number from -1 to 1"),
    "channels in Lab": (
        [*RELIGHT, "--per-channel", "--space", "lab"],
        "--per-channel needs --space rgb or linear",
    ),
    "white too large": ([*TONEMAP, "--white", "101"], "'101' is not a number greater than 0 and at most 100"),
    "black above white": (
        [*TONEMAP, "--white", "20", "--black", "30"],
        "--black is 30, but must be less than --white",
    ),
    "alpha zero": ([*RELIGHT, "--alpha", "0"], "'0' is not a number greater than 0"),
    "two gains": (
        [*RECOLOR, "--gain", "1,2"],
        "'1,2' is not R,G,B: three numbers from 0 to 1000, for example",
    ),
    "negative gain": ([*RECOLOR, "--gain", "1,2,-1"], "'1,2,-1' is not R,G,B"),
    "hue as a word": ([*RECOLOR, "--hue", "red"], "'red' is not a number"),
    "saturation negative": ([*RECOLOR, "--saturation", "-1"], "'-1' is not a number from 0 to 1000"),
    "no amount": (FOCUS[:4] + FOCUS[6:], "Missing option '--amount'"),
    "amount negative": ([*FOCUS, "--amount", "-1"], "'-1' is not a number from 0 to 1000"),
    "focus negative": ([*CLONE, "--focus", "-1"], "'-1' is not a number from 0 to 1000"),
    "screen negative": ([*HEAL, "--screen", "-1"], "'-1' is not a number, 0 or greater"),
    "patch from nowhere": ([*HEAL, "--from", "left"], "'left' is not X,Y"),
    "reach of no search": (
        [*HEAL, "--from", "9,0", "--reach", "9"],
        "--reach is for the search; with --from nothing is searched for.",
    ),
    "no reach": ([*HEAL, "--reach", "0"], "'0' is not a whole number from 1"),
    "unknown space": ([*TILE, "--space", "hsv"], "'hsv' is not one of 'rgb', 'linear', 'lab'"),
    "unknown axis": ([*TILE, "--axis", "z"], "'z' is not one of 'both', 'x', 'y'"),
    "no pictures to tile": (["tile", "-o", "out.png"], "Missing argument 'IMAGE...'"),
    "two pictures, one output": (
        "tile destination.png grey.png -o out.png".split(),
        "2 pictures, but 1 x -o: give it once for each, or once with a folder that exists.",
    ),
    "one picture, two previews": (
        [*TILE, "--preview", "a.png", "--preview", "b.png"],
        "2 times --preview, but there are 1 pictures.",
    ),
    "selection of a whole picture": ([*TONEMAP, "-m", "dest-mask.png"], "No such option"),
    "null character": (replaced(FILL, "out.png", "a\0.png"), "a path cannot hold a null character"),
}

INPUT = {
    "missing source": (replaced(CLONE, "source.png", "no.png"), "no.png: no such file"),
    "missing destination": (replaced(CLONE, "destination.png", "no.png"), "no.png: no such file"),
    "missing mask": (replaced(CLONE, "mask.png", "no.png"), "no.png: no such file"),
    "second mask missing": ([*CLONE, "-m", "no.png"], "no.png: no such file"),
    "a file as folder": (replaced(FILL, "destination.png", "grey.png/a"), "cannot be read (Not a directory)"),
    "folder as picture": (replaced(CLONE, "source.png", "sub"), "sub: a folder, not a picture"),
    "device": (replaced(FILL, "destination.png", "/dev/zero"), "/dev/zero: not a file with a picture in it"),
    "text as picture": (
        replaced(CLONE, "source.png", "note.txt"),
        "note.txt: not a picture; PNG, JPEG, TIFF, BMP, WebP, GIF, PNM, PFM, Radiance HDR and OpenEXR are read",
    ),
    "empty file": (replaced(FILL, "destination.png", "empty.png"), "empty.png: the file is empty"),
    "photoshop": (
        replaced(FILL, "destination.png", "a.psd"),
        "a.psd: Photoshop is not read; convert it to one of PNG, JPEG, TIFF, BMP, WebP, GIF, PNM, PFM, ",
    ),
    "no such page": (
        [*replaced(FILL, "destination.png", "pages.tif"), "--page", "4"],
        "pages.tif: there is no page 4, it holds 3 pages",
    ),
    "page of one": ([*FILL, "--page", "2"], "--page 2: no input holds several pages or frames"),
    "too many pixels": (
        [*FILL, "--max-pixels", "1919"],
        "destination.png: its header claims 48x40 pixels, more than the 1,919 that are read; --max-pixels allows more",
    ),
    "without pixels": (replaced(FILL, "destination.png", "none.ppm"), "none.ppm: a picture of 0x7 pixels"),
    "two times stdin": (replaced(replaced(CLONE, "source.png", "-"), "mask.png", "-"), "standard input: "),
    "cut off": (
        replaced(CLONE, "source.png", "cut.png"),
        "cut.png: damaged PNG file, it cannot be decoded (",
    ),
    "cut off mask": (replaced(CLONE, "mask.png", "cut.png"), "cut.png: damaged PNG file"),
    "transparent source": (
        replaced(CLONE, "source.png", "alpha-source.png"),
        "the selection is empty: the source alpha-source.png is transparent, or next to it, wherever it is selected",
    ),
    "text as mask": (
        replaced(CLONE, "mask.png", "note.txt"),
        "note.txt: not a mask; pictures (PNG, JPEG, TIFF, BMP, WebP, GIF, PNM, PFM, Radiance HDR "
        "and OpenEXR), labelme and COCO JSON, and text files of "
        "x,y lines are read",
    ),
    "no alpha as mask": (
        replaced(CLONE, "mask.png", "mask.png:alpha"),
        "mask.png: the picture is grey and has no alpha channel",
    ),
    "unknown part": (
        replaced(CLONE, "mask.png", "mask.png:green"),
        "mask.png: the picture is grey; it has no colours to choose from",
    ),
    "unknown part of colour": (
        replaced(CLONE, "mask.png", "source.png:grün"),
        "source.png: a picture has no part called 'grün'; choose one of alpha, red, green, blue, index=0 to index=255",
    ),
    "part of a missing file": (replaced(CLONE, "mask.png", "no.png:alpha"), "no.png:alpha: no such file"),
    "polygon of letters": (
        replaced(CLONE, "mask.png", "bad.txt"),
        "bad.txt: '5,x' in line 3 is not a point X,Y",
    ),
    "broken json": (replaced(CLONE, "mask.png", "bad.json"), "bad.json: damaged JSON ("),
    "other json": (
        replaced(CLONE, "mask.png", "other.json"),
        'other.json: JSON that is neither labelme\'s nor COCO\'s: it has no "shapes" and no "annotations"',
    ),
    "colour into grey": (
        replaced(CLONE, "destination.png", "grey.png"),
        "source.png is RGB, but the destination grey.png is grey; convert one of them or add --monochrome",
    ),
    "colour into grey, mixed": (
        "mix source.png grey.png -m mask.png -o out.png".split(),
        "the destination grey.png is grey; convert one of them\n",
    ),
    "mask of the destination": (
        replaced(CLONE, "mask.png", "dest-mask.png"),
        "mask dest-mask.png is 48x40, but the source source.png is 30x24; it has the size of the destination: "
        "if it was drawn there, add --mask-on destination",
    ),
    "mask of the source": (
        [*CLONE, "--mask-on", "destination"],
        "mask mask.png is 30x24, but the destination destination.png is 48x40; it has the size of the source: "
        "if it was drawn there, add --mask-on source",
    ),
    "mask of neither": (
        replaced(CLONE, "mask.png", "odd-mask.png"),
        "mask odd-mask.png is 7x5, but the source source.png is 30x24; give it the size of the source, or that of "
        "the destination (48x40) and add --mask-on destination",
    ),
    "mask for fill": (
        replaced(FILL, "dest-mask.png", "mask.png"),
        "mask mask.png is 30x24, but the image destination.png is 48x40; a mask must have the size of the image",
    ),
    "empty mask": (
        replaced(FILL, "dest-mask.png", "black.png"),
        "the selection is empty: no pixel of a mask is set (white selects; --invert-mask turns it round)",
    ),
    "faint mask": (
        replaced(FILL, "dest-mask.png", "ones.png"),
        "the selection is empty: the brightest pixel of a mask is 1, below the threshold of 128 "
        "(lower it: --mask-threshold 1; or choose from a map of labels: :index=1)",
    ),
    "rectangle outside": (
        "fill grey.png --rect 48,0,5,5 -o out.png".split(),
        "the selection is empty: no --rect meets the image, which is 48x40",
    ),
    "everything inverted": (
        "fill grey.png --rect 0,0,48,40 --invert-mask -o out.png".split(),
        "the selection is empty: everything was selected, so --invert-mask leaves nothing",
    ),
    "missing edges": ([*FLATTEN, "--edges", "no.png"], "no.png: no such file"),
    "edges of another size": (
        [*FLATTEN, "--edges", "mask.png"],
        "edges mask.png are 30x24, but destination.png is 48x40; draw them on that picture",
    ),
    "edges of the destination": (
        [*CLONE, "--flatten", "--edges", "dest-mask.png"],
        "edges dest-mask.png are 48x40, but source.png is 30x24; draw them on that picture",
    ),
    "colours of grey": (replaced(RECOLOR, "destination.png", "grey.png"), "channel"),
    "grey in Lab": (
        [*replaced(FILL, "destination.png", "grey.png"), "--space", "lab"],
        "CIE-Lab needs red, green and blue",
    ),
    "patch outside": ([*HEAL, "--from", "40,0"], "a patch 9x8 at 60,14 leaves the picture"),
    "nowhere to search": (
        "heal destination.png --rect 4,4,40,32 -o out.png".split(),
        "no room for a patch",
    ),
    "tile outside": ([*TILE, "--rect", "30,0,30,30"], "rect"),
    "tile too thin": ([*TILE, "--rect", "0,0,2,30"], "3"),
    "maps of two sizes": (
        "tile destination.png source.png -o a.png -o b.png".split(),
        "destination.png is 48x40, but source.png is 30x24; pictures that belong together have one size",
    ),
    "second map missing": ("tile destination.png no.png -o a.png -o b.png".split(), "no.png: no such file"),
    "outside the destination": (
        [*CLONE, "--at", "48,0"],
        "the selection lies wholly outside: with its corner at 48,0 the source",
    ),
    "far outside": ([*CLONE, "--at", "-999999999,999999999"], "the selection lies wholly outside"),
}

OUTPUT = {
    "exists": (
        replaced(FILL, "out.png", "grey.png"),
        "grey.png: exists already; add --overwrite to replace it, or choose another name",
    ),
    "link to an existing file": (replaced(FILL, "out.png", "link.png"), "link.png: exists already"),
    "no such folder": (
        replaced(FILL, "out.png", "none/out.png"),
        "none/out.png: there is no folder {folder}/none; make it first",
    ),
    "file as folder": (replaced(FILL, "out.png", "grey.png/out.png"), "there is no folder {folder}/grey.png"),
    "folder": (
        [*replaced(FILL, "out.png", "sub.png"), "--overwrite"],
        "sub.png: a folder; name a file in it",
    ),
    "socket": ([*replaced(FILL, "out.png", "socket.png"), "--overwrite"], "socket.png: not a regular file"),
    "unknown format": (
        replaced(FILL, "out.png", "out.xyz"),
        "out.xyz: the ending .xyz does not tell a picture format; use .png, .jpg, .tif, .bmp, .webp",
    ),
    "no ending": (
        replaced(FILL, "out.png", "out"),
        "out: a name without an ending does not tell a picture format",
    ),
    "known elsewhere": (replaced(FILL, "out.png", "out.gif"), "out.gif: the ending .gif does not tell"),
    "long name": (replaced(FILL, "out.png", "n" * 300 + ".png"), "cannot be written (File name too long)"),
    "link in circles": (replaced(FILL, "out.png", "circle.png"), "circle.png: "),
    "stdout without format": (replaced(FILL, "out.png", "-"), "-: the standard output has no ending to tell"),
    "quality of a png": (
        [*FILL, "--quality", "80"],
        "out.png: PNG has no quality to choose; leave --quality to JPEG",
    ),
    "deep as jpeg": (
        "fill deep.png -m dest-mask.png -o out.jpg".split(),
        "out.jpg: JPEG cannot hold the depth of deep.png (16 bits per channel); PNG, TIFF and PNM can, or add "
        "--bit-depth 8 to convert it",
    ),
    "8 bits as hdr": (
        "fill grey.png -m dest-mask.png -o out.hdr".split(),
        "out.hdr: Radiance HDR cannot hold the depth of grey.png (8 bits per channel); PNG, JPEG, TIFF, BMP, WebP and "
        "PNM can, or add --bit-depth float to convert it",
    ),
    "alpha as jpeg": (
        "fill alpha.png -m dest-mask.png -o out.jpg".split(),
        "out.jpg: JPEG cannot hold the 4 channels of alpha.png (RGB with alpha, transparent in places); PNG, "
        "TIFF and WebP can",
    ),
    "grey alpha as bmp": (
        "fill grey-alpha.png -m dest-mask.png -o out.bmp".split(),
        "out.bmp: BMP cannot hold the 2 channels of grey-alpha.png (grey with alpha, transparent in "
        "places); PNG, TIFF and WebP can",
    ),
    "edges exist": ([*FLATTEN, "--show-edges", "grey.png"], "grey.png: exists already; add --overwrite"),
    "edges as the result": (
        [*FLATTEN, "--show-edges", "out.png"],
        "out.png: two outputs would go into this file; give each its own name",
    ),
    "preview without folder": ([*TILE, "--preview", "none/p.png"], "there is no folder {folder}/none"),
    "second tile exists": (
        "tile destination.png grey.png -o a.png -o mask.png".split(),
        "mask.png: exists already",
    ),
    "tiles beside their pictures": (
        "tile destination.png grey.png -o .".split(),
        "destination.png: exists already",
    ),
    "tiles of one name": (
        "tile destination.png ../{name}/destination.png -o sub".split(),
        "sub/destination.png: two outputs would go into this file",
    ),
    "alpha in the preview": (
        "tile alpha.png -o out.png --preview look.jpg".split(),
        "look.jpg: JPEG cannot hold the 4 channels of alpha.png",
    ),
    "too wide": (
        "fill wide.png --rect 5,0,9,1 -o out.webp".split(),
        "out.webp: WebP holds at most 16,383 pixels a side, and wide.png is 17000x1; choose another format",
    ),
}

NOT_CONVERGED = {
    "multigrid": ([*CLONE, "--max-iterations", "1"], "not converged: after 1 cycle"),
    "sor": ([*CLONE, "--solver", "sor", "--max-iterations", "3"], "not converged: after 3 sweeps"),
}

CASES = [
    pytest.param(words, code, text, id=name)
    for code, table in [(2, USAGE), (3, INPUT), (4, OUTPUT), (5, NOT_CONVERGED)]
    for name, (words, text) in table.items()
]


@pytest.fixture
def crowded(folder: Path) -> Path:
    """The folder of `small_pictures`, with many things more that can be in the way."""
    for name in ("sub", "sub.png"):
        (folder / name).mkdir()
    (folder / "link.png").symlink_to("grey.png")
    (folder / "circle.png").symlink_to("circle.png")
    with socket.socket(socket.AF_UNIX) as one:
        one.bind("socket.png")
    alpha = np.full(SOURCE.shape[:2], 127, np.uint8)
    files = {
        "note.txt": b"Dear diary,\n",
        "empty.png": b"",
        "a.psd": b"8BPS\0\1" + bytes(30),
        "none.ppm": b"P6\n0 7\n255\n",
        "pages.tif": encoded(
            GREY, "TIFF", save_all=True, append_images=[Image.fromarray(GREY), Image.fromarray(GREY)]
        ),
        "cut.png": encoded(SOURCE)[:-300],
        "deep.png": encoded(DESTINATION[:, :, 0].astype(np.uint16) * 257),
        "alpha-source.png": encoded(np.dstack((SOURCE, alpha))),
        "grey-alpha.png": encoded(ALPHA[:, :, 2:]),
        "odd-mask.png": encoded(np.full((5, 7), 255, np.uint8)),
        "black.png": encoded(np.zeros((40, 48), np.uint8)),
        "bad.txt": b"1,2\n3,4\n5,x\n",
        "bad.json": b'{"shapes": [',
        "other.json": b'{"features": []}',
        "ones.png": encoded(np.ones((40, 48), np.uint8)),
        "wide.png": encoded(np.zeros((1, 17000), np.uint8)),
    }
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return folder


@pytest.mark.parametrize(("words", "code", "text"), CASES)
def test_code_and_text(crowded, poisson, words, code, text):
    before = contents(crowded)
    ran = poisson(*(word.replace("{name}", crowded.name) for word in words))
    assert text.format(folder=crowded) in ran.err
    assert (ran.code, ran.out) == (code, "")
    assert contents(crowded) == before
    if code != errors.USAGE:
        assert ran.err.startswith("poisson: error: ")
        assert ran.err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "code", "text"), [case for case in CASES if case.values[1] in (errors.InputError.exit_code, 5)]
)
def test_an_existing_output_stays_whole(crowded, poisson, words, code, text):
    (crowded / "out.png").write_bytes(b"precious")
    before = contents(crowded)
    ran = poisson(*words, "--overwrite")
    assert (ran.code, text in ran.err) == (code, True)
    assert contents(crowded) == before


def test_a_folder_that_is_not_writable(folder, poisson, monkeypatch):
    (folder / "locked").mkdir(mode=0o555)
    # A superuser may write anywhere, so ask the mode of the folder instead of the system.
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).stat().st_mode >> 6 & mode == mode)
    ran = poisson(*replaced(FILL, "out.png", "locked/out.png"))
    assert (ran.code, ran.err) == (
        4,
        f"poisson: error: locked/out.png: the folder {folder}/locked is not writable\n",
    )
    assert not any((folder / "locked").iterdir())


@pytest.mark.parametrize("existing", [None, b"precious"])
def test_a_disk_that_is_full(folder, poisson, existing):
    """The system itself refuses to let the file grow."""
    if existing is not None:
        Path("out.png").write_bytes(existing)
    before = contents(folder)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        ran = poisson(*FILL, "--overwrite")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert (ran.code, ran.err) == (4, "poisson: error: out.png: cannot be written (File too large)\n")
    assert contents(folder) == before


def test_an_output_that_appears_during_the_work_is_left_alone(folder, poisson, monkeypatch):
    from poisson_cli import editing

    def fill(*arguments, **keywords):
        Path("out.png").write_bytes(b"someone else's")
        return real(*arguments, **keywords)

    real = editing.fill
    monkeypatch.setattr(editing, "fill", fill)
    ran = poisson(*FILL)
    assert (ran.code, ran.err) == (
        4,
        "poisson: error: out.png: appeared while we were at work; it is left alone\n",
    )
    assert Path("out.png").read_bytes() == b"someone else's"


def test_the_output_is_looked_at_before_any_work(folder, poisson, monkeypatch):
    from poisson_cli import editing

    monkeypatch.setattr(editing, "fill", lambda *_, **__: pytest.fail("worked in vain"))
    assert poisson("fill", "alpha.png", "-m", "dest-mask.png", "-o", "out.jpg").code == 4
    assert poisson(*replaced(FILL, "out.png", "out.xyz")).code == 4
    assert poisson(*replaced(FILL, "out.png", "grey.png")).code == 4
    assert poisson(*replaced(FILL, "out.png", "none/out.png")).code == 4


class Unforeseen(Exception):
    pass


def break_fill(monkeypatch, error: BaseException) -> None:
    from poisson_cli import editing

    def fill(*_, **__):
        raise error

    monkeypatch.setattr(editing, "fill", fill)


def test_a_bug_is_one_line_without_traceback(folder, poisson, monkeypatch):
    monkeypatch.delenv("POISSON_TRACEBACK", raising=False)
    break_fill(monkeypatch, Unforeseen("two\nlines"))
    ran = poisson(*FILL)
    assert (ran.code, ran.err) == (
        1,
        "poisson: error: unexpected Unforeseen: two lines; this is a bug, -v shows where it happened\n",
    )


@pytest.mark.parametrize("way", ["option", "environment"])
def test_a_bug_has_a_traceback_on_request(folder, poisson, monkeypatch, way):
    break_fill(monkeypatch, Unforeseen("oh"))
    monkeypatch.setenv("POISSON_TRACEBACK", "1" if way == "environment" else "")
    ran = poisson(*FILL, *(["-v"] if way == "option" else []))
    assert ran.code == 1
    assert "Traceback (most recent call last)" in ran.err
    assert ran.err.endswith("unexpected Unforeseen; this is a bug, please report it with the lines above\n")


def test_too_little_memory_is_one_line(folder, poisson, monkeypatch):
    break_fill(monkeypatch, MemoryError())
    assert poisson(*FILL) == (1, "", "poisson: error: not enough memory for pictures of this size\n")


def test_a_lost_reader_is_no_bug(folder, poisson, monkeypatch):
    break_fill(monkeypatch, BrokenPipeError(errno.EPIPE, "Broken pipe"))
    assert poisson(*FILL) == (141, "", "")


def test_every_exception_has_its_code():
    kinds = [kind for kind in errors.PoissonError.__subclasses__() if kind.__module__ == errors.__name__]
    assert {kind: kind.exit_code for kind in kinds} == {
        errors.InputError: 3,
        errors.OutputError: 4,
        errors.NotConverged: 5,
    }
    assert issubclass(errors.InputError, ValueError)
