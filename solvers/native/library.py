"""The kernels of a package as one library: declared here, compiled and loaded when the first of them is called.

It comes in two volumes, each compiled when one of its kernels is called: what nearly every caller needs, and the rest,
so that nobody waits for what is of no use to them.
"""

import ctypes
import functools
import importlib
import os
import threading
from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any, Literal, get_args

from solvers.native.signature import Signature

if TYPE_CHECKING:
    from solvers.native.store import Shelf

Mode = Literal["native", "numba", "python"]
Volume = Literal["usual", "further"]
VOLUMES: tuple[Volume, ...] = get_args(Volume)

MODE_VARIABLE = "POISSON_KERNELS"

# Flags of a numpy array that compiled code relies on: C-contiguous, aligned.
_PLAIN = 0x0001 | 0x0100


def mode() -> Mode:
    """What `POISSON_KERNELS` asks for; raises ValueError if there is no such way."""
    asked = os.environ.get(MODE_VARIABLE, "") or "native"
    for known in get_args(Mode):
        if asked == known:
            return known  # type: ignore[no-any-return]
    raise ValueError(f"{MODE_VARIABLE} is {asked!r}, but must be one of {', '.join(get_args(Mode))}")


class Library:
    """All kernels of a package.

    Parameters
    ----------
    modules : sequence of str
        Full names of the modules that hold kernels; none calls a kernel of another.
    ingredients : sequence of str
        Further modules whose source the compiled code depends on.
    signatures : mapping
        Function name -> signatures of the entry points: what Python calls.  See `solvers.native.signature`.
    further : mapping
        The same for the second volume; a function may have signatures in both.
    options : mapping
        For numba's ``njit``.
    home : str
        The module that holds this object under the name ``library``.

    Attributes
    ----------
    listener : callable or None
        Told when a volume has to be compiled: called with its name and None before, with its name and the seconds it
        took afterwards.
    helpers : bool
        Whether compiling may start further Python processes; a program that is more than `python` may not want that.
    trouble : str or None
        Why the kernels had to be left to plain numba.
    unkept : str or None
        Why what is compiled cannot be kept for later processes, as far as that is known.
    """

    def __init__(
        self,
        modules: Sequence[str],
        ingredients: Sequence[str],
        signatures: Mapping[str, Sequence[str]],
        options: Mapping[str, Any],
        home: str,
        further: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        self.home = home
        self.helpers = False
        self.modules = tuple(modules)
        self.ingredients = tuple(ingredients)
        self.signatures: dict[str, list[tuple[Volume, Signature]]] = {}
        for volume, declared in zip(VOLUMES, (signatures, further or {}), strict=True):
            for name, texts in declared.items():
                self.signatures.setdefault(name, []).extend((volume, Signature.of(text)) for text in texts)
        self.options = dict(options)
        self.listener: Callable[[Volume, float | None], None] | None = None
        self.trouble: str | None = None
        self.unkept: str | None = None
        self._addresses: dict[Volume, dict[str, int]] = {}
        self._twins: dict[str, ModuleType] = {}
        self._lock = threading.RLock()

    def jit(self, *, independent: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]:
        """Decorator of every function that is to be compiled: an entry point becomes a `Kernel`.

        Parameters
        ----------
        independent : bool
            In no loop of the function does an iteration read or write an element of an array that another one writes.
            LLVM then vectorises them without looking, see `solvers.native.independent`.
        **options
            For numba, beside those of the library.
        """

        def declare(function: Callable[..., Any]) -> Any:
            assert isinstance(function, FunctionType)
            function.__dict__["compiled"] = {**self.options, **options}  # what `twin` looks for
            function.__dict__["independent"] = independent
            signatures = self.signatures.get(function.__name__)
            if signatures is None:
                return function
            # A kernel that was changed, and its signature not yet, is left to numba.
            fitting = [s for s in signatures if len(s[1].arguments) == function.__code__.co_argcount]
            return Kernel(self, function, tuple(fitting))

        return declare

    def kernels(self) -> "list[Kernel]":
        """All entry points, in the order of their modules."""
        found = []
        for name in self.modules:
            found += [v for v in vars(importlib.import_module(name)).values() if isinstance(v, Kernel)]
        return found

    def symbols(self, volume: Volume) -> list[str]:
        """Names of all compiled entry points of a volume."""
        return [kernel.symbol(k) for kernel in self.kernels() for k in kernel.of(volume)]

    def addresses(self, volume: Volume) -> dict[str, int]:
        """Addresses of the compiled entry points by symbol; empty if they cannot be had.  Compiles where it must."""
        with self._lock:
            if volume not in self._addresses:
                try:
                    self._addresses[volume] = self._load(volume)
                except Exception as error:
                    self.trouble = _said(error)
                    self._addresses[volume] = {}
            return self._addresses[volume]

    def _load(self, volume: Volume) -> dict[str, int]:
        from solvers.native import loading

        loading.check_process()
        symbols = self.symbols(volume)
        shelf = self.shelf(volume)
        found = shelf.read()
        if found is not None:
            try:
                return loading.load(found, symbols)
            except loading.LoadError:
                pass  # whole, but not what was expected: compile it anew
        with shelf.locked():
            # Another process may have been faster.
            again = shelf.read()
            if again is not None and again != found:
                return loading.load(again, symbols)
            content = self._build(volume, shelf)
        return loading.load(content, symbols)

    def _build(self, volume: Volume, shelf: "Shelf") -> bytes:
        """Compile a volume, and keep it."""
        from solvers.native import loading, store

        start = perf_counter()
        self.unkept = store.obstacle(shelf.path.parent)
        self._tell(volume, None)
        try:
            from solvers.native import building

            content = loading.content_of(building.build(self, volume), self.symbols(volume))
            if not shelf.write(content):
                self.unkept = shelf.trouble
        except Exception as error:
            self.trouble = _said(error)
            raise
        finally:
            self._tell(volume, perf_counter() - start)
        return content

    def is_kept(self, volume: Volume) -> bool:
        """Whether a compiled volume lies where it is kept, and can be read."""
        return self.shelf(volume).read() is not None

    def shelf(self, volume: Volume) -> "Shelf":
        """Where a compiled volume is kept, or will be."""
        from solvers.native import loading, store

        return store.Shelf(store.key_of(self, volume, loading.host()))

    def _tell(self, volume: Volume, seconds: float | None) -> None:
        if self.listener is not None:
            self.listener(volume, seconds)

    def dispatcher(self, kernel: "Kernel") -> Callable[..., Any]:
        """The kernel as plain numba compiles it."""
        from solvers.native import twin

        with self._lock:
            module = kernel.__module__
            if module not in self._twins:
                self._twins[module] = twin.dispatchers(module, cache=True)
            found: Callable[..., Any] = getattr(self._twins[module], kernel.__name__)
            return found


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


class Kernel:
    """An entry point: a function that Python calls and a compiler compiles.

    A call goes to the compiled code whose signature the arguments have.  Arguments that were not foreseen (another
    dtype, a strided array) are left to numba, which compiles for them; `plain` is the function as it was written.
    """

    __name__: str

    def __init__(
        self, library: Library, function: FunctionType, signatures: tuple[tuple[Volume, Signature], ...]
    ) -> None:
        functools.update_wrapper(self, function)
        self.library = library
        self.plain = function
        self.signatures = tuple(signature for _, signature in signatures)
        self._volumes = tuple(volume for volume, _ in signatures)
        self._variants: dict[Volume, list[Callable[..., Any]]] = {}
        self._other: Callable[..., Any] | None = None

    def __call__(self, *arguments: Any) -> Any:
        """Run it."""
        for volume in VOLUMES:
            variants = self._variants.get(volume)
            if variants is None:
                variants = self._resolve(volume)
            for variant in variants:
                result = variant(*arguments)
                if result is not NotImplemented:
                    return result
        if self._other is None:
            self._other = self.plain if mode() == "python" else self.library.dispatcher(self)
        return self._other(*arguments)

    def symbol(self, k: int) -> str:
        """Name of the k-th signature's compiled code."""
        return f"poisson_{self.__module__.replace('.', '_')}_{self.__name__}_{k}"

    def of(self, volume: Volume) -> list[int]:
        """Which of the signatures a volume has."""
        return [k for k, its in enumerate(self._volumes) if its == volume]

    def _resolve(self, volume: Volume) -> list[Callable[..., Any]]:
        wanted = self.of(volume)
        addresses = self.library.addresses(volume) if wanted and mode() == "native" else {}
        there = [k for k in wanted if self.symbol(k) in addresses]
        found = [_variant(self.signatures[k], addresses[self.symbol(k)]) for k in there]
        self._variants[volume] = found
        return found


def _variant(signature: Signature, address: int) -> Callable[..., Any]:
    """A function that calls compiled code, or returns `NotImplemented` if the arguments are not of its signature.

    A check per argument in a loop would cost more than a short kernel: the function is written out for its signature.
    """
    import numpy as np

    types = [kind.ctype for kind in signature.arguments]
    several = len(signature.results) > 1
    result = signature.results[0].ctype if len(signature.results) == 1 else None
    code = ctypes.CFUNCTYPE(result, *types, *([ctypes.c_void_p] if several else []))(address)
    scope: dict[str, Any] = {"code": code, "address": ctypes.addressof}
    names, checks, values = [], [], []
    for i, kind in enumerate(signature.arguments):
        name = f"a{i}"
        names.append(name)
        if kind.ndim:
            scope[f"dtype{i}"] = np.dtype(kind.dtype)
            checks.append(
                f"{name}.dtype is dtype{i} and {name}.ndim == {kind.ndim} and {name}.flags.num & {_PLAIN} == {_PLAIN}"
            )
        values.append(name if kind.ndim else f"{_SCALARS[kind.dtype[0]]}({name})")
    lines = [
        f"def call({', '.join(names)}):",
        f"    if not ({' and '.join(checks)}):",
        "        return NotImplemented",
    ]
    if several:
        scope["buffer"] = signature.results[0].ctype * len(signature.results)
        lines += [
            "    results = buffer()",
            f"    code({', '.join(values)}, address(results))",
            "    return tuple(results)",
        ]
    else:
        lines.append(f"    return code({', '.join(values)})")
    exec("\n".join(lines), scope)
    call: Callable[..., Any] = scope["call"]
    return call


_SCALARS = {"b": "bool", "i": "int", "f": "float"}
