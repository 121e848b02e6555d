"""From kernels to the bytes of a relocatable object; imports numba.

Kernels allocate nothing and raise nothing, so their code needs next to nothing from outside: that is checked here, and
makes an object that can be loaded where there is no numba.
"""

import gc
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import Any
from unittest.mock import patch

import llvmlite.binding as llvm
import numba as real_numba
import numpy as np

from solvers.native import twin
from solvers.native.library import Kernel, Library
from solvers.native.loading import ARRAY_DATA, ARRAY_SHAPE, FROM_THE_PROCESS, target_machine
from solvers.native.signature import Kind, Signature
from solvers.native.store import packed_list, unpacked_list
from solvers.team import available_cores

numba: Any = real_numba  # not all that it offers has types
types = numba.types

__all__ = ["BuildError", "build", "build_module", "packed_list"]

# What numba calls when a kernel has raised.  None does.
WHEN_RAISING = {
    "NRT_Free", "PyBytes_FromStringAndSize", "PyErr_Clear", "PyErr_Occurred", "PyErr_SetNone", "PyErr_SetObject",
    "PyErr_SetString", "PyErr_WriteUnraisable",
    "PyExc_RuntimeError", "PyExc_StopIteration", "PyExc_SystemError", "PyGILState_Ensure", "PyGILState_Release",
    "PyObject_Str", "PyUnicode_FromString", "Py_DecRef", "Py_IncRef", "numba_do_raise", "numba_gil_ensure",
    "numba_gil_release", "numba_runtime_build_excinfo_struct", "numba_unpickle",
}  # fmt: skip

_DTYPES = {"b1": np.bool_, "i4": np.int32, "i8": np.int64, "f4": np.float32, "f8": np.float64}
_SCALARS = {
    "b1": types.boolean,
    "i4": types.int32,
    "i8": types.int64,
    "f4": types.float32,
    "f8": types.float64,
}


# Arrays in kernels are borrowed, their count is none of the kernels' business: these calls would find null.
_REFERENCE_COUNTING = re.compile(r"^ *(tail )?call void @NRT_(inc|dec)ref\(.*$", re.MULTILINE)


class BuildError(Exception):
    """The kernels cannot be made into an object that stands on its own."""


def build(library: Library) -> list[bytes]:
    """The object code of all entry points, for this machine: one object per module.

    Raises `BuildError`, or what numba raises.  Where the library may start helpers, modules are compiled side by side.
    """
    n_processes = min(len(library.modules), available_cores()) if library.helpers and sys.executable else 1
    shares = [library.modules[k::n_processes] for k in range(n_processes)]
    helpers = [(share, _start_helper(library, share)) for share in shares[1:]]
    objects = {name: build_module(library, name) for name in shares[0]}
    for share, helper in helpers:
        answer = helper.communicate()[0]
        try:
            objects |= zip(share, unpacked_list(answer), strict=True)
        except ValueError:  # it failed: so may we, and then say why
            objects |= {name: build_module(library, name) for name in share}
    return [objects[name] for name in library.modules]


def _start_helper(library: Library, modules: Sequence[str]) -> "subprocess.Popen[bytes]":
    """Another process that compiles some of the modules and writes the objects to its stdout."""
    program = (
        f"import sys; sys.path[:] = {sys.path!r}\n"
        f"from {library.home} import library\n"
        "from solvers.native.building import build_module, packed_list\n"
        f"objects = [build_module(library, name) for name in {list(modules)!r}]\n"
        "sys.stdout.buffer.write(packed_list(objects))\n"
    )
    return subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )


def build_module(library: Library, name: str) -> bytes:
    """The object code of one module's entry points."""
    with numba.core.compiler_lock.global_compiler_lock, _no_collection():
        # Each function would be optimised by itself, again within each of its callers, and at last within the callback:
        # only the last time counts.
        with _optimised_later():
            callbacks: dict[str, Any] = {}
            module = twin.dispatchers(name, no_cpython_wrapper=True, no_cfunc_wrapper=True)
            kernels = [kernel for kernel in library.kernels() if kernel.__module__ == name]
            for kernel in kernels:
                callbacks |= _callbacks(kernel, module, library.options)
            symbols = list(callbacks)
            word = types.intp
            callbacks["numba_attempt_nocopy_reshape"] = numba.cfunc(
                types.int32(word, word, word, word, word, word, word, types.int32)
            )(_reshape)
        return _emit(_link(callbacks, symbols), symbols)


def _callbacks(kernel: Kernel, module: ModuleType, options: dict[str, Any]) -> dict[str, Any]:
    """A C callback for each signature of a kernel, by symbol."""
    allowed = {k: v for k, v in options.items() if k not in ("nogil", "cache")}
    return {
        kernel.symbol(k): numba.cfunc(_c_signature(signature), **allowed)(
            _entry(getattr(module, kernel.__name__), signature)
        )
        for k, signature in enumerate(kernel.signatures)
    }


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


def _link(callbacks: dict[str, Any], visible: Sequence[str]) -> Any:
    """One optimised module of all callbacks; nothing but the visible ones can be seen from outside."""
    whole = llvm.parse_assembly("")
    for symbol, callback in callbacks.items():
        part = llvm.parse_assembly(_REFERENCE_COUNTING.sub("", callback.inspect_llvm()))
        part.get_function(callback.native_name).name = symbol
        whole.link_in(part)
    _hide(whole, visible)
    machine = target_machine()
    whole.data_layout = str(machine.target_data)
    # As numba does it: first inline, and turn loops round so that they can be vectorised; then everything.
    for level in (0, 3):
        tuning = llvm.create_pipeline_tuning_options(speed_level=level)
        tuning.loop_vectorization = level > 0
        tuning.slp_vectorization = False
        builder = llvm.create_pass_builder(machine, tuning)
        passes = builder.getModulePassManager()
        if level == 0:
            passes.add_loop_rotate_pass()
            passes.add_instruction_combine_pass()
            passes.add_jump_threading_pass()
        passes.run(whole, builder)
    return whole


def _emit(module: Any, symbols: Sequence[str]) -> bytes:
    """Object code of a module that needs nothing but `FROM_THE_PROCESS`."""
    missing = {f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")}
    missing |= {v.name for v in module.global_variables if v.is_declaration}
    missing -= set(FROM_THE_PROCESS)
    if foreign := missing - WHEN_RAISING:
        raise BuildError(
            f"kernels must not allocate or call what is not compiled: {', '.join(sorted(foreign))}"
        )
    traps = "".join(
        f"define void @{name}() {{\n call void @llvm.trap()\n unreachable\n}}\n" for name in sorted(missing)
    )
    module.link_in(llvm.parse_assembly(f"declare void @llvm.trap()\n{traps}"))
    _hide(module, symbols)
    module.verify()
    return bytes(target_machine().emit_object(module))


def _hide(module: Any, visible: Sequence[str]) -> None:
    for value in (*module.functions, *module.global_variables):
        if not value.is_declaration and value.name not in visible:
            value.linkage = "internal"


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
