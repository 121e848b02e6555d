"""What is wrong with a manifest: all of it at once, because nobody mends ten thousand lines one run at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

from poisson_cli import errors

__all__ = ["Mistake", "Mistakes"]


class Mistake(NamedTuple):
    """One thing that is wrong.

    Parameters
    ----------
    line
        Of the manifest, from 1; 0 for what is wrong with all of it.
    text
        What, and what to do.
    """

    line: int
    text: str


class Mistakes(errors.PoissonError, ValueError):
    """A manifest that is wrong; no job was run.

    Parameters
    ----------
    found
        At least one, in the order of the lines.
    name
        What to call the manifest.
    """

    exit_code: ClassVar[int] = errors.USAGE

    def __init__(self, found: Sequence[Mistake], name: str = "job") -> None:
        self.found = tuple(found)
        self.name = name
        super().__init__("; ".join(self.lines()))

    def lines(self) -> list[str]:
        """One line each, such as ``jobs.csv:17: "source" is missing``."""
        return [
            f"{self.name}:{mistake.line}: {mistake.text}" if mistake.line else f"{self.name}: {mistake.text}"
            for mistake in self.found
        ]

    def __reduce__(self) -> tuple[type[Mistakes], tuple[tuple[Mistake, ...], str]]:
        return Mistakes, (self.found, self.name)
