"""A command line as data: what is run, printed and shown is one and the same thing."""

from __future__ import annotations

import itertools
import shlex
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Command"]


@dataclass(frozen=True)
class Command:
    """A command line whose picture files lie in one folder.

    Parameters
    ----------
    text
        The line as it would be typed inside that folder, without ``poisson``: the tool, its pictures, then options.

    Examples
    --------
    >>> command = Command("clone bird.png sky.png -m mask.png --at 40,-12 -o out.png")
    >>> command.pictures
    ['bird.png', 'sky.png']
    >>> command.outputs
    ['out.png']
    >>> command.option("--at", "0,0")
    '40,-12'
    >>> Command("fill wall.png -m hole.png").line(Path("my gallery"))
    "poisson fill 'my gallery/wall.png' -m 'my gallery/hole.png'"
    """

    text: str

    @property
    def words(self) -> list[str]:
        """The tool and all that follows it."""
        return shlex.split(self.text)

    @property
    def pictures(self) -> list[str]:
        """The pictures that the tool works on: the words between its name and the first option."""
        return list(itertools.takewhile(lambda word: not word.startswith("-"), self.words[1:]))

    @property
    def outputs(self) -> list[str]:
        """The pictures that it writes, the result first."""
        words = ("-o", "--show-edges", "--preview")
        return [self.option(word, "") for word in words if word in self.words]

    def option(self, name: str, default: str) -> str:
        """The word after an option's name, or the default where the option is not given."""
        words = self.words
        return words[words.index(name) + 1] if name in words else default

    def argv(self, folder: Path) -> list[str]:
        """The words after ``poisson`` for someone who stands outside the folder."""
        return [str(folder / word) if word.endswith(".png") else word for word in self.words]

    def line(self, folder: Path) -> str:
        """The line to paste into a shell for someone who stands outside the folder."""
        return shlex.join(["poisson", *self.argv(folder)])
