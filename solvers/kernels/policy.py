"""The one jit policy."""

from typing import Any

from numba import njit

# On disk: the first use compiles, later processes load.  Without the GIL: callers use threads.  Division by zero
# follows IEEE, as in numpy.  No fastmath: a NaN must be seen.
jit: Any = njit(cache=True, nogil=True, error_model="numpy", boundscheck=False)
