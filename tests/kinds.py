"""Kinds of picture files, each made by a program that is not ours; what a reader must find in them.

Writers: Pillow, tifffile, OpenCV, OpenEXR, and a few lines of `struct` where none of them can.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import OpenEXR
import tifffile
from PIL import Image

HEIGHT, WIDTH = 37, 53
RNG = np.random.default_rng(6)
RGB = RNG.integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)
RGBA = RNG.integers(0, 256, (HEIGHT, WIDTH, 4), dtype=np.uint8)
GREY = RGB[..., 0].copy()
GREY_ALPHA = RGBA[..., 2:].copy()
DEEP_RGB = RNG.integers(0, 65536, (HEIGHT, WIDTH, 3), dtype=np.uint16)
DEEP_RGBA = RNG.integers(0, 65536, (HEIGHT, WIDTH, 4), dtype=np.uint16)
DEEP_GREY = DEEP_RGB[..., 0].copy()
DEEP_GREY_ALPHA = DEEP_RGBA[..., 2:].copy()
FLOAT_RGB = RNG.normal(0.5, 2.0, (HEIGHT, WIDTH, 3)).astype(np.float32)
FLOAT_RGBA = np.dstack((FLOAT_RGB, RNG.random((HEIGHT, WIDTH), np.float32)))
FLOAT_GREY = FLOAT_RGB[..., 0].copy()


@dataclass(frozen=True)
class Kind:
    """One kind of file.

    Parameters
    ----------
    data
        The file.
    pixels
        What is in it, upright, (H, W) or (H, W, 3).
    alpha
        Its opacity, None if it has none.
    close
        Largest difference allowed, for lossy formats.
    """

    data: bytes
    pixels: np.ndarray
    alpha: np.ndarray | None = None
    close: float = 0


def pillow(pixels: np.ndarray, form: str, **settings: Any) -> bytes:
    file = io.BytesIO()
    image = pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)
    image.save(file, form, **settings)
    return file.getvalue()


def tiff(pixels: np.ndarray, **settings: Any) -> bytes:
    file = io.BytesIO()
    tifffile.imwrite(file, pixels, **settings)
    return file.getvalue()


def opencv(ending: str, pixels: np.ndarray, *settings: int) -> bytes:
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    order = {1: ..., 3: (..., [2, 1, 0]), 4: (..., [2, 1, 0, 3])}[channels]
    swapped = np.ascontiguousarray(pixels[order])
    done, data = cv2.imencode(ending, swapped, list(settings))
    assert done
    return data.tobytes()


def png(
    depth: int,
    colour: int,
    rows: np.ndarray,
    *extra: tuple[bytes, bytes],
    interlaced: bool = False,
    width: int | None = None,
) -> bytes:
    """A PNG by hand: `rows` are the bytes of each row, which say how many pixels there are unless `width` does."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    samples = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    width = width or rows.shape[1] * 8 // (depth * samples)
    header = struct.pack(">IIBBBBB", width, rows.shape[0], depth, colour, 0, 0, interlaced)
    if interlaced:
        step = depth * samples // 8
        whole = rows.reshape(rows.shape[0], width, step)
        passes = [
            (0, 0, 8, 8),
            (0, 4, 8, 8),
            (4, 0, 8, 4),
            (0, 2, 4, 4),
            (2, 0, 4, 2),
            (0, 1, 2, 2),
            (1, 0, 2, 1),
        ]
        parts = [whole[top::down, left::across] for top, left, down, across in passes]
        packed = b"".join(b"\0" + row.tobytes() for part in parts if part.size for row in part)
    else:
        packed = b"".join(b"\0" + row.tobytes() for row in rows)
    blocks = [(b"IHDR", header), *extra, (b"IDAT", zlib.compress(packed)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*block) for block in blocks)


def big_endian(pixels: np.ndarray) -> np.ndarray:
    """The bytes of each row of 16-bit numbers, as PNG has them."""
    return pixels.astype(">u2").reshape(pixels.shape[0], -1).view(np.uint8)


def openexr(pixels: np.ndarray) -> bytes:
    names = ["Y"] if pixels.ndim == 2 else ["R", "G", "B", "A"][: pixels.shape[2]]
    planes = np.atleast_3d(pixels)
    file = io.BytesIO()
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    channels = {name: np.ascontiguousarray(planes[..., k]) for k, name in enumerate(names)}
    OpenEXR.File(header, channels).write(file)
    return file.getvalue()


def netpbm(kind: str, most: int | None, body: bytes, comment: str = "") -> bytes:
    size = f"{WIDTH} {HEIGHT}\n"
    return f"{kind}\n{comment}{size}{'' if most is None else f'{most}' + chr(10)}".encode() + body


def figures(pixels: np.ndarray) -> bytes:
    return " ".join(map(str, pixels.reshape(-1))).encode() + b"\n"


def pfm(pixels: np.ndarray, order: str) -> bytes:
    kind = "Pf" if pixels.ndim == 2 else "PF"
    scale = "-1.0" if order == "<" else "1.0"
    return f"{kind}\n{WIDTH} {HEIGHT}\n{scale}\n".encode() + pixels[::-1].astype(f"{order}f4").tobytes()


def scaled(pixels: np.ndarray, most: int, full: int) -> np.ndarray:
    return np.rint(pixels.astype(float) * full / most).astype(np.uint8 if full == 255 else np.uint16)


def _palette() -> Kind:
    indexed = Image.fromarray(RGB).quantize(50)
    return Kind(pillow(indexed, "PNG"), np.asarray(indexed.convert("RGB")))


def _gif(**settings: Any) -> Kind:
    indexed = Image.fromarray(RGB).quantize(50)
    return Kind(pillow(indexed, "GIF", **settings), np.asarray(indexed.convert("RGB")))


def _transparent_palette() -> Kind:
    colours = RNG.integers(0, 256, (4, 3), dtype=np.uint8)
    opacity = np.array([0, 100, 255, 255], np.uint8)
    index = RNG.integers(0, 4, (HEIGHT, WIDTH), dtype=np.uint8)
    data = png(8, 3, index, (b"PLTE", colours.tobytes()), (b"tRNS", opacity[:2].tobytes()))
    return Kind(data, colours[index], opacity[index])


def _transparent_colour() -> Kind:
    row = big_endian(DEEP_RGB)
    colour = DEEP_RGB[5, 7]
    alpha = np.where((colour == DEEP_RGB).all(axis=2), 0, 65535).astype(np.uint16)
    return Kind(png(16, 2, row, (b"tRNS", colour.astype(">u2").tobytes())), DEEP_RGB, alpha)


def _transparent_grey() -> Kind:
    value = DEEP_GREY[5, 7]
    alpha = np.where(value == DEEP_GREY, 0, 65535).astype(np.uint16)
    data = png(16, 0, big_endian(DEEP_GREY), (b"tRNS", struct.pack(">H", value)))
    return Kind(data, DEEP_GREY, alpha)


def _jpeg(pixels: np.ndarray, **settings: Any) -> Kind:
    data = pillow(pixels, "JPEG", quality=97, **settings)
    return Kind(data, cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)[..., ::-1] if pixels.ndim == 3
                else cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED), close=3)  # fmt: skip


def _hdr(pixels: np.ndarray) -> Kind:
    data = opencv(".hdr", np.abs(pixels))
    return Kind(data, cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)[..., ::-1])


def _flat_hdr() -> Kind:
    rgbe = RNG.integers(128, 256, (HEIGHT, WIDTH, 4), dtype=np.uint8)
    rgbe[..., 3] = RNG.integers(120, 140, (HEIGHT, WIDTH))
    data = f"#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y {HEIGHT} +X {WIDTH}\n".encode() + rgbe.tobytes()
    return Kind(data, (rgbe[..., :3] * 2.0 ** (rgbe[..., 3:].astype(float) - 136)).astype(np.float32))


def _bits() -> np.ndarray:
    return np.where(GREY > 128, 255, 0).astype(np.uint8)


def planar(pixels: np.ndarray) -> np.ndarray:
    return np.moveaxis(pixels, 2, 0).copy()


STRAIGHT = {"extrasamples": ["unassalpha"]}


def low_bits(pixels: np.ndarray, bits: int) -> np.ndarray:
    """The bytes of each row of numbers of fewer than eight bits."""
    ones = pixels[..., np.newaxis] >> np.arange(bits - 1, -1, -1) & 1
    return np.packbits(ones.reshape(pixels.shape[0], -1).astype(np.uint8), axis=1)


def _grey_of_few_bits(bits: int) -> Kind:
    """A PNG of which one value is transparent."""
    most = (1 << bits) - 1
    pixels = GREY & most
    value = int(pixels[5, 7])
    data = png(bits, 0, low_bits(pixels, bits), (b"tRNS", struct.pack(">H", value)), width=WIDTH)
    return Kind(data, scaled(pixels, most, 255), np.where(pixels == value, 0, 255).astype(np.uint8))


def _transparent_colour_of_8_bits() -> Kind:
    colour = RGB[5, 7]
    data = png(8, 2, RGB.reshape(HEIGHT, -1), (b"tRNS", colour.astype(">u2").tobytes()))
    return Kind(data, RGB, np.where((colour == RGB).all(axis=2), 0, 255).astype(np.uint8))


def _jpeg_in_tiff(pixels: np.ndarray) -> Kind:
    data = pillow(pixels, "TIFF", compression="jpeg", quality=97)
    decoded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    return Kind(data, decoded if pixels.ndim == 2 else decoded[..., ::-1], close=3)


def _palette_tiff() -> Kind:
    colours = RNG.integers(0, 256, (256, 3), dtype=np.uint8)
    table = colours.T.astype(np.uint16) * 257
    return Kind(tiff(GREY, photometric="palette", colormap=table), colours[GREY])


def _gif_with_a_hole() -> Kind:
    indexed = Image.fromarray(RGB).quantize(50)
    index = np.asarray(indexed)
    colours = np.asarray(indexed.convert("RGB"))
    return Kind(
        pillow(indexed, "GIF", transparency=int(index[5, 7])),
        colours,
        np.where(index == index[5, 7], 0, 255).astype(np.uint8),
    )


OPAQUE = np.dstack((RGB, np.full_like(GREY, 255)))
DEEP_OPAQUE = np.dstack((DEEP_GREY, np.full_like(DEEP_GREY, 65535)))
PREMULTIPLIED = {"extrasamples": ["assocalpha"]}

KINDS: dict[str, Callable[[], Kind]] = {
    "PNG, grey, 8 bits": lambda: Kind(pillow(GREY, "PNG"), GREY),
    "PNG, grey with alpha, 8 bits": lambda: Kind(
        pillow(GREY_ALPHA, "PNG"), GREY_ALPHA[..., 0], GREY_ALPHA[..., 1]
    ),
    "PNG, RGB, 8 bits": lambda: Kind(pillow(RGB, "PNG"), RGB),
    "PNG, RGB with alpha, 8 bits": lambda: Kind(pillow(RGBA, "PNG"), RGBA[..., :3], RGBA[..., 3]),
    "PNG, grey, 16 bits": lambda: Kind(opencv(".png", DEEP_GREY), DEEP_GREY),
    "PNG, grey with alpha, 16 bits": lambda: Kind(
        png(16, 4, big_endian(DEEP_GREY_ALPHA)), DEEP_GREY_ALPHA[..., 0], DEEP_GREY_ALPHA[..., 1]
    ),
    "PNG, RGB, 16 bits": lambda: Kind(opencv(".png", DEEP_RGB), DEEP_RGB),
    "PNG, RGB with alpha, 16 bits": lambda: Kind(
        opencv(".png", DEEP_RGBA), DEEP_RGBA[..., :3], DEEP_RGBA[..., 3]
    ),
    "PNG, RGB, 16 bits, interlaced": lambda: Kind(
        png(16, 2, big_endian(DEEP_RGB), interlaced=True), DEEP_RGB
    ),
    "PNG, grey with alpha, 16 bits, interlaced": lambda: Kind(
        png(16, 4, big_endian(DEEP_GREY_ALPHA), interlaced=True),
        DEEP_GREY_ALPHA[..., 0],
        DEEP_GREY_ALPHA[..., 1],
    ),
    "PNG, palette": _palette,
    "PNG, palette with transparent colours": _transparent_palette,
    "PNG, one transparent colour, 16 bits": _transparent_colour,
    "PNG, one transparent grey, 16 bits": _transparent_grey,
    "PNG, one transparent colour, 8 bits": _transparent_colour_of_8_bits,
    "PNG, one transparent grey, 2 bits": lambda: _grey_of_few_bits(2),
    "PNG, one transparent grey, 4 bits": lambda: _grey_of_few_bits(4),
    "PNG, 1 bit": lambda: Kind(pillow(Image.fromarray(GREY > 128), "PNG"), _bits()),
    "JPEG, grey": lambda: _jpeg(GREY),
    "JPEG, RGB": lambda: _jpeg(RGB, subsampling="4:4:4"),
    "JPEG, RGB, progressive": lambda: _jpeg(RGB, progressive=True, subsampling="4:4:4"),
    "TIFF, grey, 8 bits": lambda: Kind(tiff(GREY, photometric="minisblack"), GREY),
    "TIFF, grey with alpha, 8 bits": lambda: Kind(
        tiff(GREY_ALPHA, photometric="minisblack", **STRAIGHT), GREY_ALPHA[..., 0], GREY_ALPHA[..., 1]
    ),
    "TIFF, RGB, 8 bits": lambda: Kind(tiff(RGB, photometric="rgb"), RGB),
    "TIFF, RGB with alpha, 8 bits": lambda: Kind(
        tiff(RGBA, photometric="rgb", **STRAIGHT), RGBA[..., :3], RGBA[..., 3]
    ),
    "TIFF, grey, 16 bits": lambda: Kind(tiff(DEEP_GREY, photometric="minisblack"), DEEP_GREY),
    "TIFF, grey with alpha, 16 bits": lambda: Kind(
        tiff(DEEP_GREY_ALPHA, photometric="minisblack", **STRAIGHT),
        DEEP_GREY_ALPHA[..., 0],
        DEEP_GREY_ALPHA[..., 1],
    ),
    "TIFF, RGB, 16 bits": lambda: Kind(tiff(DEEP_RGB, photometric="rgb"), DEEP_RGB),
    "TIFF, RGB with alpha, 16 bits": lambda: Kind(
        tiff(DEEP_RGBA, photometric="rgb", **STRAIGHT), DEEP_RGBA[..., :3], DEEP_RGBA[..., 3]
    ),
    "TIFF, grey, floating point": lambda: Kind(tiff(FLOAT_GREY, photometric="minisblack"), FLOAT_GREY),
    "TIFF, RGB, floating point": lambda: Kind(tiff(FLOAT_RGB, photometric="rgb"), FLOAT_RGB),
    "TIFF, RGB with alpha, floating point": lambda: Kind(
        tiff(FLOAT_RGBA, photometric="rgb", **STRAIGHT), FLOAT_RGB, FLOAT_RGBA[..., 3]
    ),
    "TIFF, RGB, 16 bits, big-endian": lambda: Kind(
        tiff(DEEP_RGB, photometric="rgb", byteorder=">"), DEEP_RGB
    ),
    "TIFF, RGB, floating point, big-endian": lambda: Kind(
        tiff(FLOAT_RGB, photometric="rgb", byteorder=">"), FLOAT_RGB
    ),
    "TIFF, RGB, 16 bits, BigTIFF": lambda: Kind(tiff(DEEP_RGB, photometric="rgb", bigtiff=True), DEEP_RGB),
    "TIFF, RGB, 8 bits, BigTIFF": lambda: Kind(tiff(RGB, photometric="rgb", bigtiff=True), RGB),
    "TIFF, RGB, 8 bits, BigTIFF, big-endian": lambda: Kind(
        tiff(RGB, photometric="rgb", bigtiff=True, byteorder=">"), RGB
    ),
    "TIFF, RGB, floating point, big-endian, Deflate": lambda: Kind(
        tiff(FLOAT_RGB, photometric="rgb", byteorder=">", compression="zlib"), FLOAT_RGB
    ),
    "TIFF, grey, floating point, big-endian, Deflate": lambda: Kind(
        tiff(FLOAT_GREY, photometric="minisblack", byteorder=">", compression="zlib"), FLOAT_GREY
    ),
    "TIFF, RGB, 16 bits, planar": lambda: Kind(
        tiff(planar(DEEP_RGB), photometric="rgb", planarconfig="separate"), DEEP_RGB
    ),
    "TIFF, grey with alpha, 8 bits, planar": lambda: Kind(
        tiff(planar(GREY_ALPHA), photometric="minisblack", planarconfig="separate", **STRAIGHT),
        GREY_ALPHA[..., 0],
        GREY_ALPHA[..., 1],
    ),
    "TIFF, grey with alpha, 8 bits, planar, Deflate": lambda: Kind(
        tiff(
            planar(GREY_ALPHA),
            photometric="minisblack",
            planarconfig="separate",
            compression="zlib",
            **STRAIGHT,
        ),
        GREY_ALPHA[..., 0],
        GREY_ALPHA[..., 1],
    ),
    "TIFF, RGB with alpha, 8 bits, planar, Deflate": lambda: Kind(
        tiff(planar(RGBA), photometric="rgb", planarconfig="separate", compression="zlib", **STRAIGHT),
        RGBA[..., :3],
        RGBA[..., 3],
    ),
    "TIFF, RGB, floating point, planar": lambda: Kind(
        tiff(planar(FLOAT_RGB), photometric="rgb", planarconfig="separate"), FLOAT_RGB
    ),
    "TIFF, RGB, 16 bits, tiles": lambda: Kind(tiff(DEEP_RGB, photometric="rgb", tile=(16, 32)), DEEP_RGB),
    "TIFF, RGB, floating point, tiles, Deflate": lambda: Kind(
        tiff(FLOAT_RGB, photometric="rgb", tile=(16, 32), compression="zlib"), FLOAT_RGB
    ),
    "TIFF, RGB, 16 bits, Deflate": lambda: Kind(
        tiff(DEEP_RGB, photometric="rgb", compression="zlib"), DEEP_RGB
    ),
    "TIFF, RGB, 16 bits, Deflate with predictor": lambda: Kind(
        tiff(DEEP_RGB, photometric="rgb", compression="zlib", predictor=True, rowsperstrip=5), DEEP_RGB
    ),
    "TIFF, RGB, 16 bits, tiles, Deflate with predictor": lambda: Kind(
        tiff(DEEP_RGB, photometric="rgb", tile=(16, 32), compression="zlib", predictor=True), DEEP_RGB
    ),
    "TIFF, RGB, 16 bits, big-endian, Deflate with predictor": lambda: Kind(
        tiff(DEEP_RGB, photometric="rgb", byteorder=">", compression="zlib", predictor=True), DEEP_RGB
    ),
    "TIFF, RGB, floating point, Deflate with predictor": lambda: Kind(
        opencv(".tif", FLOAT_RGB, cv2.IMWRITE_TIFF_COMPRESSION, 8, cv2.IMWRITE_TIFF_PREDICTOR, 3), FLOAT_RGB
    ),
    "TIFF, RGB, floating point, LZW with predictor": lambda: Kind(
        opencv(".tif", FLOAT_RGB, cv2.IMWRITE_TIFF_COMPRESSION, 5, cv2.IMWRITE_TIFF_PREDICTOR, 3), FLOAT_RGB
    ),
    "TIFF, RGB, 16 bits, LZW": lambda: Kind(
        opencv(".tif", DEEP_RGB, cv2.IMWRITE_TIFF_COMPRESSION, 5), DEEP_RGB
    ),
    "TIFF, RGB, floating point, LZW": lambda: Kind(
        opencv(".tif", FLOAT_RGB, cv2.IMWRITE_TIFF_COMPRESSION, 5), FLOAT_RGB
    ),
    "TIFF, RGB, 8 bits, LZW": lambda: Kind(pillow(RGB, "TIFF", compression="tiff_lzw"), RGB),
    "TIFF, RGB, 8 bits, ZSTD": lambda: Kind(pillow(RGB, "TIFF", compression="zstd"), RGB),
    "TIFF, grey, 16 bits, ZSTD": lambda: Kind(pillow(DEEP_GREY, "TIFF", compression="zstd"), DEEP_GREY),
    "TIFF, RGB, 8 bits, PackBits": lambda: Kind(pillow(RGB, "TIFF", compression="packbits"), RGB),
    "TIFF, inverted grey, 8 bits": lambda: Kind(tiff(255 - GREY, photometric="miniswhite"), GREY),
    "TIFF, inverted grey, 16 bits": lambda: Kind(
        tiff(65535 - DEEP_GREY, photometric="miniswhite"), DEEP_GREY
    ),
    "TIFF, inverted grey with alpha, 8 bits": lambda: Kind(
        tiff(GREY_ALPHA, photometric="miniswhite", planarconfig="contig", **STRAIGHT),
        255 - GREY_ALPHA[..., 0],
        GREY_ALPHA[..., 1],
    ),
    "TIFF, inverted grey with alpha, 16 bits": lambda: Kind(
        tiff(DEEP_GREY_ALPHA, photometric="miniswhite", planarconfig="contig", **STRAIGHT),
        65535 - DEEP_GREY_ALPHA[..., 0],
        DEEP_GREY_ALPHA[..., 1],
    ),
    "TIFF, RGB with alpha by OpenCV, 8 bits": lambda: Kind(opencv(".tif", RGBA), RGBA[..., :3], RGBA[..., 3]),
    "TIFF, RGB with alpha by OpenCV, 16 bits": lambda: Kind(
        opencv(".tif", DEEP_RGBA), DEEP_RGBA[..., :3], DEEP_RGBA[..., 3]
    ),
    "TIFF, RGB with alpha by OpenCV, floating point": lambda: Kind(
        opencv(".tif", FLOAT_RGBA), FLOAT_RGB, FLOAT_RGBA[..., 3]
    ),
    "TIFF, opaque premultiplied alpha, 8 bits": lambda: Kind(
        tiff(OPAQUE, photometric="rgb", **PREMULTIPLIED), RGB, OPAQUE[..., 3]
    ),
    "TIFF, opaque premultiplied alpha, 16 bits": lambda: Kind(
        tiff(DEEP_OPAQUE, photometric="minisblack", planarconfig="contig", **PREMULTIPLIED),
        DEEP_GREY,
        DEEP_OPAQUE[..., 1],
    ),
    "TIFF, grey, JPEG": lambda: _jpeg_in_tiff(GREY),
    "TIFF, RGB, JPEG": lambda: _jpeg_in_tiff(RGB),
    "TIFF, RGB, 8 bits, LZMA": lambda: Kind(pillow(RGB, "TIFF", compression="lzma"), RGB),
    "TIFF, palette": _palette_tiff,
    "TIFF, 1 bit, fax": lambda: Kind(
        pillow(Image.fromarray(GREY > 128), "TIFF", compression="group4"), _bits()
    ),
    "TIFF, 1 bit": lambda: Kind(pillow(Image.fromarray(GREY > 128), "TIFF"), _bits()),
    "BMP, grey": lambda: Kind(pillow(GREY, "BMP"), GREY),
    "BMP, RGB": lambda: Kind(pillow(RGB, "BMP"), RGB),
    "BMP, palette": lambda: Kind(
        pillow(Image.fromarray(RGB).quantize(50), "BMP"),
        np.asarray(Image.fromarray(RGB).quantize(50).convert("RGB")),
    ),
    "BMP, 1 bit": lambda: Kind(pillow(Image.fromarray(GREY > 128), "BMP"), _bits()),
    "BMP, RGB with alpha": lambda: Kind(opencv(".bmp", RGBA), RGBA[..., :3], RGBA[..., 3]),
    "WebP, RGB, without loss": lambda: Kind(pillow(RGB, "WEBP", lossless=True), RGB),
    "WebP, RGB with alpha, without loss": lambda: Kind(
        pillow(RGBA, "WEBP", lossless=True, exact=True), RGBA[..., :3], RGBA[..., 3]
    ),
    "GIF": _gif,
    "GIF, interlaced": lambda: _gif(interlace=True),
    "GIF, one transparent colour": _gif_with_a_hole,
    "PBM, in figures": lambda: Kind(netpbm("P1", None, figures((GREY <= 128).astype(int))), _bits()),
    "PBM": lambda: Kind(netpbm("P4", None, np.packbits(GREY <= 128, axis=1).tobytes()), _bits()),
    "PGM, in figures": lambda: Kind(netpbm("P2", 255, figures(GREY), "# a comment\n"), GREY),
    "PGM, 8 bits": lambda: Kind(netpbm("P5", 255, GREY.tobytes()), GREY),
    "PGM, up to 100": lambda: Kind(netpbm("P5", 100, (GREY % 101).tobytes()), scaled(GREY % 101, 100, 255)),
    "PGM, 16 bits": lambda: Kind(netpbm("P5", 65535, DEEP_GREY.astype(">u2").tobytes()), DEEP_GREY),
    "PGM, 10 bits": lambda: Kind(
        netpbm("P5", 1023, (DEEP_GREY % 1024).astype(">u2").tobytes()), scaled(DEEP_GREY % 1024, 1023, 65535)
    ),
    "PPM, in figures, 16 bits": lambda: Kind(netpbm("P3", 65535, figures(DEEP_RGB)), DEEP_RGB),
    "PPM, 8 bits": lambda: Kind(opencv(".ppm", RGB), RGB),
    "PPM, 16 bits": lambda: Kind(netpbm("P6", 65535, DEEP_RGB.astype(">u2").tobytes()), DEEP_RGB),
    "PFM, grey": lambda: Kind(pfm(FLOAT_GREY, "<"), FLOAT_GREY),
    "PFM, RGB": lambda: Kind(opencv(".pfm", FLOAT_RGB), FLOAT_RGB),
    "PFM, RGB, big-endian": lambda: Kind(pfm(FLOAT_RGB, ">"), FLOAT_RGB),
    "Radiance HDR, in runs": lambda: _hdr(FLOAT_RGB),
    "Radiance HDR, without runs": _flat_hdr,
    "OpenEXR, grey": lambda: Kind(openexr(FLOAT_GREY), FLOAT_GREY),
    "OpenEXR, RGB": lambda: Kind(openexr(FLOAT_RGB), FLOAT_RGB),
    "OpenEXR, RGB, halves": lambda: Kind(
        openexr(FLOAT_RGB.astype(np.float16)), FLOAT_RGB.astype(np.float16).astype(np.float32)
    ),
    "OpenEXR, RGB with opaque alpha": lambda: Kind(
        openexr(np.dstack((FLOAT_RGB, np.ones_like(FLOAT_GREY)))), FLOAT_RGB, np.ones_like(FLOAT_GREY)
    ),
}
