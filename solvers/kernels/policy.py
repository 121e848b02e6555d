"""The one jit policy."""

from typing import Any

from numba import njit

# On disk: the first use compiles, later processes load.  Without the GIL: callers use threads.  Division by zero
# follows IEEE, as in numpy.  No fastmath: a NaN must be seen.
jit: Any = njit(cache=True, nogil=True, error_model="numpy", boundscheck=False)

# For the pieces of a kernel that run once per segment.  LLVM does not inline them by itself, and a call costs more than
# their work on a short segment: an array is passed as seven words.
inlined: Any = njit(inline="always", error_model="numpy", boundscheck=False)
