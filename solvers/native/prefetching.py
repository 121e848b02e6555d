"""What compilers make of `prefetch`; imports numba, and is imported for that it is done."""

from typing import Any

import numba as real_numba
from llvmlite import ir
from numba import extending

from solvers.native.prefetch import prefetch

numba: Any = real_numba  # not all that it offers has types

READING, SOON, DATA = 0, 3, 1  # as LLVM has it: not for writing, to all caches, no instructions


def _llvm(_: Any, array: Any, index: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        byte, number = ir.IntType(8).as_pointer(), ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
        function = builder.module.declare_intrinsic("llvm.prefetch", [byte], kind)
        address = builder.bitcast(builder.gep(data, [arguments[1]]), byte)
        builder.call(function, [address, *(number(n) for n in (READING, SOON, DATA))])
        return context.get_dummy_value()

    return numba.types.void(array, index), generate


_hint: Any = extending.intrinsic(_llvm)


@extending.overload(prefetch)
def _prefetch(array: Any, index: Any) -> Any:
    def compiled(array: Any, index: Any) -> Any:
        return _hint(array, index)

    return compiled
