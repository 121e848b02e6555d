"""LLVM by way of llvmlite's binding: this machine described to it, and its linker for objects of any kind."""

from typing import Any

import llvmlite.binding as llvm

from solvers.native import image

_engines: list[Any] = []  # an engine frees its code when it goes


class LinkError(Exception):
    """The objects cannot be linked into this process."""


def host() -> str:
    """What compiled code depends on besides its source and its compilers."""
    return "\n".join((llvm.get_process_triple(), llvm.get_host_cpu_name(), features()))


def features() -> str:
    """The processor's, for LLVM.

    Where there are vectors of 512 bits LLVM halves them by default, because the first processors that had them became
    slower by using them.  On those that do not, kernels are a quarter faster with whole ones.
    """
    found: str = llvm.get_host_cpu_features().flatten()
    slowed_down = llvm.get_host_cpu_name() in {"skylake-avx512", "cascadelake", "cooperlake"}
    return found if slowed_down else f"{found},-prefer-256-bit"


def target_machine() -> Any:
    """LLVM's description of this machine."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    if image.possible():
        kind = {"reloc": "pic", "codemodel": "small"}
    else:  # as numba does
        static = llvm.get_process_triple().startswith("x86_64")
        kind = {"reloc": "static" if static else "default", "codemodel": "jitdefault"}
    return llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=features(),
        opt=3,
        jit=not image.possible(),
        **kind,
    )


def load(objects: list[bytes], symbols: list[str]) -> list[int]:
    """Addresses of functions; raises `LinkError` if one is missing."""
    try:
        engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine())
        for code in objects:
            engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        engine.finalize_object()
    except RuntimeError as error:
        raise LinkError(str(error)) from error
    addresses = [int(engine.get_function_address(symbol)) for symbol in symbols]
    if missing := [symbol for symbol, address in zip(symbols, addresses, strict=True) if not address]:
        raise LinkError(f"not in the objects: {', '.join(missing)}")
    _engines.append(engine)
    return addresses
