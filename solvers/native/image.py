"""Relocatable objects linked once into an image: code that runs wherever it lies, so that loading it is copying it.

LLVM's own linker takes 35 ms to import and to start, which is more than the solver takes for most pictures.  All that
it has to do for kernels is known beforehand: they call each other, read constants, and call a handful of functions of
the C library.  The first two are distances within the image and are settled when it is made.  The calls go by way of a
table at its beginning, which is filled when it is loaded:

    addresses of foreign functions | jumps to them | the objects' sections

This knows one kind of objects, ELF for x86-64; where they are of another kind (see `possible`), or hold something that
kernels do not need, they stay objects and LLVM links them in each process.
"""

import ctypes
import mmap
import os
import struct
import sys
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

# Functions of the C library that compiled code may call.
FROM_THE_PROCESS = ("memset", "memcpy", "memmove", "sqrt")

# From the ELF specification and its supplement for x86-64.
_HEADER = struct.Struct("<4sBB10xHH20xQ10xHHH")  # magic, class, byte order, type, machine, sections' headers
_SECTION = struct.Struct("<IIQQQQIIQQ")
_SYMBOL = struct.Struct("<IBBHQQ")
_RELOCATION = struct.Struct("<QQq")
_X86_64 = 62
_WITH_CONTENT, _SYMBOLS, _RELOCATIONS, _UNWINDING = 1, 2, 4, 0x70000001  # kinds of sections
_WRITABLE, _LOADED = 1, 2  # flags of sections
_UNDEFINED, _RESERVED = 0, 0xFF00  # numbers of sections that are none
_GLOBAL = 1
_DISTANCES = (2, 4)  # R_X86_64_PC32, R_X86_64_PLT32: 32 bits, from where they stand

_LINE = 64  # bytes; no section wants a larger alignment
_JUMP = b"\xff\x25"  # jmp [rip + distance]

_mapped: list[mmap.mmap] = []  # code goes with its mapping


class ImageError(Exception):
    """The objects cannot be linked here, or the image cannot be loaded."""


def possible() -> bool:
    """Whether this machine's objects are of the kind that is known here."""
    return sys.platform == "linux" and os.uname().machine == "x86_64" and struct.calcsize("P") == 8


class _Section(NamedTuple):
    kind: int
    flags: int
    link: int
    info: int
    align: int
    content: bytes


class _Symbol(NamedTuple):
    name: str
    is_global: bool
    section: int
    value: int


def link(objects: Sequence[bytes], names: Sequence[str]) -> tuple[bytes, list[int]]:
    """The image of some objects.

    Parameters
    ----------
    objects : sequence of bytes
        As LLVM emits them: x86-64, position-independent, small code model.
    names : sequence of str
        Functions to be called from outside.

    Returns
    -------
    image : bytes
    offsets : list of int
        Where in the image each of them begins.

    Raises
    ------
    ImageError
        If the objects need something that an image does not have.
    """
    parsed = [_parsed(data) for data in objects]
    image = bytearray(8 * len(FROM_THE_PROCESS))
    foreign = {}
    for k, name in enumerate(FROM_THE_PROCESS):
        foreign[name] = len(image)
        image += _JUMP + struct.pack("<i", 8 * k - (len(image) + 6)) + b"\0\0"
    places: list[dict[int, int]] = []  # per object: section -> where it lies
    for sections, _ in parsed:
        places.append({})
        for number, section in enumerate(sections):
            if not section.flags & _LOADED or section.kind == _UNWINDING or not section.content:
                continue  # kernels raise nothing, so nothing is ever unwound
            if section.kind != _WITH_CONTENT or section.flags & _WRITABLE or section.align > _LINE:
                raise ImageError("objects hold variables")
            image += bytes(-len(image) % _LINE)
            places[-1][number] = len(image)
            image += section.content
    found: dict[str, int] = {}
    for place, (sections, symbols) in zip(places, parsed, strict=True):
        found |= {s.name: place[s.section] + s.value for s in symbols if s.is_global and s.section in place}
        for at, kind, symbol, addend in _relocations(sections, symbols, place):
            if kind not in _DISTANCES:
                raise ImageError(f"objects hold relocations of kind {kind}")
            if symbol.section == _UNDEFINED and symbol.name in foreign:
                target = foreign[symbol.name]
            elif symbol.section in place:
                target = place[symbol.section] + symbol.value
            else:
                raise ImageError(f"objects need {symbol.name or 'something unnamed'}")
            struct.pack_into("<i", image, at, target + addend - at)
    if missing := [name for name in names if name not in found]:
        raise ImageError(f"not in the objects: {', '.join(missing)}")
    return bytes(image), [found[name] for name in names]


def _parsed(data: bytes) -> tuple[list[_Section], list[_Symbol]]:
    try:
        magic, bits, order, kind, machine, at, size, n, _ = _HEADER.unpack_from(data)
        if (magic, bits, order, kind, machine, size) != (b"\x7fELF", 2, 1, 1, _X86_64, _SECTION.size):
            raise ImageError("not a relocatable ELF object for x86-64")
        sections = []
        for k in range(n):
            _, kind, flags, _, offset, length, link, info, align, _ = _SECTION.unpack_from(
                data, at + k * size
            )
            sections.append(_Section(kind, flags, link, info, align, data[offset : offset + length]))
        symbols = []
        for section in sections:
            if section.kind == _SYMBOLS:
                texts = sections[section.link].content
                for name, binding, _, number, value, _ in _SYMBOL.iter_unpack(section.content):
                    text = texts[name : texts.index(b"\0", name)].decode()
                    symbols.append(_Symbol(text, binding >> 4 == _GLOBAL, number, value))
    except (struct.error, IndexError, ValueError) as error:
        raise ImageError("a damaged object") from error
    return sections, symbols


def _relocations(
    sections: list[_Section], symbols: list[_Symbol], place: dict[int, int]
) -> Iterator[tuple[int, int, _Symbol, int]]:
    """Where in the image, which kind, to what, plus what: for each number that the compiler left open."""
    for section in sections:
        if section.kind == _RELOCATIONS and section.info in place:
            for offset, info, addend in _RELOCATION.iter_unpack(section.content):
                yield place[section.info] + offset, info & 0xFFFFFFFF, symbols[info >> 32], addend


def load(image: bytes, offsets: Sequence[int]) -> list[int]:
    """Make an image executable in this process.

    Parameters
    ----------
    image : bytes
    offsets : sequence of int
        From `link`.

    Returns
    -------
    list of int
        The functions' addresses.

    Raises
    ------
    ImageError
        If there is no image or the system does not allow it.
    """
    if any(not 0 <= offset < len(image) for offset in offsets):
        raise ImageError("not an image")
    process = ctypes.CDLL(None, use_errno=True)
    table = [_address(getattr(process, name)) for name in FROM_THE_PROCESS]
    base = executable(struct.pack(f"<{len(table)}Q", *table) + image[8 * len(table) :])
    return [base + offset for offset in offsets]


def executable(code: bytes) -> int:
    """The address of a copy of some machine code, which stays there until the process ends; raises `ImageError`."""
    try:
        memory = mmap.mmap(
            -1, len(code), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, mmap.PROT_READ | mmap.PROT_WRITE
        )
    except (OSError, ValueError) as error:
        raise ImageError(str(error)) from error
    memory.write(code)
    address = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    # Never writable and executable at once, which hardened systems forbid.
    protect = ctypes.CDLL(None, use_errno=True).mprotect
    protect.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
    if protect(address, len(code), mmap.PROT_READ | mmap.PROT_EXEC):
        raise ImageError(f"memory cannot be made executable: {os.strerror(ctypes.get_errno())}")
    _mapped.append(memory)
    return address


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0
