"""From the bytes of a relocatable object to addresses of functions; imports llvmlite's binding, not numba.

Compiled code gets an array as the Python object that it is, and reads from it where the values lie and how many there
are.  That is numpy's public C structure, the same since 1.0; `check_process` looks all the same.
"""

import ctypes
import os
from typing import Any

import llvmlite
import llvmlite.binding as llvm
import numpy as np

# Offsets of ``data`` and ``dimensions`` in ``PyArrayObject_fields``: behind the head come data, nd, dimensions.
ARRAY_DATA = object.__basicsize__
ARRAY_SHAPE = ARRAY_DATA + 2 * ctypes.sizeof(ctypes.c_void_p)

# Functions of the C library that compiled code may call.
FROM_THE_PROCESS = ("memset", "memcpy", "memmove", "sqrt")

_engines: list[Any] = []  # an engine frees its code when it goes


class LoadError(Exception):
    """The object cannot be linked into this process."""


def check_process() -> None:
    """Raises `LoadError` if this process is not one that compiled code can live in."""
    if not hasattr(ctypes, "CDLL") or os.name != "posix" or ctypes.sizeof(ctypes.c_void_p) != 8:
        raise LoadError("made for 64-bit systems with shared libraries of the Unix kind")
    # LLVM ends the process if it does not find a function, so this is asked first.
    process = ctypes.CDLL(None)
    if missing := [name for name in FROM_THE_PROCESS if not hasattr(process, name)]:
        raise LoadError(f"not in this process: {', '.join(missing)}")
    array = np.zeros((3, 5), np.float32)
    data, shape = (ctypes.c_void_p.from_address(id(array) + at).value for at in (ARRAY_DATA, ARRAY_SHAPE))
    if (
        data != array.__array_interface__["data"][0]
        or not shape
        or tuple((ctypes.c_int64 * 2).from_address(shape)) != array.shape
    ):
        raise LoadError("numpy arrays are laid out in another way here")


def host() -> str:
    """What compiled code depends on besides its source: the machine, and the linker's version."""
    features = llvm.get_host_cpu_features().flatten()
    return "\n".join((llvm.get_process_triple(), llvm.get_host_cpu_name(), features, llvmlite.__version__))


def target_machine() -> Any:
    """LLVM's description of this machine."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=3,
        reloc="static" if llvm.get_process_triple().startswith("x86_64") else "default",  # as numba does
        codemodel="jitdefault",
        jit=True,
    )


def load(objects: list[bytes], symbols: list[str]) -> dict[str, int]:
    """Addresses of functions by name; raises `LoadError` if one is missing."""
    try:
        engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine())
        for code in objects:
            engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        engine.finalize_object()
    except RuntimeError as error:
        raise LoadError(str(error)) from error
    addresses = {symbol: int(engine.get_function_address(symbol)) for symbol in symbols}
    if missing := [symbol for symbol, address in addresses.items() if not address]:
        raise LoadError(f"not in the objects: {', '.join(missing)}")
    _engines.append(engine)
    return addresses
