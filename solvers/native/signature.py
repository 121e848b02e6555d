"""Signatures of entry points, as they are declared: ``"f4[:], i8[:,:], i8 -> i4"``.

Arguments first, then what is returned: nothing, one scalar, or several of one kind.  ``f4[:,:]`` is a C-contiguous
float32 array of two dimensions; ``f4``, ``i8``, ``b1`` alone are scalars.
"""

import ctypes
import re
from typing import Any, NamedTuple

_SCALAR = {
    "b1": ctypes.c_bool,
    "u1": ctypes.c_uint8,
    "u2": ctypes.c_uint16,
    "i4": ctypes.c_int32,
    "i8": ctypes.c_int64,
    "f4": ctypes.c_float,
    "f8": ctypes.c_double,
}
_WORD = re.compile(r"(b1|u1|u2|i4|i8|f4|f8)(?:\[(:(?:,:)*)\])?")


class Kind(NamedTuple):
    """The type of one argument or result.

    Attributes
    ----------
    dtype : str
        As numpy abbreviates it.
    ndim : int
        0 for a scalar.
    """

    dtype: str
    ndim: int

    @classmethod
    def of(cls, word: str) -> "Kind":
        """From its name; raises ValueError."""
        match = _WORD.fullmatch(word.strip())
        if match is None:
            raise ValueError(f"{word.strip()!r} is no type of a kernel's argument")
        dtype, axes = match.groups()
        return cls(dtype, axes.count(":") if axes else 0)

    @property
    def ctype(self) -> Any:
        """What ctypes passes: an array as the Python object that it is, see `solvers.native.loading`."""
        return ctypes.py_object if self.ndim else _SCALAR[self.dtype]


class Signature(NamedTuple):
    """What an entry point takes and gives."""

    arguments: tuple[Kind, ...]
    results: tuple[Kind, ...]

    @classmethod
    def of(cls, text: str) -> "Signature":
        """From its declaration; raises ValueError."""
        arguments, _, results = text.partition("->")
        signature = cls(_kinds(arguments), _kinds(results))
        if any(kind.ndim for kind in signature.results) or len(set(signature.results)) > 1:
            raise ValueError(f"{text!r}: results must be scalars of one kind")
        return signature


def _kinds(text: str) -> tuple[Kind, ...]:
    # A comma within brackets belongs to the array.
    return tuple(Kind.of(word) for word in re.split(r",(?![^\[]*\])", text) if word.strip())
