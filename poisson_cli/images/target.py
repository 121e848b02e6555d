"""An output, looked at before any work is done for it.

A solve that ends in "cannot be written" is a solve wasted, so everything that can be known early is asked early.
`writing` meets the same obstacles again, in case they arise meanwhile.
"""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path
from typing import NamedTuple

from poisson_cli.errors import OutputError
from poisson_cli.images.depth import in_words
from poisson_cli.images.formats import TIFF, WRITTEN, Format, by_extension, listed
from poisson_cli.images.picture import Picture
from poisson_cli.streams import STANDARD, is_standard_output, missing

__all__ = ["Target", "format_for", "prepare"]


class Target(NamedTuple):
    """A file that is going to be written.

    Parameters
    ----------
    path
        What the user calls it.
    real
        Where it lies, links followed; None for the standard output.
    form
        Its format.
    overwrite
        Whether a file that is there may be replaced.
    stream
        Whether it is a pipe or a device, or the standard output: written into, never replaced.
    quality
        Of a lossy format, 1 to 100; None leaves it to the format.
    grey
        Whether its name says that it is grey.
    """

    path: Path
    real: Path | None
    form: Format
    overwrite: bool = False
    stream: bool = False
    quality: int | None = None
    grey: bool = False

    @property
    def name(self) -> str:
        """What to call it in messages."""
        return str(self.path) if self.real is not None else "standard output"

    def check_fits(self, picture: Picture) -> None:
        """Refuse a picture that the format cannot hold.

        Parameters
        ----------
        picture
            Any picture with the shape, channels and depth of the one to be written.

        Raises
        ------
        OutputError
            If it has more channels than the format, longer sides, or another depth. An alpha channel that is opaque
            everywhere does not count: nothing is lost without it.
        """
        form = self.form
        if self.grey and picture.pixels.ndim == 3:
            raise OutputError(
                f"{self.name}: a PGM is grey, and {picture.name} is {picture.layout}; name it .ppm"
            )
        if not form.alpha and not picture.opaque:
            able = listed(tuple(known for known in WRITTEN if known.alpha and picture.depth in known.depths))
            raise OutputError(
                f"{self.name}: {form.name} cannot hold the {picture.channels} channels of {picture.name} "
                f"({picture.layout}, transparent in places); {able} can"
            )
        if picture.depth not in form.depths:
            able = listed(tuple(known for known in WRITTEN if picture.depth in known.depths))
            raise OutputError(
                f"{self.name}: {form.name} cannot hold the depth of {picture.name} ({in_words(picture.depth)}); "
                f"{able} can, or add --bit-depth {form.depths[-1]} to convert it"
            )
        if max(picture.shape) > form.largest_side:
            raise OutputError(
                f"{self.name}: {form.name} holds at most {form.largest_side:,} pixels a side, "
                f"and {picture.name} is {picture.size}; choose another format"
            )


def prepare(
    path: Path, *, overwrite: bool = False, form: str | None = None, quality: int | None = None
) -> Target:
    """Check that a picture could be written to a path, as far as can be known before there is one.

    Parameters
    ----------
    path
        The file to write; a link is followed. ``-`` is the standard output.
    overwrite
        Whether a file that is there may be replaced.
    form
        Ending that tells the format, without its dot; None: that of the path.
    quality
        For JPEG and WebP, 1 to 100; None leaves it to the format.

    Raises
    ------
    OutputError
        If nothing tells the format, the folder is missing or not writable, the file is there and may not be
        replaced, or what is there can be neither replaced nor written into.
    """
    known = format_for(path, form=form, quality=quality)
    if is_standard_output(path):
        if missing(sys.stdout):
            raise OutputError("standard output: it is closed; name a file with -o")
        if sys.stdout.isatty():
            raise OutputError(
                "standard output: a terminal; send it into a file or a pipe, or name a file with -o"
            )
        return Target(path, None, known, overwrite, stream=True, quality=quality)
    try:
        real = Path(os.path.realpath(path))
        stream = _is_stream(path)
        if not stream:
            refuse_obstacles(path, real, overwrite=overwrite)
    except OSError as error:  # a name too long, a loop of links
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error
    grey = form is None and path.suffix.lower() == ".pgm"
    return Target(path, path if stream else real, known, overwrite, stream, quality, grey)


def format_for(path: Path, *, form: str | None = None, quality: int | None = None) -> Format:
    """What a picture would be written as, which is known before there is any.

    Parameters
    ----------
    path, form, quality
        As in `prepare`.

    Raises
    ------
    OutputError
        If nothing tells the format, it cannot be written here, or it has no quality to choose.
    """
    known = by_extension(path if form is None else Path(f"picture.{form}"))
    if known is None and str(path) == os.devnull:
        known = TIFF  # which can hold anything
    if known is None:
        raise OutputError(f"{path}: {_no_format(path)}")
    if known.absent is not None:
        raise OutputError(f"{path}: {known.absent}")
    if quality is not None and not known.quality:
        able = listed(tuple(known for known in WRITTEN if known.quality))
        raise OutputError(f"{path}: {known.name} has no quality to choose; leave --quality to {able}")
    return known


def _no_format(path: Path) -> str:
    if str(path) == STANDARD:
        return (
            "the standard output has no ending to tell a picture format; add --format, such as --format png"
        )
    endings = ", ".join(known.extensions[0] for known in WRITTEN)
    ending = f"the ending {path.suffix}" if path.suffix else "a name without an ending"
    return f"{ending} does not tell a picture format; use {endings}, or add --format"


def _is_stream(path: Path) -> bool:
    """Whether what is there is written into: a pipe, or a device such as /dev/null."""
    try:
        kind = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    return stat.S_ISFIFO(kind) or stat.S_ISCHR(kind)


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
    protected = False
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
        protected = not os.access(real, os.W_OK)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: the folder {folder} is not writable")
    if protected:
        raise OutputError(f"{path}: exists, and is protected against writing; choose another name")
