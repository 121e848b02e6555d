"""Writing a picture file: whole, or not at all.

The picture is encoded in memory, written to a file that has no name yet, or a temporary one where every file must have
one, and forced to the disk; only then does it take the target's name. A full disk, an encoder's exception or a signal
leave the old file as it was, or no file.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import stat
import sys
from collections.abc import Callable
from io import FileIO
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from poisson_cli.errors import OutputError
from poisson_cli.images.formats import JPEG, Format
from poisson_cli.images.metadata import Kind, Metadata
from poisson_cli.images.picture import Picture
from poisson_cli.images.target import Target

__all__ = ["Committing", "encode", "fitting", "save", "settle", "settle_later", "write"]

_JPEG_BLOCK: Final = 65_000

Committing = Callable[[], None] | None
"""Called when an output is about to take its name."""


def write(target: Target, picture: Picture, before_commit: Committing = None) -> None:
    """Write a picture.

    Parameters
    ----------
    target
        From `prepare`.
    picture
        What to write; what belongs to it goes along as far as the format can hold it, see `fitting`.
    before_commit
        Called when all is on the disk but the name, or when a stream has taken all: from here on the run is not to
        be stopped any more.

    Raises
    ------
    OutputError
        If it cannot be encoded or written; the target is as it was before.
    BrokenPipeError
        If nobody reads the stream.
    """
    target.check_fits(picture)
    try:
        data = encode(picture, target.form, target.quality)
        if target.stream:
            _send(data, target.real)
            if before_commit is not None:
                before_commit()
        else:
            assert target.real is not None
            save(data, target.real, overwrite=target.overwrite, before_commit=before_commit)
    except BrokenPipeError:
        raise
    except FileExistsError as error:
        raise OutputError(f"{target.name}: appeared while we were at work; it is left alone") from error
    except OSError as error:
        raise OutputError(f"{target.name}: cannot be written ({error.strerror or error})") from error


def encode(picture: Picture, form: Format, quality: int | None = None) -> bytes:
    """Encode a picture.

    Parameters
    ----------
    picture
        With no more channels than the format can hold, and in one of its depths.
    form
        The format.
    quality
        Of a lossy one, 1 to 100; None leaves it to the format.

    Returns
    -------
    bytes
        The file.

    Raises
    ------
    OutputError
        If the format needs a package that is not there, or cannot hold this picture.
    """
    if picture.alpha is not None and not form.alpha and picture.opaque:
        picture = picture._replace(alpha=None)
    if picture.pixels.ndim == 2 and not form.grey:
        picture = picture._replace(pixels=np.repeat(picture.pixels[..., np.newaxis], 3, axis=2))
    metadata = fitting(picture.metadata, form)[0].of_size(*picture.shape)
    picture = picture._replace(metadata=metadata)
    codec = importlib.import_module(f"poisson_cli.images.codecs.{form.codec}")
    data: bytes = codec.encode(picture, form, quality)
    return data


def fitting(metadata: Metadata, form: Format) -> tuple[Metadata, tuple[Kind, ...]]:
    """What of the metadata a format can hold, and the kinds that have to stay behind."""
    stay = [kind for kind in metadata.kinds() if kind not in form.carries]
    if metadata.profile is not None and "profile" not in stay and not form.can_hold_profile(metadata.profile):
        stay.append("profile")
    if form is JPEG:  # in which a block has at most 64 KiB
        for kind, block in (("exif", metadata.exif), ("xmp", metadata.xmp), ("iptc", metadata.iptc)):
            if block is not None and len(block) > _JPEG_BLOCK:
                stay.append(kind)
    return metadata._replace(**dict.fromkeys(stay)), tuple(stay)


def _send(data: bytes, path: Path | None) -> None:
    """Write into the standard output (None), a pipe or a device: all of it, as far as they take it."""
    if path is None:
        sys.stdout.flush()
        _write_all(sys.stdout.buffer, data)
        return
    with open(path, "wb", buffering=0, opener=lambda name, flags: os.open(name, os.O_WRONLY)) as file:
        _write_all(file, data)


def _write_all(file: BinaryIO | FileIO, data: bytes) -> None:
    """Write on until all is written: a file without a buffer, and stdout may be one, takes a part and says how much."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) or 0 :]
    file.flush()


def save(data: bytes, path: Path, *, overwrite: bool, before_commit: Committing = None) -> None:
    """Put bytes into a file in one step, as far as anyone can see.

    Parameters
    ----------
    data
        The whole file.
    path
        Where to; not a link. A new file gets the mode that the umask leaves, a replaced one keeps its mode, and
        its owner if that can be.
    overwrite
        Whether to replace a file that is there.
    before_commit
        Called when only the name is missing.

    Raises
    ------
    FileExistsError
        If the file is there and may not be replaced, even if it appeared just now.
    OSError
        If it cannot be written.
    """
    # The name is settled before the file exists, so that no signal can come between the file and its removal.
    temporary = path.with_name(f".poisson-{os.getpid()}-{os.urandom(8).hex()}.tmp")
    try:
        old = path.stat() if overwrite and path.exists() else None
        wanted = temporary if overwrite else path
        if not _write_nameless(data, wanted, old, before_commit):
            with open(temporary, "xb") as file:
                _write_through(data, file, old)
            if before_commit is not None:
                before_commit()
            if not overwrite:
                _name_if_free(temporary, path)
        if overwrite:
            os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    if not _later:
        settle(path.parent)


def _write_nameless(data: bytes, path: Path, old: os.stat_result | None, before_commit: Committing) -> bool:
    """Write a file that has no name before all of it is on the disk, so that not even SIGKILL leaves a part of it.

    Returns
    -------
    bool
        False where that cannot be done: it is for Linux, and some of its file systems.

    Raises
    ------
    FileExistsError
        If the name is taken.
    """
    if not hasattr(os, "O_TMPFILE"):
        return False
    with contextlib.ExitStack() as stack:
        try:
            folder = os.open(path.parent, os.O_RDONLY)
            stack.callback(os.close, folder)
            descriptor = os.open(path.parent, os.O_TMPFILE | os.O_WRONLY, 0o666)
        except OSError:
            return False
        file = stack.enter_context(open(descriptor, "wb"))
        _write_through(data, file, old)
        if before_commit is not None:
            before_commit()
        try:
            # With a folder's descriptor it is linkat(2), which alone follows the link to the file.
            os.link(f"/proc/self/fd/{descriptor}", path.name, dst_dir_fd=folder)
        except FileExistsError:
            raise
        except OSError:
            return False
    return True


def _write_through(data: bytes, file: BinaryIO, old: os.stat_result | None) -> None:
    """Write a whole file to the disk itself, for the owner and in the mode of the one that it replaces, if any."""
    if old is not None:
        if hasattr(os, "chown"):
            with contextlib.suppress(OSError):  # only root may give files away
                os.chown(file.fileno(), old.st_uid, old.st_gid)
        os.chmod(file.fileno(), stat.S_IMODE(old.st_mode))
    file.write(data)
    file.flush()
    os.fsync(file.fileno())


def _name_if_free(temporary: Path, path: Path) -> None:
    """Give a finished file its name unless the name is taken: no moment in between for anyone else to take it."""
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links: take the name with an empty file, then replace that
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
        try:
            os.replace(temporary, path)
        except BaseException:
            path.unlink(missing_ok=True)
            raise


_later = False


def settle_later() -> None:
    """Leave it to whoever started this process to force new names to the disk, once for many files in a folder.

    Until then a power failure may take a name, and the file with it, but not a part of a file.
    """
    global _later
    _later = True


def settle(folder: Path) -> None:
    """Force new names in a folder to the disk, where the system lets one be opened for that."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
