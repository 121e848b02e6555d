"""Damage that a format's own checks let pass: blocks and tags that are whole, and say something else.

Flipped bits seldom get past a checksum or a magic number. Here a file is taken apart, one thing in it is changed to
what is least welcome, and it is put together again as the format wants it.
"""

from __future__ import annotations

import random
import re
import struct
import zlib

__all__ = ["mutated"]

UNWELCOME = (
    0, 1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 31, 32, 33, 63, 64, 100, 127, 128, 255, 256, 1000, 4095, 32767, 32768, 65535,
    65536, 100_000, 2**24, 2**31 - 1, 2**31, 2**32 - 1,
)  # fmt: skip
TAGS = (
    254, 256, 257, 258, 259, 262, 266, 273, 274, 277, 278, 279, 282, 283, 284, 296, 317, 320, 322, 323, 324, 325, 330,
    338, 339, 347, 529, 530, 532, 700, 34675, 34665, 34853, 33432, 33723, 50706,
)  # fmt: skip
EXIF = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"
WORDS = (
    b"0",
    b"1",
    b"-1",
    b"255",
    b"65535",
    b"65536",
    b"1e3",
    b"nan",
    b"inf",
    b"9" * 12,
    b"P1",
    b"P5",
    b"Pf",
    b"#x",
    b"",
)


def mutated(name: str, data: bytes, seed: int) -> bytes:
    """A file of a kind of `tests.kinds`, changed in a way that depends on the seed only."""
    rng = random.Random(f"{name} {seed}")
    if name.startswith("PNG"):
        return _png(data, rng)
    if name.startswith("TIFF"):
        return _tiff(data, rng)
    if name.startswith(("PBM", "PGM", "PPM", "PFM", "Radiance")) and rng.random() < 0.6:
        return _header(data, rng)
    return _bytes(data, rng)


def _bytes(data: bytes, rng: random.Random) -> bytes:
    """Bytes that are set, left out, repeated or moved."""
    damaged = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 3, 8, 30))):
        if not damaged:
            break
        place = rng.randrange(min(len(damaged), rng.choice((16, 64, 200, 600, len(data)))))
        match rng.randrange(7):
            case 0:
                damaged[place] = rng.randrange(256)
            case 1:
                del damaged[place : place + rng.choice((1, 2, 4, 16, len(damaged) // 10 + 1))]
            case 2:
                damaged[place:place] = rng.randbytes(rng.choice((1, 2, 4, 16)))
            case 3:
                damaged[place:place] = damaged[place : place + rng.choice((4, 12, 100))]
            case 4:
                del damaged[place:]
            case 5:
                other, length = rng.randrange(len(damaged)), rng.choice((1, 4, 12, 40))
                damaged[place : place + length] = damaged[other : other + length]
            case _:
                number = rng.choice(("<H", ">H", "<I", ">I"))
                size = struct.calcsize(number)
                if place + size <= len(damaged):
                    struct.pack_into(number, damaged, place, rng.choice(UNWELCOME) % (1 << 8 * size))
    return bytes(damaged)


def _png(data: bytes, rng: random.Random) -> bytes:
    """Blocks that are changed, repeated, left out or new, all with the right checksum."""
    blocks, place = [], 8
    while place + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, place)
        blocks.append((data[place + 4 : place + 8], data[place + 8 : place + 8 + length]))
        place += 12 + length
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(blocks))
        name, body = blocks[at]
        choice = rng.randrange(8)
        if name == b"IHDR" and len(body) == 13 and choice < 6:
            header = list(struct.unpack(">IIBBBBB", body))
            field = rng.randrange(7)
            header[field] = rng.choice(UNWELCOME) if field < 2 else rng.choice((0, 1, 2, 3, 4, 6, 8, 16, 32))
            blocks[at] = name, struct.pack(">IIBBBBB", *header)
        elif name == b"IDAT" and choice < 5:
            rows = _unpacked(body)
            rows = (
                _bytes(rows, rng)
                if choice < 3
                else rows[: rng.randrange(len(rows))] + bytes(rng.choice((0, 9, 99_999)))
            )
            blocks[at] = name, zlib.compress(rows)
        elif choice == 5:
            blocks[at] = name, _bytes(body, rng)
        elif choice == 6:
            blocks.insert(rng.randrange(len(blocks) + 1), blocks[at])
        elif choice == 7 and len(blocks) > 1:
            del blocks[at]
        else:
            new = rng.choice(
                b"tRNS PLTE eXIf iCCP iTXt zTXt pHYs acTL fcTL fdAT gAMA cHRM sRGB IEND CgBI".split()
            )
            bodies = (
                b"", rng.randbytes(rng.choice((1, 2, 4, 6, 9, 26, 32))), EXIF, b"ICC\0\0" + zlib.compress(bytes(200)),
                b"XML:com.adobe.xmp\0\0\0\0\0<x tiff:Orientation='6'/>", b"x\0\0" + zlib.compress(bytes(3_000_000)),
            )  # fmt: skip
            blocks.insert(rng.randrange(1, len(blocks) + 1), (new, rng.choice(bodies)))
    return data[:8] + b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        for name, body in blocks
    )


def _unpacked(body: bytes) -> bytes:
    """As much as can be, and a byte at least."""
    try:
        return zlib.decompressobj().decompress(body) or b"\0"
    except zlib.error:  # changed before, or the second part of it
        return b"\0"


def _tiff(data: bytes, rng: random.Random) -> bytes:
    """Entries of the first directory with another tag, type, count or value."""
    damaged = bytearray(data)
    order = "<" if data[:1] == b"I" else ">"
    big = struct.unpack_from(f"{order}H", data, 2)[0] == 43
    place, entry, count, size, at = ("Q", "Q", 8, 20, 12) if big else ("I", "H", 2, 12, 8)
    (first,) = struct.unpack_from(order + place, data, 8 if big else 4)
    (entries,) = struct.unpack_from(order + entry, data, first)
    for _ in range(rng.choice((1, 1, 2, 3))):
        begin = first + count + size * rng.randrange(entries)
        match rng.randrange(6):
            case 0:
                struct.pack_into(f"{order}H", damaged, begin, rng.choice(TAGS))
            case 1:
                struct.pack_into(f"{order}H", damaged, begin + 2, rng.randrange(20))
            case 2:
                struct.pack_into(order + place, damaged, begin + 4, rng.choice(UNWELCOME))
            case 3:
                struct.pack_into(f"{order}I", damaged, begin + at, rng.choice(UNWELCOME))
            case 4:
                value = rng.choice((0, 1, 2, 3, 4, 5, 6, 7, 8, 16, 32, 64, 32773, 34925, 50000, 50001, 65535))
                struct.pack_into(f"{order}H", damaged, begin + at, value)
            case _:
                struct.pack_into(f"{order}I", damaged, begin + at, rng.randrange(len(data)))
    return bytes(damaged) if rng.random() < 0.8 else _bytes(bytes(damaged), rng)


def _header(data: bytes, rng: random.Random) -> bytes:
    """Another word in a header of text."""
    words = re.split(rb"(\s+)", data[:60])
    words[rng.randrange(0, len(words), 2)] = rng.choice(WORDS)
    return b"".join(words) + data[60:]
