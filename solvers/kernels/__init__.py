"""Every compiled kernel, and nothing else.

`solvers.layout` says where a value lies; the names here are the same.  Arguments come in one order: what is written
first, then what is read, then scalars.  Kernels validate nothing, allocate nothing and raise nothing.

Arrays are indexed by unsigned integers, ``x[own + i]`` with ``own = u(...)`` and ``i`` in ``range(u(n))``: with signed
ones numba adds a wrap-around test to each access and LLVM no longer vectorises the loop.  Slices do too, but each costs
some instructions and a reference count, which is more than the work on a short run.

LLVM also gives up a loop that writes one array and reads so many others that it would need more than eight overlap
tests.  Loops that read many arrays are therefore cut in two, with a stretch of `scratch` in between that stays in the
first-level cache.

A kernel that reports the largest change compares the bit patterns of absolute values as integers: that order is the
order of the values, NaN and infinity stand above everything, so neither can hide, and it vectorises without `fastmath`.

    setup     from a region to the coefficients of all levels
    cycle     relaxation, restriction, interpolation, exact solution: the steps of a cycle
    exact     between pictures and the layout, and between float32 and float64
    narrow    elimination where a region is narrow: a layout of its own, see `solvers.narrow`

A module's kernels call no kernel of another module: numba's cache on disk does not see edits there.
"""
