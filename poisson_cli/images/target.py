"""An output, looked at before any work is done for it.

A solve that ends in "cannot be written" is a solve wasted, so everything that can be known early is asked early.
`writing` meets the same obstacles again, in case they arise meanwhile.
"""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from pathlib import Path

from poisson_cli.errors import OutputError
from poisson_cli.images.formats import FORMATS, Format, by_extension, listed
from poisson_cli.images.picture import Picture

__all__ = ["Target", "prepare"]


@dataclass(frozen=True)
class Target:
    """A file that is going to be written.

    Parameters
    ----------
    path
        What the user calls it.
    real
        Where it lies, links followed.
    form
        Its format.
    overwrite
        Whether a file that is there may be replaced.
    """

    path: Path
    real: Path
    form: Format
    overwrite: bool

    def check_fits(self, picture: Picture) -> None:
        """Refuse a picture that the format cannot hold.

        Parameters
        ----------
        picture
            Any picture with the shape and channels of the one to be written.

        Raises
        ------
        OutputError
            If it has more channels than the format, or longer sides.
        """
        if picture.alpha is not None and not self.form.alpha:
            able = listed(tuple(known for known in FORMATS if known.alpha))
            raise OutputError(
                f"{self.path}: {self.form.name} cannot hold the {picture.channels} channels of {picture.name} "
                f"({picture.layout}); {able} can"
            )
        if max(picture.shape) > self.form.largest_side:
            raise OutputError(
                f"{self.path}: {self.form.name} holds at most {self.form.largest_side:,} pixels a side, "
                f"and {picture.name} is {picture.size}; choose another format"
            )


def prepare(path: Path, *, overwrite: bool) -> Target:
    """Check that a picture could be written to a path, as far as can be known before there is one.

    Parameters
    ----------
    path
        The file to write; a link is followed.
    overwrite
        Whether a file that is there may be replaced.

    Raises
    ------
    OutputError
        If the ending names no format, the folder is missing or not writable, the file is there and may not be
        replaced, or what is there is no regular file.
    """
    form = by_extension(path)
    if form is None:
        endings = ", ".join(known.extensions[0] for known in FORMATS)
        ending = f"the ending {path.suffix}" if path.suffix else "a name without an ending"
        raise OutputError(f"{path}: {ending} does not tell a picture format; use {endings}")
    try:
        real = Path(os.path.realpath(path))
        refuse_obstacles(path, real, overwrite=overwrite)
    except OSError as error:  # a name too long, a loop of links
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error
    return Target(path=path, real=real, form=form, overwrite=overwrite)


def refuse_obstacles(path: Path, real: Path, *, overwrite: bool) -> None:
    """Refuse what stands in a file's way.

    Parameters
    ----------
    path
        What the user calls the file.
    real
        Where it lies, links followed.
    overwrite
        Whether a file that is there may be replaced.

    Raises
    ------
    OutputError
        As `prepare`.
    OSError
        If the file system cannot tell.
    """
    folder = real.parent
    if not folder.is_dir():
        raise OutputError(f"{path}: there is no folder {folder}; make it first")
    try:
        kind = real.lstat().st_mode
    except FileNotFoundError:
        pass
    else:
        if stat.S_ISDIR(kind):
            raise OutputError(f"{path}: a folder; name a file in it")
        if not stat.S_ISREG(kind):
            raise OutputError(f"{path}: not a regular file; it is left alone")
        if not overwrite:
            raise OutputError(
                f"{path}: exists already; add --overwrite to replace it, or choose another name"
            )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: the folder {folder} is not writable")
