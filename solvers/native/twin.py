"""A second copy of a kernel module, with numba's dispatchers in place of the functions.

Functions find each other by the globals of their module.  The copy has its own, so the module itself keeps plain
functions, and nothing changes under a thread that is just calling one.
"""

import importlib.util
from types import FunctionType, ModuleType
from typing import Any

import numba

import solvers.native.prefetching  # noqa: F401  what compilers make of `prefetch`
from solvers.native.library import Kernel


def dispatchers(name: str, **options: Any) -> ModuleType:
    """The copy of a kernel module; nothing is compiled yet.

    Parameters
    ----------
    name : str
        The module's full name; the copy is not entered in ``sys.modules``.
    **options
        For numba's ``njit``, beside those that each function was declared with.
    """
    spec = importlib.util.find_spec(name)
    if spec is None or spec.loader is None:
        raise ImportError(f"no source of {name}")
    copy = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(copy)
    for attribute, value in list(vars(copy).items()):
        function = value.plain if isinstance(value, Kernel) else value
        if isinstance(function, FunctionType) and "compiled" in function.__dict__:
            setattr(copy, attribute, numba.njit(**function.__dict__["compiled"], **options)(function))
    return copy
