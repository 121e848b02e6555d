"""Where a decoder's exceptions end: whatever it raises becomes one error that names the file."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from poisson_cli.errors import InputError
from poisson_cli.images.formats import Format

__all__ = ["DEFLATE_RATIO", "decoding", "refuse_hollow"]

DEFLATE_RATIO: Final = 1032
"""Bytes that one byte can become at most when deflated data are unpacked."""


@contextmanager
def decoding(name: str, form: Format) -> Iterator[None]:
    """Turn whatever a decoder raises (some fifteen types, by now) into one `InputError` that names the file.

    Meanwhile its warnings, which are about metadata, are kept from the terminal.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except MemoryError as error:
        raise InputError(f"{name}: not enough memory to decode it") from error
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{name}: damaged {form.name} file, it cannot be decoded ({reason})") from error


def refuse_hollow(name: str, size: int, length: int, ratio: int) -> None:
    """Refuse a file that cannot hold what its header claims, before memory is asked for.

    Parameters
    ----------
    name
        What the user calls the file.
    size
        Bytes (or pixels) that the header claims, unpacked.
    length
        Bytes of the file.
    ratio
        How many of them one byte of it can become at most.

    Raises
    ------
    InputError
        If it is too short.
    """
    if size > ratio * length:
        raise InputError(f"{name}: damaged, {length:,} bytes cannot hold as many pixels as its header claims")
