"""What a picture file says of itself before a pixel is decoded, and whether it can be read without loss.

A decoder asked for pixels hands over *something* for nearly every file: sixteen bits cut to eight, a fourth channel
dropped, inks taken for opacity. So the layout is judged here first, and what would lose anything is refused by name.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from typing import Final

from PIL import Image

from poisson_cli.errors import InputError
from poisson_cli.images.formats import PNG, TIFF, Format

__all__ = ["LARGEST", "Header", "decoding", "judge", "refuse_deep"]

LARGEST: Final = 500_000_000
"""Pixels; a header that claims more is taken for damaged before memory is asked for."""

_DECODE_AS: Final = {"1": "L", "L": "L", "LA": "LA", "P": "RGB", "PA": "RGBA", "RGB": "RGB", "RGBA": "RGBA"}
_WITH_TRANSPARENT_COLOUR: Final = {"L": "LA", "RGB": "RGBA"}
_OTHER_MODES: Final = {"CMYK": "CMYK", "YCbCr": "YCbCr", "LAB": "CIE-Lab"}

_EIGHT_BITS: Final = "convert it to 8 bits per channel first"


@dataclass(frozen=True)
class Header:
    """How to decode a picture.

    Parameters
    ----------
    mode
        Decoder's mode that holds all the file's pixels without loss: L, LA, RGB or RGBA.
    palette
        Whether the file stores indices into a list of colours.
    profile
        ICC profile, None where there is none.
    """

    mode: str
    palette: bool
    profile: bytes | None


@contextmanager
def decoding(name: str, form: Format) -> Iterator[None]:
    """Turn whatever a decoder raises (some fifteen types, by now) into one `InputError` that names the file.

    Meanwhile the decoder's own limit on the size of a picture is ours, and its warnings, which are about metadata, are
    kept from the terminal.
    """
    usual = Image.MAX_IMAGE_PIXELS
    Image.MAX_IMAGE_PIXELS = LARGEST // 2  # it warns above its limit and refuses at twice that
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except Image.DecompressionBombError as error:
        raise InputError(
            f"{name}: its header claims more than {LARGEST:,} pixels, the most that is read"
        ) from error
    except MemoryError as error:
        raise InputError(f"{name}: not enough memory to decode it") from error
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{name}: damaged {form.name} file, it cannot be decoded ({reason})") from error
    finally:
        Image.MAX_IMAGE_PIXELS = usual


def judge(image: Image.Image, name: str, form: Format) -> Header:
    """Judge a picture by its header.

    Parameters
    ----------
    image
        The picture, not decoded yet.
    name
        What the user calls it.
    form
        Its format.

    Raises
    ------
    InputError, Image.DecompressionBombError
        If it is too large, one of several, or holds pixels that would lose something here.
    """
    if image.width * image.height > LARGEST:
        raise Image.DecompressionBombError
    _refuse_other_than_one(image, name)
    mode = _DECODE_AS.get(image.mode)
    if mode is None:
        kind = _OTHER_MODES.get(image.mode, image.mode)
        raise InputError(
            f"{name}: a {kind} {form.name}; convert it to RGB or grey, 8 bits per channel, first"
        )
    if "transparency" in image.info:
        mode = _WITH_TRANSPARENT_COLOUR.get(mode, mode)
    profile = image.info.get("icc_profile")
    return Header(mode=mode, palette=image.mode in ("P", "PA"), profile=profile or None)


def _refuse_other_than_one(image: Image.Image, name: str) -> None:
    """Refuse animations and documents of several pages.

    The further pictures of a multi-picture JPEG are previews, gain maps and the like of the first one, so it counts
    as one picture, as it does in every viewer.
    """
    count = getattr(image, "n_frames", 1)
    if count > 1 and image.format != "MPO":
        kind = "pages" if image.format == "TIFF" else "frames"
        raise InputError(
            f"{name}: a {image.format} with {count} {kind}; save the one you mean as a file of its own"
        )


def refuse_deep(data: bytes, name: str, form: Format) -> None:
    """Refuse a layout of samples that cannot be read without loss, before a decoder sees it.

    Only for the formats that can hold more than eight bits in ways that the decoder cuts down without a word.

    Parameters
    ----------
    data
        The whole file.
    name
        What the user calls it.
    form
        Its format.

    Raises
    ------
    InputError
        If it has such a layout; anything else if it is damaged.
    """
    refusal = _refusal_by_bits(data, form)
    if refusal is not None:
        raise InputError(f"{name}: {refusal}")


def _refusal_by_bits(data: bytes, form: Format) -> str | None:
    """Why the layout of the samples cannot be read without loss; None if it can."""
    if form is PNG:
        depth = data[24]  # signature 8, length and name of IHDR 8, width 4, height 4
        return f"a {depth}-bit PNG; {_EIGHT_BITS}" if depth > 8 else None
    if form is TIFF:
        return _refusal_by_tags(data)
    return None


def _refusal_by_tags(data: bytes) -> str | None:
    """The same for TIFF, by the tags of its first page."""
    from PIL import TiffImagePlugin

    big = data[2:4] == b"+\x00"
    tags = TiffImagePlugin.ImageFileDirectory_v2(data[: 16 if big else 8])
    file = BytesIO(data)
    file.seek(tags.next)
    tags.load(file)

    width, height = (int(tags[tag]) for tag in (TiffImagePlugin.IMAGEWIDTH, TiffImagePlugin.IMAGELENGTH))
    if width * height > LARGEST:
        raise Image.DecompressionBombError
    bits = max(tags.get(TiffImagePlugin.BITSPERSAMPLE, (1,)))
    kinds = set(tags.get(TiffImagePlugin.SAMPLEFORMAT, (1,)))
    extra = tuple(tags.get(TiffImagePlugin.EXTRASAMPLES, ()))
    if 3 in kinds:
        return f"a {bits}-bit floating-point TIFF; {_EIGHT_BITS}"
    if bits > 8:
        return f"a {bits}-bit TIFF; {_EIGHT_BITS}"
    if kinds - {1, 4}:  # 4: undefined, which writers mean as unsigned
        return "a TIFF of signed or complex numbers; convert it to unsigned 8 bits per channel first"
    if 1 in extra:
        return "a TIFF with premultiplied alpha; save it with straight (unassociated) alpha first"
    if extra not in ((), (2,)):
        return "a TIFF with extra channels that are not alpha; save it without them first"
    return None
