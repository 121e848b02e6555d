"""Writing several picture files: all of them, or none."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from poisson_cli.errors import OutputError
from poisson_cli.images.picture import Picture
from poisson_cli.images.target import Target
from poisson_cli.images.writing import Committing, write

__all__ = ["refuse_doubles", "write_together"]


def refuse_doubles(targets: Sequence[Target]) -> None:
    """Refuse two outputs that are one file.

    Parameters
    ----------
    targets
        All outputs of one run.

    Raises
    ------
    OutputError
        Naming the file.
    """
    seen: set[Path] = set()
    for target in targets:
        where = target.real or target.path
        if where in seen and not (target.stream and target.real is not None):
            raise OutputError(f"{target.name}: two outputs would go into this file; give each its own name")
        seen.add(where)


def write_together(outputs: Sequence[tuple[Target, Picture]], before_commit: Committing = None) -> None:
    """Write pictures in their order; if one cannot be written, those before it are undone.

    Parameters
    ----------
    outputs
        Targets from `prepare`, no two of them the same file, and what to write there.
    before_commit
        Called when the first of them is about to take its name; see `write`.

    Raises
    ------
    OutputError
        As `write`; every target is as it was before.
    """
    if not outputs:
        return
    (target, picture), *rest = outputs
    if not rest:
        write(target, picture, before_commit)
        return
    with _undoing(target) as undo:
        write(target, picture, before_commit)
        try:
            write_together(rest)
        except BaseException:  # a signal as well
            undo()
            raise


@contextlib.contextmanager
def _undoing(target: Target) -> Iterator[Callable[[], None]]:
    """Keep what a file is now under another name, for as long as its replacement may have to be undone.

    Parameters
    ----------
    target
        The file; there need not be one yet.

    Yields
    ------
    callable
        Puts the old file back, or removes the new one if there was none.
    """
    if target.stream or target.real is None:
        yield lambda: None  # what has gone into a pipe is gone
        return
    real = target.real
    kept = real.with_name(f".poisson-{os.getpid()}-{os.urandom(8).hex()}.old")

    def undo() -> None:
        if kept.exists():
            os.replace(kept, real)
        else:
            real.unlink(missing_ok=True)

    try:
        if real.exists():
            try:
                _duplicate(real, kept)
            except OSError as error:
                raise OutputError(f"{target.path}: cannot be written ({error.strerror or error})") from error
        yield undo
    finally:
        kept.unlink(missing_ok=True)


def _duplicate(path: Path, other: Path) -> None:
    """Give a file's content a second name."""
    try:
        os.link(path, other)
    except OSError:  # a file system without hard links
        import shutil

        shutil.copy2(path, other)
