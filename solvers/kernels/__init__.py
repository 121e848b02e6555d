"""Every compiled kernel, and nothing else.

`solvers.layout` says where a value lies; the names here are the same.  Arguments come in one order: what is written
first, then what is read, then scalars.  Kernels validate nothing, allocate nothing and raise nothing.

Arrays are indexed by unsigned integers, ``x[own + i]`` with ``own = u(...)`` and ``i`` in ``range(u(n))``: with signed
ones numba adds a wrap-around test to each access and LLVM no longer vectorises the loop.  Slices do too, but each costs
some instructions and a reference count, which is more than the work on a short run.

Loops over arrays stand in small functions of their own, declared as `loops`: no iteration touches what another one
writes, and LLVM is told so (`solvers.native.independent`).  It would find out by itself, by comparing the bounds of all
arrays each time a loop is entered, which takes as long as a run of a hundred pixels; and where there are many arrays it
would not even try.  Loops that put values into two quarters, or take them from two, do it in one go: LLVM then loads
and stores whole vectors and sorts them in between.

A kernel that reports the largest change compares the bit patterns of absolute values as integers: that order is the
order of the values, NaN and infinity stand above everything, so neither can hide, and it vectorises without `fastmath`.
They are kept in 32 bits, which numba's own `max` would make 64.

Unknowns that are scattered over a picture are waited for, each of them: `prefetch` asks for what the next ones need.

    setup     from a region to the coefficients of all levels
    cycle     relaxation, restriction, interpolation, exact solution: the steps of a cycle
    exact     the right-hand side, and between float32 and float64
    pictures  the solution added to pictures; those of integers as they are stored: differences, and rounding
    scattered unknowns one by one, where a region is sparse: a layout of their own, see `solvers.narrow`
    narrow    elimination and over-relaxation of those

A module's kernels call no kernel of another module: numba's cache on disk does not see edits there.
"""
