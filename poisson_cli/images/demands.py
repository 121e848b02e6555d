"""How the inputs of one run are read: which page, up to which size, and what is to be said about them.

Pictures are read in several places (as source, as destination, as mask), and all of them have to keep to the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field

from poisson_cli import defaults
from poisson_cli.errors import InputError

__all__ = ["Asking", "Sized", "asked", "asking"]


class Sized(Exception):
    """What a picture's header claims, instead of the picture, for somebody who asked for no more.

    Parameters
    ----------
    height, width
        In pixels, as they are stored.
    """

    def __init__(self, height: int, width: int) -> None:
        super().__init__(height, width)
        self.height, self.width = height, width


@dataclass
class Asking:
    """What is asked of every input.

    Parameters
    ----------
    page
        Which picture of a file that holds several, from 1; None: the first, with a notice.
    largest
        Pixels; a header that claims more is refused before memory is asked for.
    notices
        What the user should know about the inputs so far, a line each.
    paged
        Whether there was a file with several pictures.
    stdin_taken
        Whether the standard input, which can be read only once, has been.
    only_size
        Whether it is enough to know how large a picture is: `Sized` is raised as soon as that is known.
    """

    page: int | None = None
    largest: int = defaults.MAX_PIXELS
    notices: list[str] = field(default_factory=list)
    paged: bool = False
    stdin_taken: bool = False
    only_size: bool = False

    def choose(self, name: str, count: int, kind: str) -> int:
        """Choose one of a file's pictures.

        Parameters
        ----------
        name
            What the user calls the file.
        count
            How many pictures it holds.
        kind
            What they are called: ``pages`` or ``frames``.

        Returns
        -------
        int
            Index from 0.

        Raises
        ------
        InputError
            If there are not so many.
        """
        if count <= 1:
            return 0
        self.paged = True
        if self.page is None:
            self.notices.append(
                f"{name} holds {count} {kind}: the first one is used; --page N chooses another"
            )
            return 0
        if self.page > count:
            raise InputError(f"{name}: there is no page {self.page}, it holds {count} {kind}")
        return self.page - 1

    def refuse_unpaged(self) -> None:
        """Raise `InputError` if a page other than the first was asked for, but no input so far holds several."""
        if self.page is not None and self.page > 1 and not self.paged:
            raise InputError(f"--page {self.page}: no input holds several pages or frames")

    def refuse_large(self, name: str, width: int, height: int) -> None:
        """Refuse a picture without pixels, or with more than were asked for.

        Every decoder asks this as soon as it knows.
        """
        if self.only_size:
            raise Sized(height, width)
        if width < 1 or height < 1:
            raise InputError(f"{name}: a picture of {width}x{height} pixels, which is none")
        if width * height > self.largest:
            raise InputError(
                f"{name}: its header claims {width}x{height} pixels, more than the {self.largest:,} that are read; "
                "--max-pixels allows more"
            )


_CURRENT: ContextVar[Asking | None] = ContextVar("asking", default=None)


def asked() -> Asking:
    """What is asked at the moment."""
    return _CURRENT.get() or Asking()


@contextmanager
def asking(
    page: int | None = None, largest: int = defaults.MAX_PIXELS, *, only_size: bool = False
) -> Iterator[Asking]:
    """Ask for something while a ``with`` lasts; the parameters are those of `Asking`."""
    current = Asking(page, largest, only_size=only_size)
    token = _CURRENT.set(current)
    try:
        yield current
    finally:
        _CURRENT.reset(token)
