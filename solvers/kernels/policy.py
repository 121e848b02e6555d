"""The one jit policy, and the kernels that Python may call."""

from solvers.native import Library

# Name -> signatures: arguments -> results, see `solvers.native.signature`.  Kernels that only kernels call need none.
ENTRY_POINTS = {
    "find_runs": ["i4[:,:], b1[:,:], i8 -> i8"],
    "coarsen_runs": ["i4[:,:], i4[:,:], i8 -> i8"],
    "join_runs": ["i8[:,:], i4[:,:], i8, i8, i8, i8 -> i8"],
    "weigh_region": ["f4[:], f4[:], b1[:,:], i4[:,:], i8[:,:]"],
    "coarsen_region": ["f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], i4[:,:], i8[:,:]"],
    "coarsen": ["f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], i4[:,:], i8[:,:], i8"],
    "weigh": ["f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], i8[:,:], i8[:,:], i8 -> i8"],
    "screen_region": ["f4[:], f4[:], f4[:], i8[:,:], i8[:,:], f4"],
    "coarsen_mass": ["f4[:], f4[:], i4[:,:], i8[:,:], i8"],
    "add_mass": ["f4[:], f4[:], f4[:], i8[:,:], i8[:,:], i8"],
    "factor_band": ["f8[:,:]"],
    "relax_over": ["f4[:], f4[:], f4[:], i8[:,:], i8[:,:], i8, i8, f4, i8, i8"],
    "run_steps": [
        "f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f8[:,:], i8[:], f4[:], f8[:], i4[:,:], i8[:,:], i8[:,:], i8[:,:], i8"
        " -> i4, i4, i4"
    ],
    # Pictures are float32 or float64 throughout; float32 ones of small integers are summed in float32.
    "assemble": [
        f"f4[:], {line}[:], f4[:], {v}[:,:,:], {v}[:,:,:], {v}[:,:,:], {v}[:,:,:], i8, i8, i8,"
        " f4[:], f4[:], i4[:,:], i8[:,:] -> b1"
        for line, v in (("f4", "f4"), ("f8", "f4"), ("f8", "f8"))
    ],
    "add_solution": [f"{v}[:,:,:], f8[:], f4[:], f4[:], i8, i4[:,:], i8[:,:]" for v in ("f4", "f8")],
    "solve_coarsest": ["f4[:], f4[:], f8[:,:], i8[:], f8[:], i8[:,:], i8, i8 -> i4"],
    "fold": ["f4[:], f4[:], i8[:,:], i8[:,:], i8"],
    "clear": ["f4[:], i8[:,:], i8[:,:], i8"],
    "subtract_image": ["f4[:], f8[:], f4[:], f4[:], f4[:], i8[:,:], i8[:,:], i8, b1 -> i8"],
}

# Without the GIL: callers use threads.  Division by zero follows IEEE, as in numpy.  No fastmath: a NaN must be seen.
library = Library(
    modules=("solvers.kernels.setup", "solvers.kernels.cycle", "solvers.kernels.exact"),
    ingredients=("solvers.kernels.policy", "solvers.layout"),
    signatures=ENTRY_POINTS,
    options={"nogil": True, "error_model": "numpy", "boundscheck": False},
    home=__name__,
)
jit = library.jit()

# For the pieces of a kernel that run once per segment.  LLVM does not inline them by itself, and a call costs more than
# their work on a short segment: an array is passed as seven words.
inlined = library.jit(forceinline=True)
