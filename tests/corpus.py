"""Valid and damaged picture files, in every role that a file can have, in every command.

Whatever the bytes are, a command reads them or refuses them: exit code 0 or 3, nothing on stderr but its own words, no
traceback, no output on failure (5 where damage made floats so huge that no tolerance can be kept). The test suite tries
each damage in one role; ``python -m tests.corpus`` tries each in all of them, and more of them, and tells how long they
took and how much memory.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import multiprocessing
import os
import resource
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests import kinds
from tests.kinds import KINDS
from tests.mutations import mutated

ROLES = {
    "picture of fill": "fill {file} --rect 3,3,20,15",
    "mask of fill": "fill plain.png -m {file}",
    "inverted mask of fill": "fill grey.png -m {file} --invert-mask",
    "source of clone": "clone {file} plain.png --rect 3,3,20,15 --at 5,4",
    "destination of clone": "clone grey.png {file} --rect 3,3,20,15",
    "mask of clone": "clone grey.png plain.png -m {file} --mask-on destination",
    "source of mix": "mix {file} plain.png --rect 3,3,20,15 --bit-depth 16",
    "destination of mix": "mix grey.png {file} --rect 3,3,20,15",
    "mask of mix": "mix grey.png plain.png -m {file}",
    "picture of flatten": "flatten {file} --rect 3,3,20,15",
    "edges of flatten": "flatten plain.png --rect 3,3,20,15 --edges {file}",
    "picture of relight": "relight {file} --rect 3,3,20,15",
    "mask of relight": "relight plain.png -m {file}",
    "picture of recolor": "recolor {file} --rect 3,3,20,15 --hue 90",
    "mask of recolor": "recolor plain.png -m {file} --gain 1.2,1,.8 --space lab",
    "picture of focus": "focus {file} --rect 3,3,20,15 --amount 1.3",
    "picture of heal": "heal {file} --rect 9,9,5,4",
    "mask of heal": "heal plain.png -m {file} --intersect --rect 9,9,5,4 --from 3,2",
    "picture of tile": "tile {file}",
    "picture of tonemap": "tonemap {file}",
    "picture of mask": "mask {file} --rect 3,3,20,15 --over",
    "mask of mask": "mask plain.png -m {file} --grow 2",
}
COMMON = ["-o", "out.tif"]
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


class Outcome(NamedTuple):
    code: int
    err: str
    seconds: float


def prepare() -> None:
    """The pictures that are in order, in the current folder."""
    Path("plain.png").write_bytes(kinds.pillow(kinds.RGB, "PNG"))
    Path("grey.png").write_bytes(kinds.pillow(kinds.GREY, "PNG"))


def attempt(data: bytes, role: str) -> Outcome:
    """Give a file a role in a command, in the current folder; what the process writes past Python counts as well."""
    from poisson_cli.main import run

    Path("file").write_bytes(data)
    Path("out.tif").unlink(missing_ok=True)
    words = [*ROLES[role].format(file="file").split(), *COMMON]
    if words[0] != "mask":
        words += ["--max-iterations", "100"]
    said, kept = io.StringIO(), os.dup(2)
    with tempfile.TemporaryFile() as past:
        os.dup2(past.fileno(), 2)
        start = time.perf_counter()
        try:
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
                code = run(words)
        finally:
            seconds = time.perf_counter() - start
            os.dup2(kept, 2)
            os.close(kept)
        past.seek(0)
        return Outcome(code, said.getvalue() + past.read().decode(errors="replace"), seconds)


def complaint(outcome: Outcome) -> str | None:
    """What is wrong with an outcome, None if nothing."""
    # The first run on a machine says that it compiles the solver.
    lines = [line for line in outcome.err.splitlines() if not line.startswith("poisson: compil")]
    if outcome.code == 0:
        if not Path("out.tif").exists():
            return "no output"
        told = [line for line in lines if not line.startswith(("poisson: note: ", "poisson: hint: "))]
        strange = told[:-1]
        return f"strange words: {strange}" if strange else None
    if outcome.code == 5 and "not converged: " in outcome.err:
        return None  # damaged floats of 1e20 and the like, for which .0002 levels are out of reach, and it says so
    if outcome.code != 3:
        return f"exit code {outcome.code}: {outcome.err}"
    if len(lines) != 1 or not lines[0].startswith("poisson: error: "):
        return f"not one line: {outcome.err!r}"
    left = {path.name for path in Path().iterdir()} - {"plain.png", "grey.png", "file"}
    return f"left behind: {left}" if left else None


def truncated(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Cut off at every twentieth of the length."""
    for twentieth in range(20):
        yield f"cut at {twentieth}/20", data[: len(data) * twentieth // 20]


def flipped(data: bytes, count: int, seed: int = 0) -> Iterator[tuple[str, bytes]]:
    """Some bits the other way round; most of what can go wrong is in the first bytes.

    A PNG has its checksums put right in half of the cases, since else nobody looks behind them.
    """
    rng = np.random.default_rng([seed, zlib.crc32(data)])
    for number in range(count):
        damaged = bytearray(data)
        reach = len(data) if number % 3 == 0 else min(len(data), 400)
        for place in rng.integers(0, reach, rng.integers(1, 9)):
            damaged[place] ^= 1 << rng.integers(8)
        right = data.startswith(PNG_SIGNATURE) and number % 2
        yield f"flip {number}", checked(bytes(damaged)) if right else bytes(damaged)


def checked(data: bytes) -> bytes:
    """A PNG whose blocks have the checksums that belong to them, as far as there are blocks."""
    blocks, place = [PNG_SIGNATURE], 8
    while place + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, place)
        if place + 12 + length > len(data):
            break
        block = data[place + 4 : place + 8 + length]
        blocks.append(struct.pack(">I", length) + block + struct.pack(">I", zlib.crc32(block)))
        place += 12 + length
    return b"".join(blocks) + data[place:]


def _png(width: int, height: int, depth: int = 8, colour: int = 2) -> bytes:
    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    body = chunk(b"IDAT", zlib.compress(bytes(1000)))
    return PNG_SIGNATURE + chunk(b"IHDR", header) + body + chunk(b"IEND", b"")


def _tiff(width: int, height: int, compression: str | None = None) -> bytes:
    """A TIFF that claims a size, packed in one of Pillow's ways."""
    data = bytearray(kinds.pillow(kinds.RGB, "TIFF", compression=compression))
    import tifffile

    with tifffile.TiffFile(io.BytesIO(bytes(data))) as file:
        for name, number in (("ImageWidth", width), ("ImageLength", height), ("RowsPerStrip", height)):
            struct.pack_into("<HII", data, file.pages[0].tags[name].offset + 2, 4, 1, number)
    return bytes(data)


def _jpeg(width: int, height: int, progressive: bool) -> bytes:
    data = bytearray(kinds.pillow(kinds.RGB, "JPEG", progressive=progressive))
    place = data.index(b"\xff\xc2" if progressive else b"\xff\xc0")
    data[place + 5 : place + 9] = struct.pack(">HH", height, width)
    return bytes(data)


def _gif(width: int, height: int) -> bytes:
    data = bytearray(kinds.pillow(kinds.Image.fromarray(kinds.GREY), "GIF"))
    data[6:10] = struct.pack("<HH", width, height)
    return bytes(data)


def _gif_with_little_in_it(width: int, height: int) -> bytes:
    """A frame that is large enough to make the claim believable by the length of the file, if nobody looks at it."""
    data = bytearray(kinds.pillow(kinds.Image.fromarray(np.tile(kinds.GREY, (20, 20))), "GIF"))
    data[6:10] = struct.pack("<HH", width, height)
    return bytes(data)


def _animation(width: int, height: int) -> bytes:
    """A WebP of two small frames on a large canvas."""
    frames = [kinds.Image.fromarray(kinds.RGB[::step]) for step in (1, -1)]
    data = bytearray(kinds.pillow(frames[0], "WEBP", save_all=True, append_images=frames[1:], lossless=True))
    data[24:30] = (width - 1).to_bytes(3, "little") + (height - 1).to_bytes(3, "little")
    return bytes(data)


def _bmp(width: int, height: int) -> bytes:
    data = bytearray(kinds.pillow(kinds.RGB, "BMP"))
    data[18:26] = struct.pack("<ii", width, height)
    return bytes(data)


BOMBS = {
    f"{name}, {width}x{height}": make(width, height)
    for width, height in ((65_000, 65_000), (22_000, 22_000), (4_000_000, 100))
    for name, make in {
        "PNG": _png,
        "PNG of 16 bits": lambda w, h: _png(w, h, 16),
        "TIFF": _tiff,
        "TIFF, deflated": lambda w, h: _tiff(w, h, compression="tiff_adobe_deflate"),
        "TIFF, LZMA": lambda w, h: _tiff(w, h, compression="lzma"),
        "TIFF, ZSTD": lambda w, h: _tiff(w, h, compression="zstd"),
        "BMP": _bmp,
        "PPM": lambda w, h: f"P6\n{w} {h}\n255\n".encode() + bytes(50),
        "PGM in figures": lambda w, h: f"P2\n{w} {h}\n255\n1 2 3".encode(),
        "PFM": lambda w, h: f"PF\n{w} {h}\n-1\n".encode() + bytes(50),
        "HDR": lambda w, h: f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {h} +X {w}\n".encode() + bytes(50),
    }.items()
} | {
    f"{name}, {width}x{height}": make(width, height)
    for width, height in ((65_000, 65_000), (22_000, 22_000))
    for name, make in {
        "JPEG": lambda w, h: _jpeg(w, h, False),
        "progressive JPEG": lambda w, h: _jpeg(w, h, True),
        "GIF": _gif,
    }.items()
}
BOMBS |= {
    "GIF with little in it, 22000x22000": _gif_with_little_in_it(22_000, 22_000),
    "WebP with little in it, 16383x16383": _animation(16_383, 16_383),
    "TIFF, JPEG, 22000x22000": _tiff(22_000, 22_000, compression="jpeg"),
}
"""Files that claim far more pixels than they hold."""


def _sweep(name: str, flips: int, pipe: multiprocessing.connection.Connection) -> None:
    """All damages of one kind in all roles; tells how many there were and what was wrong."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        prepare()
        data = BOMBS[name] if name in BOMBS else KINDS[name]().data
        files = [("whole", data)]
        if name not in BOMBS:
            files += [*truncated(data), *flipped(data, flips)]
            files += [(f"mutation {seed}", mutated(name, data, seed)) for seed in range(flips)]
        worst, read, wrong = 0.0, 0, []
        for damage, file in files:
            for role in ROLES:
                outcome = attempt(file, role)
                worst = max(worst, outcome.seconds)
                read += outcome.code == 0
                problem = complaint(outcome)
                if problem is not None:
                    wrong.append(f"{name}, {damage}, as {role}: {problem}")
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        pipe.send((len(files) * len(ROLES), read, worst, memory, wrong))


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--flips", type=int, default=40, help="files with flipped bits, and as many mutations, of each kind"
    )
    parser.add_argument("--only", default="", help="kinds whose name begins with this")
    arguments = parser.parse_args()
    subprocess.run(
        [sys.executable, "-m", "poisson_cli", "warmup", "-q"], check=True
    )  # else the first run would tell
    spawn = multiprocessing.get_context("spawn")
    total = failures = 0
    for name in [*KINDS, *BOMBS]:
        if not name.startswith(arguments.only):
            continue
        ours, theirs = spawn.Pipe(duplex=False)
        process = spawn.Process(target=_sweep, args=(name, arguments.flips, theirs))
        process.start()
        theirs.close()
        try:
            runs, read, worst, memory, wrong = ours.recv()
        except EOFError:
            runs, read, worst, memory, wrong = 0, 0, 0.0, 0.0, [f"{name}: ended by signal or exception"]
        process.join()
        total += runs
        failures += len(wrong)
        print(f"{name}: {runs:,} runs, {read:,} read, slowest {worst:.2f} s, {memory:.2f} GiB", flush=True)
        for line in wrong:
            print(f"  WRONG {line}", flush=True)
    print(f"{total:,} runs, {failures} wrong")
    return bool(failures)


if __name__ == "__main__":
    raise SystemExit(main())
