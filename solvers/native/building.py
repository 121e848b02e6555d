"""From kernels to the bytes of relocatable objects; imports numba.

Kernels allocate nothing and raise nothing, so their code needs next to nothing from outside: that is checked here, and
makes objects that can be loaded where there is no numba.
"""

import gc
import importlib
import os
import re
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from types import ModuleType
from typing import Any
from unittest.mock import patch

import llvmlite.binding as llvm
import numba as real_numba
import numpy as np

from solvers.native import twin
from solvers.native.image import FROM_THE_PROCESS
from solvers.native.independent import mangled, mark
from solvers.native.library import Kernel, Library, Volume
from solvers.native.linker import target_machine
from solvers.native.loading import ARRAY_DATA, ARRAY_SHAPE
from solvers.native.signature import Kind, Signature
from solvers.native.store import packed_list, unpacked_list
from solvers.team import available_cores

numba: Any = real_numba  # not all that it offers has types
types = numba.types

__all__ = ["BuildError", "build", "help_out"]

# Each takes a second and 100 MiB to begin.
MOST_HELPERS = 3

# What numba calls when a kernel has raised.  None does.
WHEN_RAISING = {
    "NRT_Free", "PyBytes_FromStringAndSize", "PyErr_Clear", "PyErr_Occurred", "PyErr_SetNone", "PyErr_SetObject",
    "PyErr_SetString", "PyErr_WriteUnraisable",
    "PyExc_RuntimeError", "PyExc_StopIteration", "PyExc_SystemError", "PyGILState_Ensure", "PyGILState_Release",
    "PyObject_Str", "PyUnicode_FromString", "Py_DecRef", "Py_IncRef", "numba_do_raise", "numba_gil_ensure",
    "numba_gil_release", "numba_runtime_build_excinfo_struct", "numba_unpickle",
}  # fmt: skip

_DTYPES = {
    "b1": np.bool_,
    "u1": np.uint8,
    "u2": np.uint16,
    "i4": np.int32,
    "i8": np.int64,
    "f4": np.float32,
    "f8": np.float64,
}
_SCALARS = {
    "b1": types.boolean,
    "u1": types.uint8,
    "u2": types.uint16,
    "i4": types.int32,
    "i8": types.int64,
    "f4": types.float32,
    "f8": types.float64,
}


# Arrays in kernels are borrowed, their count is none of the kernels' business: these calls would find null.
_REFERENCE_COUNTING = re.compile(r"^ *(tail )?call void @NRT_(inc|dec)ref\(.*$", re.MULTILINE)


# A function's declaration, up to its attributes.
_DECLARATION = re.compile(r"declare ([^#\n]*\))")

_RESHAPE = "numba_attempt_nocopy_reshape"


class BuildError(Exception):
    """The kernels cannot be made into an object that stands on its own."""


def build(library: Library, volume: Volume) -> list[bytes]:
    """The object code of a volume's entry points, for this machine: one object per signature.

    Raises `BuildError`, or what numba raises.  Where the library may start helpers, they compile side by side: each
    process takes the next number from a pipe until none is left.
    """
    jobs = _jobs(library, volume)
    queue, entrance = os.pipe()
    with open(entrance, "wb") as file:
        file.write(bytes(range(len(jobs))))
    n_helpers = min(available_cores() - 1, MOST_HELPERS) if library.helpers and sys.executable else 0
    helpers = [_start_helper(library, volume, queue) for _ in range(n_helpers)]
    try:
        objects = _work(library, volume, queue)
        for helper in helpers:
            assert helper.stdout is not None
            objects |= _answer(helper.stdout.read())
    finally:
        os.close(queue)
        for helper in helpers:
            with helper:  # closes its streams, and waits for it
                helper.kill()
    for k, job in enumerate(jobs):
        if k not in objects:  # a helper failed: so may we, and then say why
            objects[k] = _build_one(library, *job)
    return [objects[k] for k in range(len(jobs))]


def _jobs(library: Library, volume: Volume) -> list[tuple[Kernel, int]]:
    """Every signature of a volume, in the order in which the kernels were declared: the dearest first."""
    order = list(library.signatures)
    kernels = sorted(library.kernels(), key=lambda kernel: order.index(kernel.__name__))
    return [(kernel, k) for kernel in kernels for k in kernel.of(volume)]


def _start_helper(library: Library, volume: Volume, queue: int) -> "subprocess.Popen[bytes]":
    """Another process that compiles what it finds in the queue."""
    program = (
        f"import sys; sys.path[:] = {sys.path!r}\n"
        f"from {library.home} import library\n"
        "from solvers.native.building import help_out\n"
        f"help_out(library, {volume!r}, {queue})\n"
    )
    return subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE,  # ends with this process, see `help_out`
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        pass_fds=(queue,),
    )


def help_out(library: Library, volume: Volume, queue: int) -> None:
    """What a helper does: objects to its stdout, each behind its number; nothing any more once its stdin ends."""
    threading.Thread(target=_end_with_stdin, daemon=True).start()
    objects = _work(library, volume, queue)
    sys.stdout.buffer.write(packed_list([bytes([k]) + code for k, code in objects.items()]))


def _end_with_stdin() -> None:
    """Whoever waits for the objects holds the other end, and may be gone without a word: killed, or interrupted."""
    sys.stdin.buffer.read()
    os._exit(1)


def _answer(answer: bytes) -> dict[int, bytes]:
    """A helper's objects by number; none if it failed."""
    try:
        return {part[0]: part[1:] for part in unpacked_list(answer)}
    except (ValueError, IndexError):
        return {}


def _work(library: Library, volume: Volume, queue: int) -> dict[int, bytes]:
    """Compile what is in the queue until it is empty."""
    jobs = _jobs(library, volume)
    objects = {}
    while number := os.read(queue, 1):
        k = number[0]
        objects[k] = _build_one(library, *jobs[k])
    return objects


def _build_one(library: Library, kernel: Kernel, k: int) -> bytes:
    """The object code of one signature."""
    options = {name: value for name, value in library.options.items() if name not in ("nogil", "cache")}
    signature, symbol = kernel.signatures[k], kernel.symbol(k)
    # Each function would be optimised by itself, again within each of its callers, and at last within the callback:
    # only the last time counts.
    with numba.core.compiler_lock.global_compiler_lock, _no_collection(), _optimised_later():
        function = getattr(_twin(kernel.__module__), kernel.__name__)
        callback = numba.cfunc(_c_signature(signature), **options)(_entry(function, signature))
        whole = _parsed(callback, symbol, _independent(kernel.__module__))
        if any(f.name == _RESHAPE and f.is_declaration for f in whole.functions):
            whole.link_in(_parsed(_reshaping(), _RESHAPE))
        _optimise(whole, symbol)
        return _emit(whole, symbol)


@cache
def _reshaping() -> Any:
    """`_reshape` as a callback."""
    word = types.intp
    return numba.cfunc(types.int32(word, word, word, word, word, word, word, types.int32))(_reshape)


@cache
def _independent(module: str) -> tuple[str, ...]:
    """Names of a module's functions whose loops are independent."""
    functions = vars(importlib.import_module(module)).items()
    plain = [(name, f.plain if isinstance(f, Kernel) else f) for name, f in functions]
    return tuple(mangled(module, name) for name, f in plain if getattr(f, "independent", False))


@cache
def _twin(module: str) -> ModuleType:
    """Dispatchers, which keep what they have compiled for the next signature."""
    return twin.dispatchers(module, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def _c_signature(signature: Signature) -> Any:
    arguments = [types.intp if kind.ndim else _SCALARS[kind.dtype] for kind in signature.arguments]
    if len(signature.results) > 1:
        arguments.append(types.voidptr)
    result = _SCALARS[signature.results[0].dtype] if len(signature.results) == 1 else types.void
    return result(*arguments)


def _entry(kernel: Any, signature: Signature) -> Any:
    """``def entry(a0, a1, ...)``: arrays made of addresses of Python objects, then the kernel."""
    names = [f"a{i}" for i in range(len(signature.arguments))]
    values = [_argument(name, kind) for name, kind in zip(names, signature.arguments, strict=True)]
    call = f"kernel({', '.join(values)})"
    if len(signature.results) > 1:
        names.append("results")
        out = f"carray(results, ({len(signature.results)},), {signature.results[0].dtype})"
        targets = ", ".join(f"out[{i}]" for i in range(len(signature.results)))
        body = f"    out = {out}\n    {targets} = {call}\n"
    else:
        body = f"    {'return ' if signature.results else ''}{call}\n"
    scope: dict[str, Any] = {"kernel": kernel, "carray": numba.carray, "at": _at, "word": _word, **_DTYPES}
    exec(f"def entry({', '.join(names)}):\n{body}", scope)
    return scope["entry"]


def _argument(name: str, kind: Kind) -> str:
    if not kind.ndim:
        return name
    shape = "".join(f"word(word({name} + {ARRAY_SHAPE}) + {8 * axis}), " for axis in range(kind.ndim))
    return f"carray(at(word({name} + {ARRAY_DATA})), ({shape}), {kind.dtype})"


def _pointer(_: Any, address: Any) -> Any:
    """An address as a pointer."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.intp), generate


def _word_at(_: Any, address: Any) -> Any:
    """The pointer-sized integer at an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = context.get_value_type(types.intp).as_pointer()
        return builder.load(builder.inttoptr(arguments[0], pointer))

    return types.intp(types.intp), generate


_at: Any = numba.extending.intrinsic(_pointer)
_word: Any = numba.extending.intrinsic(_word_at)


def _reshape(
    ndim: Any,
    shape: Any,
    strides: Any,
    new_ndim: Any,
    new_shape: Any,
    new_strides: Any,
    item: Any,
    fortran: Any,
) -> Any:
    """What numba asks for a view of another shape: its strides, if the array is C-contiguous; else 0.

    numba has that in a library of its own, for all kinds of arrays; kernels see contiguous ones only.
    """
    step = item
    for axis in range(ndim - 1, -1, -1):
        length = _word(shape + 8 * axis)
        if length > 1 and _word(strides + 8 * axis) != step:
            return 0
        step *= length
    if fortran:
        return 0
    target = numba.carray(_at(new_strides), (new_ndim,), np.int64)
    step = item
    for axis in range(new_ndim - 1, -1, -1):
        target[axis] = step
        step *= _word(new_shape + 8 * axis)
    return 1


def _parsed(callback: Any, symbol: str, independent: Sequence[str] = ()) -> Any:
    """A callback and all that it calls, under the name `symbol`; `independent` is for `independent.mark`.

    Its call of the kernel may be inlined, unlike numba's: then what tells of an exception is known to be of no use.
    """
    text = mark(_REFERENCE_COUNTING.sub("", callback.inspect_llvm()), independent)
    module = llvm.parse_assembly(text.replace("{ noinline }", "{ nounwind }"))
    module.get_function(callback.native_name).name = symbol
    return module


def _optimise(module: Any, visible: str) -> None:
    """Optimise a module of which nothing but one function can be seen from outside."""
    # Before anything else, so that what would follow on an exception is known to be dead.
    traps = [
        f"define {declared[1]} {{\n call void @llvm.trap()\n unreachable\n}}\n"
        for function in module.functions
        if function.name in WHEN_RAISING and (declared := _DECLARATION.match(str(function)))
    ]
    module.link_in(llvm.parse_assembly("declare void @llvm.trap()\n" + "".join(traps)))
    for value in (*module.functions, *module.global_variables):
        if not value.is_declaration and value.name != visible:
            value.linkage = "internal"
    machine = target_machine()
    module.data_layout = str(machine.target_data)
    # As numba does it: first inline, and turn loops round so that they can be vectorised; then everything.
    for level in (0, 3):
        tuning = llvm.create_pipeline_tuning_options(speed_level=level)
        tuning.loop_vectorization = level > 0
        tuning.slp_vectorization = False
        # Kernels work on short stretches, for which copies of a loop's body are of no use: without them the code is
        # as fast, a third smaller, and compiled in half the time.
        tuning.loop_interleaving = tuning.loop_unrolling = False
        builder = llvm.create_pass_builder(machine, tuning)
        passes = builder.getModulePassManager()
        if level == 0:
            passes.add_loop_rotate_pass()
            passes.add_instruction_combine_pass()
            passes.add_jump_threading_pass()
        passes.run(module, builder)


def _emit(module: Any, symbol: str) -> bytes:
    """Object code of a module that needs nothing but `FROM_THE_PROCESS`."""
    missing = {f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")}
    missing |= {v.name for v in module.global_variables if v.is_declaration}
    if foreign := missing.difference(FROM_THE_PROCESS):
        raise BuildError(
            f"{symbol} must not allocate or call what is not compiled: {', '.join(sorted(foreign))}"
        )
    module.verify()
    return bytes(target_machine().emit_object(module))


@contextmanager
def _optimised_later() -> Iterator[None]:
    """numba as a front end only: no optimisation and no machine code of single functions."""
    from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary, JITCPUCodegen

    def nothing(*_: Any) -> None:
        return None

    def linked(code: Any, _: str) -> int:
        code._ensure_finalized()
        return 0

    with (
        patch.object(CPUCodeLibrary, "_optimize_functions", nothing),
        patch.object(CPUCodeLibrary, "_optimize_final_module", nothing),
        patch.object(JITCodeLibrary, "get_pointer_to_function", linked),
        patch.object(JITCPUCodegen, "set_env", nothing),
        patch.object(JITCPUCodegen, "_add_module", nothing),
        patch.object(JITCodeLibrary, "_finalize_specific", nothing),
    ):
        yield


@contextmanager
def _no_collection() -> Iterator[None]:
    """Without the garbage collector, which takes a sixth of the time and finds nothing."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
