"""The one jit policy, and the kernels that Python may call."""

from solvers.native import Library

# Pictures are float32 or float64 throughout.
_ASSEMBLE = (
    "f4[:], f8[:], f4[:], {v}[:,:,:], {v}[:,:,:], {v}[:,:,:], {v}[:,:,:], i8, i8, i8,"
    " f4[:], f4[:], i4[:,:], i8[:,:] -> b1"
)
_ADD_SOLUTION = "{v}[:,:,:], {v}[:], f4[:], f4[:], i8, i4[:,:], i8[:,:]"

# Name -> signatures: arguments -> results, see `solvers.native.signature`.  Kernels that only kernels call need none.
# They are compiled side by side in this order, so what takes longest comes first (run_steps, 2 s, clear, .1 s).
ENTRY_POINTS = {
    "run_steps": [
        "i4[:,:], f4[:], f4[:], f4[:], f4[:], u1[:], f4[:], f4[:], f8[:,:], i8[:], f4[:], f8[:], i4[:,:], i8[:,:],"
        " i8[:,:],"
        " i8[:,:], i8"
    ],
    "build_levels": [
        "i8[:], f4[:], f4[:], u1[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], i4[:,:], i8[:,:], i8[:,:], i8, i8"
        " -> i8"
    ],
    "assemble": [_ASSEMBLE.format(v="f4")],
    "subtract_image": ["f4[:], f4[:], f4[:], f4[:], i8[:,:], i8[:,:], i8, b1 -> i8"],
    "add_solution": [_ADD_SOLUTION.format(v="f4")],
    "find_runs": ["i4[:,:], i8[:], u1[:], b1[:,:], i8 -> i8"],
    "weigh_region": ["f4[:], f4[:], u1[:], b1[:,:], i4[:,:], i8[:,:]"],
    "find_extent": ["u1[:], b1[:,:] -> i8, i8, i8"],
    "find_rim": ["i8[:], i8[:], b1[:,:], i8[:], u1[:], i8[:] -> i8"],
    "assemble_rim": ["f4[:], f4[:,:], i8[:], i8[:], f4[:], i8[:,:]"],
    "lay_out": ["i4[:,:], i8[:,:], i8[:,:], i4[:,:,:], i4[:,:], i8, i8, i8 -> i8"],
    "factor_coarsest": ["f8[:,:], i8[:], f8[:], i8[:], f4[:], f4[:], f4[:], i8[:,:], i8 -> f8"],
    "move": ["f4[:], f4[:], i8[:,:], i8[:,:], i8"],
    "fold": ["f4[:], f4[:], i8[:,:], i8[:,:], i8"],
    "clear": ["f4[:], i8[:,:], i8[:,:], i8"],
    "round_solution": [
        "u1[:,:,:], u1[:,:,:], u1[:], f4[:], f4[:], f4[:], b1[:,:], i8[:], f4, i8, i8, i4[:,:], i8[:,:] -> f8, f8"
    ],
    "round_into": [f"{v}[:,:,:], u1[:], f4[:,:,:], b1[:,:], i8, f4 -> f8, f8" for v in ("u1", "u2")],
    "subtract_pictures": [f"f4[:,:], {v}[:,:,:], {v}[:,:,:], i8[:], i8[:], i8[:]" for v in ("u1", "u2")],
    "survey": ["b1[:,:], i8, i8, i8 -> i8, i8"],
}

# What only some callers need: float64 throughout, over-relaxation, screening, regions with narrow parts.
FURTHER = {
    "solve_parts": [
        "f8[:,:], f8[:], i4[:], f8[:], f4[:], f4[:], i8[:], f4[:], i4[:,:], i8[:], f4[:], i4[:], i4[:], i4[:], f8[:],"
        " i8[:], f8[:], f8[:], f8[:,:], i4[:,:], i4[:], i4[:], i4[:], i4[:], i8, i8, i8, f8, i8 -> i8"
    ],
    "assemble": [_ASSEMBLE.format(v="f8")],
    "sum_pairs": [
        f"f8[:,:], i8[:], {v}[:,:,:], {v}[:,:,:], {v}[:,:,:], {v}[:,:,:], i8, i8, i8, i8"
        for v in ("f4", "f8")
    ],
    "sum_rim": ["f8[:,:], i4[:], f4[:], i8[:], i4[:,:], f4[:,:], i8[:], i8[:], i8"],
    "link": ["i4[:,:], i4[:], i4[:], i4[:], i8[:], i8, i8, i8, i8"],
    "number_parts": ["i4[:], i4[:], i4[:], i4[:,:], i8, i8, i8 -> i8"],
    "locate": ["i8[:], i8, i8[:], b1[:], i8[:], i8, i8 -> i8"],
    "sort_parts": ["i4[:], i4[:], i4[:], i4[:], i4[:]"],
    "add_solution": [_ADD_SOLUTION.format(v="f8")],
    "round_at": [f"{v}[:,:,:], {v}[:,:,:], f8[:,:], i8[:], i8, i8[:], f4 -> f8, f8" for v in ("u1", "u2")],
    "relax_over": ["f4[:], f4[:], f4[:], i8[:,:], i8[:,:], i8, i8, f4, i8, i8"],
    "coarsen_region": ["f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], i4[:,:], i8[:,:]"],
    "coarsen": ["f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], i4[:,:], i8[:,:], i8"],
    "weigh": ["f4[:], f4[:], u1[:], f4[:], f4[:], f4[:], f4[:], f4[:], f4[:], i8[:,:], i8[:,:], i8 -> i8"],
    "add_at": [f"{v}[:,:,:], f8[:,:], i8[:], i8, i8, i8" for v in ("f4", "f8")],
    "screen": ["f4[:], f4[:], f4[:], f4[:], i4[:,:], i8[:,:], i8[:,:], f4"],
}

# Without the GIL: callers use threads.  Division by zero follows IEEE, as in numpy.  No fastmath: a NaN must be seen.
library = Library(
    modules=(
        "solvers.kernels.setup",
        "solvers.kernels.cycle",
        "solvers.kernels.exact",
        "solvers.kernels.scattered",
        "solvers.kernels.narrow",
        "solvers.kernels.pictures",
    ),
    ingredients=("solvers.kernels.policy", "solvers.layout"),
    signatures=ENTRY_POINTS,
    further=FURTHER,
    options={"nogil": True, "error_model": "numpy", "boundscheck": False},
    home=__name__,
)
jit = library.jit()

# For the pieces of a kernel that run once per segment.  LLVM does not inline them by itself, and a call costs more than
# their work on a short segment: an array is passed as seven words.
inlined = library.jit(forceinline=True)

# The same for pieces made of loops over arrays that do not overlap.
loops = library.jit(independent=True, forceinline=True)
