"""Kernels that start at once: compiled by numba once, kept on disk, loaded without importing numba.

Importing numba takes longer than most solves, so a process should not have to.  The way of a kernel:

    declared    `Library.jit` marks the functions of the kernel modules.  Those that Python calls have a signature
                and become a `Kernel`, the others stay plain functions.                     (library, signature)
    compiled    A second copy of a module is made, with numba's dispatchers in place of the functions.  Each
                signature becomes a C callback around its kernel, each of them one object.
                                                                             (twin, building, independent)
    linked      Once, into code that runs wherever it lies; where that is not known, not yet.        (image)
    stored      In the user's cache folder, by a name that tells what it was made from and for.
                                                                                          (store, processor)
    loaded      Copied into memory, or by LLVM's linker; ctypes calls it, without the GIL. (loading, linker)

Whatever goes wrong on this way, plain numba compiles the same functions, and they give the same bits.

``POISSON_KERNELS`` chooses another way, to find out which one is at fault:

    native      the way above (default)
    numba       plain numba with its own cache
    python      no compiler: a debugger steps through the kernels
"""

from solvers.native.library import Kernel, Library, Mode

__all__ = ["Kernel", "Library", "Mode"]
