"""What an x86-64 processor says of itself, without LLVM, whose import takes longer than most solves."""

import ctypes
import struct

from solvers.native.image import executable

# void ask(uint32 leaf, uint32 part, uint32 answer[4])
_CPUID = bytes.fromhex(
    "53"  # push rbx
    "4989d0"  # mov r8, rdx
    "89f8 89f1"  # mov eax, edi; mov ecx, esi
    "0fa2"  # cpuid
    "418900 41895804 41894808 4189500c"  # mov [r8], eax; ... ebx, ecx, edx
    "5b c3"  # pop rbx; ret
)

# uint32 enabled(): the registers that the operating system saves
_XGETBV = bytes.fromhex("31c9 0f01d0 c3")  # xor ecx, ecx; xgetbv; ret

# Leaf, part and registers that LLVM reads to tell a processor's name and features.  What else they hold may change from
# core to core or from call to call.
_LEAVES = (
    (0x0, 0, "bcd"),
    (0x1, 0, "acd"),
    (0x7, 0, "bcd"),
    (0x7, 1, "abcd"),
    (0xD, 1, "a"),
    (0x14, 0, "b"),
    (0x19, 0, "b"),
    (0x1E, 1, "a"),
    (0x24, 0, "b"),
    (0x80000001, 0, "cd"),
    (0x80000008, 0, "b"),
)
_SAVES_REGISTERS = 1 << 27  # OSXSAVE, in ecx of leaf 1


def processor() -> str:
    """The processor's name and features as numbers: equal where LLVM would find equal ones.

    Raises `image.ImageError` where code cannot be run.
    """
    ask = ctypes.CFUNCTYPE(None, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_void_p)(executable(_CPUID))
    answer = (ctypes.c_uint32 * 4)()

    def asked(leaf: int, part: int) -> dict[str, int]:
        ask(leaf, part, ctypes.addressof(answer))
        return dict(zip("abcd", answer, strict=True))

    largest = {base: asked(base, 0)["a"] for base in (0, 0x80000000)}
    words = []
    for leaf, part, registers in _LEAVES:
        if leaf <= largest[leaf & 0x80000000]:  # beyond, some processors repeat another leaf
            found = asked(leaf, part)
            words += [found[register] for register in registers]
    if asked(1, 0)["c"] & _SAVES_REGISTERS:
        words.append(ctypes.CFUNCTYPE(ctypes.c_uint32)(executable(_XGETBV))())
    return struct.pack(f"<{len(words)}I", *words).hex()
