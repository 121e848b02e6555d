"""From what lies in the cache to addresses of functions; imports neither numba nor, where it can do without, llvmlite.

Compiled code gets an array as the Python object that it is, and reads from it where the values lie and how many there
are.  That is numpy's public C structure, the same since 1.0; `check_process` looks all the same.
"""

import ctypes
import os
import sys
from collections.abc import Sequence

import numpy as np

from solvers.native import image
from solvers.native.store import packed_list, unpacked_list

# Offsets of ``data`` and ``dimensions`` in ``PyArrayObject_fields``: behind the head come data, nd, dimensions.
ARRAY_DATA = object.__basicsize__
ARRAY_SHAPE = ARRAY_DATA + 2 * ctypes.sizeof(ctypes.c_void_p)

_IMAGE, _OBJECTS = b"image", b"objects"  # what the content holds


class LoadError(Exception):
    """There is no loading it into this process."""


def check_process() -> None:
    """Raises `LoadError` if this process is not one that compiled code can live in."""
    if not hasattr(ctypes, "CDLL") or os.name != "posix" or ctypes.sizeof(ctypes.c_void_p) != 8:
        raise LoadError("made for 64-bit systems with shared libraries of the Unix kind")
    # LLVM ends the process if it does not find a function, so this is asked first.
    process = ctypes.CDLL(None)
    if missing := [name for name in image.FROM_THE_PROCESS if not hasattr(process, name)]:
        raise LoadError(f"not in this process: {', '.join(missing)}")
    array = np.zeros((3, 5), np.float32)
    data, shape = (ctypes.c_void_p.from_address(id(array) + at).value for at in (ARRAY_DATA, ARRAY_SHAPE))
    if (
        data != array.__array_interface__["data"][0]
        or not shape
        or tuple((ctypes.c_int64 * 2).from_address(shape)) != array.shape
    ):
        raise LoadError("numpy arrays are laid out in another way here")


def host() -> str:
    """What compiled code depends on besides its source and its compilers: the machine."""
    if image.possible():
        from solvers.native.processor import processor

        return f"{sys.platform} {processor()}"
    from solvers.native import linker

    return linker.host()


def content_of(objects: Sequence[bytes], symbols: Sequence[str]) -> bytes:
    """What is to be kept of compiled objects: an image of them where one can be made, else themselves."""
    if image.possible():
        try:
            code, offsets = image.link(objects, symbols)
        except image.ImageError:
            pass  # LLVM knows more
        else:
            return packed_list([_IMAGE, code, *(offset.to_bytes(8, "little") for offset in offsets)])
    return packed_list([_OBJECTS, *objects])


def load(content: bytes, symbols: Sequence[str]) -> dict[str, int]:
    """Addresses of functions by name.

    Parameters
    ----------
    content : bytes
        From `content_of`.
    symbols : sequence of str
        The functions, in the same order.

    Raises
    ------
    LoadError
        If it is something else, or cannot be loaded.
    """
    try:
        kind, *parts = unpacked_list(content)
        if kind == _IMAGE and len(parts) == 1 + len(symbols):
            code, *places = parts
            addresses = image.load(code, [int.from_bytes(place, "little") for place in places])
        elif kind == _OBJECTS:
            from solvers.native import linker

            try:
                addresses = linker.load(parts, list(symbols))
            except linker.LinkError as error:
                raise LoadError(str(error)) from error
        else:
            raise LoadError("something else")
    except (ValueError, image.ImageError) as error:
        raise LoadError(str(error)) from error
    return dict(zip(symbols, addresses, strict=True))
