"""Where compiled kernels are kept: files that only their owner could have written.

A file's name is the hash of everything that its content was made from and for; its head is the hash of its content.
The first keeps it from being used for anything else, the second finds damage.  Neither stops someone who may write the
file: so a folder or a file that another user owns (the system's administrator excepted) or may write to is left alone.
The hash is the one by which Python itself tells whether compiled code belongs to its source: 64 bits, and no import.
"""

import contextlib
import importlib.util
import os
import stat
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solvers.native.library import Library

FOLDER_VARIABLE = "POISSON_CACHE_DIR"
ENDING = ".kernels"
_MAGIC = b"poisson kernels 2\n"
_DIGEST = 8

# Others may read what one user has compiled: in a container, what the administrator has put into the image.
_FOLDER_MODE, _FILE_MODE = 0o755, 0o644

# Settings of numba that change what it generates.
_SETTINGS = (
    "NUMBA_OPT",
    "NUMBA_CPU_NAME",
    "NUMBA_CPU_FEATURES",
    "NUMBA_LOOP_VECTORIZE",
    "NUMBA_SLP_VECTORIZE",
)

PATIENCE = 120.0  # seconds to wait for another process that compiles, before doing it oneself


class Refused(Exception):
    """A folder that cannot be used, and why."""


def folder() -> Path:
    """The user's cache folder for compiled kernels; it need not exist."""
    if chosen := os.environ.get(FOLDER_VARIABLE):
        return Path(chosen)
    home = Path(os.path.expanduser("~"))
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "poisson"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local")) / "poisson" / "Cache"
    base = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(base) if os.path.isabs(base) else home / ".cache") / "poisson"


def obstacle(place: Path) -> str | None:
    """Why nothing can be kept in a folder, as far as can be known before; None if all is well. The folder is made."""
    try:
        _make_folder(place)
    except (OSError, Refused) as error:
        return _said(error)
    return None if os.access(place, os.W_OK | os.X_OK) else f"{place} is not writable"


def _make_folder(place: Path) -> None:
    if not place.is_dir():
        place.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            place.mkdir(mode=_FOLDER_MODE)
    status = os.stat(place)
    if not stat.S_ISDIR(status.st_mode):
        raise Refused(f"{place} is not a folder")
    _check_safe(status, place)


def key_of(library: "Library", volume: str, host: str) -> str:
    """The hash of all that a volume's object code depends on: sources, compilers, machine."""
    this_package = os.path.dirname(_origin(__name__.rpartition(".")[0]))
    sources = [
        os.path.join(this_package, name) for name in sorted(os.listdir(this_package)) if name.endswith(".py")
    ]
    sources += [_origin(name) for name in (*library.modules, *library.ingredients)]
    parts = [volume.encode(), *(_content(path) for path in sources)]
    parts += [version_of("numba"), version_of("llvmlite"), host.encode()]
    parts += [(sys.implementation.cache_tag or "").encode()]
    parts += [os.environ.get(variable, "").encode() for variable in _SETTINGS]
    return importlib.util.source_hash(packed_list(parts)).hex()


def version_of(package: str) -> bytes:
    """What tells a package's version without importing it, nor the metadata of all packages, which take 20 ms."""
    spec = importlib.util.find_spec(package)
    if spec is not None and spec.submodule_search_locations:
        with contextlib.suppress(OSError):
            return _content(os.path.join(spec.submodule_search_locations[0], "_version.py"))
    from importlib.metadata import version

    return version(package).encode()


def _content(path: str) -> bytes:
    with open(path, "rb") as file:
        return file.read()


def _origin(module: str) -> str:
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        raise Refused(f"no source of {module}")
    return spec.origin


class Shelf:
    """The place of one compiled library.

    Parameters
    ----------
    key : str
        From `key_of`.

    Attributes
    ----------
    path : Path
    trouble : str or None
        Why it was not read or written.
    """

    def __init__(self, key: str, place: Path | None = None) -> None:
        self.path = (folder() if place is None else place) / f"{key}{ENDING}"
        self.trouble: str | None = None

    def read(self) -> bytes | None:
        """What lies there; None if nothing does, or nothing that can be trusted."""
        try:
            _check_safe(os.stat(self.path.parent), self.path.parent)
            descriptor = os.open(
                self.path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
            )
        except FileNotFoundError:
            return None
        except (OSError, Refused) as error:
            self.trouble = _said(error)
            return None
        with open(descriptor, "rb") as file:
            try:
                status = os.fstat(descriptor)
                if not stat.S_ISREG(status.st_mode):
                    raise Refused(f"{self.path} is not a file")
                _check_safe(status, self.path)
                return unpacked(file.read())
            except (OSError, Refused) as error:
                self.trouble = _said(error)
                return None

    def write(self, content: bytes) -> bool:
        """Put it there, whole or not at all; returns whether it is there now."""
        temporary = self.path.with_name(f".{self.path.stem[:16]}-{os.urandom(8).hex()}.tmp")
        try:
            _make_folder(self.path.parent)
            descriptor = os.open(
                temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), _FILE_MODE
            )
            try:
                with open(descriptor, "wb") as file:
                    file.write(packed(content))
                os.replace(temporary, self.path)
            except BaseException:
                with contextlib.suppress(OSError):
                    os.unlink(temporary)
                raise
        except (OSError, Refused) as error:
            self.trouble = _said(error)
            return False
        return True

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keeps other processes from doing the same work at the same time, as far as the system helps.

        The lock goes with the process that holds it, so nobody waits for a dead one, and nobody waits for ever.
        """
        descriptor = self._lock_file()
        if descriptor is None:
            yield
            return
        try:
            yield
        finally:
            os.close(descriptor)

    def _lock_file(self) -> int | None:
        try:
            import fcntl
        except ImportError:
            return None
        try:
            _make_folder(self.path.parent)
            flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW
            descriptor = os.open(self.path.parent / ".lock", flags, _FILE_MODE)
        except (OSError, Refused):
            return None
        end = monotonic() + PATIENCE
        while True:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return descriptor
            except BlockingIOError:
                if monotonic() > end:
                    break
                sleep(0.02)
            except OSError:
                break
        os.close(descriptor)
        return None


def packed_list(parts: Sequence[bytes]) -> bytes:
    """Several byte strings as one."""
    return b"".join(len(part).to_bytes(8, "little") + part for part in parts)


def unpacked_list(data: bytes) -> list[bytes]:
    """What `packed_list` was given; raises ValueError if that is not what this is."""
    parts = []
    at = 0
    while at < len(data):
        end = at + 8 + int.from_bytes(data[at : at + 8], "little")
        if end > len(data):
            raise ValueError("cut short")
        parts.append(data[at + 8 : end])
        at = end
    return parts


def packed(content: bytes) -> bytes:
    """Content with its head."""
    return _MAGIC + importlib.util.source_hash(content) + content


def unpacked(data: bytes) -> bytes:
    """Content without its head; raises `Refused` if it is damaged."""
    content = data[len(_MAGIC) + _DIGEST :]
    if data[: len(data) - len(content)] != _MAGIC + importlib.util.source_hash(content):
        raise Refused("a damaged file")
    return content


def _said(error: Exception) -> str:
    """An error in words: what, and why."""
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def _check_safe(status: os.stat_result, path: Any) -> None:
    """Raises `Refused` if someone else could have put this there."""
    if not hasattr(os, "geteuid"):
        return  # Windows: the user's own folder is closed to others by default
    if status.st_uid not in (os.geteuid(), 0):
        raise Refused(f"{path} belongs to another user")
    if stat.S_IMODE(status.st_mode) & 0o022:
        raise Refused(f"{path} can be written to by others")
