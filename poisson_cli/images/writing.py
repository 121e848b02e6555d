"""Writing a picture file: whole, or not at all.

The picture is encoded in memory, written to a temporary file beside the target and forced to the disk; only then does
it take the target's name. A full disk, an encoder's exception or a signal leave the old file as it was, or no file.
"""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path
from typing import Any

import numpy as np

from poisson_cli.errors import OutputError
from poisson_cli.images.codec import encoded
from poisson_cli.images.formats import Format
from poisson_cli.images.picture import Picture
from poisson_cli.images.target import Target

__all__ = ["encode", "save", "write"]


def write(target: Target, picture: Picture) -> None:
    """Write a picture.

    Parameters
    ----------
    target
        From `prepare`.
    picture
        What to write; an ICC profile goes along if the format can hold one.

    Raises
    ------
    OutputError
        If it cannot be encoded or written; the target is as it was before.
    """
    target.check_fits(picture)
    try:
        save(encode(picture, target.form), target.real, overwrite=target.overwrite)
    except FileExistsError as error:
        raise OutputError(f"{target.path}: appeared while we were at work; it is left alone") from error
    except OSError as error:
        raise OutputError(f"{target.path}: cannot be written ({error.strerror or error})") from error


def encode(picture: Picture, form: Format) -> bytes:
    """Encode a picture.

    Parameters
    ----------
    picture
        With no more channels than the format can hold.
    form
        The format.

    Returns
    -------
    bytes
        The file.
    """
    pixels = picture.pixels
    if picture.alpha is not None:
        pixels = np.dstack((pixels, picture.alpha))
    settings: dict[str, Any] = dict(form.encoding)
    if picture.profile is not None and form.can_hold_profile(picture.profile):
        settings["icc_profile"] = picture.profile
    return encoded(pixels, form, settings)


def save(data: bytes, path: Path, *, overwrite: bool) -> None:
    """Put bytes into a file in one step, as far as anyone can see.

    Parameters
    ----------
    data
        The whole file.
    path
        Where to; not a link. A new file gets the mode that the umask leaves, a replaced one keeps its mode.
    overwrite
        Whether to replace a file that is there.

    Raises
    ------
    FileExistsError
        If the file is there and may not be replaced, even if it appeared just now.
    OSError
        If it cannot be written.
    """
    # The name is settled before the file exists, so that no signal can come between the file and its removal.
    temporary = path.with_name(f".poisson-{os.urandom(8).hex()}.tmp")
    try:
        with open(temporary, "xb") as file:
            if overwrite and path.exists():
                os.chmod(temporary, stat.S_IMODE(path.stat().st_mode))
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if overwrite:
            os.replace(temporary, path)
        else:
            _name_if_free(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    _sync_folder(path.parent)


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


def _sync_folder(folder: Path) -> None:
    """Force the new name to the disk, where the system lets a folder be opened for that."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
