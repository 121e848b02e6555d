"""Types of command-line values. Here, and nowhere else, X,Y of the command line becomes row, column."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Final

import click

if TYPE_CHECKING:
    from pathlib import Path

    from click.shell_completion import CompletionItem

    from poisson_cli.settings import Rectangle

__all__ = ["COUNT", "EIGHT_BIT", "FILE", "POINT", "POSITIVE", "QUALITY", "RECTANGLE"]

_INTEGER: Final = re.compile(r"[+-]?[0-9]{1,9}")
"""At most nine digits: any picture fits, and no sum or product of two of them leaves 64 bits."""


class _Integers(click.ParamType):  # type: ignore[type-arg]  # generic in new versions of click only
    """Integers separated by commas, one for each field of the name."""

    def __init__(self, name: str, example: str) -> None:
        self.name = name
        self._count = name.count(",") + 1
        self._example = example

    def numbers(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> list[int]:
        fields = [field.strip() for field in value.split(",")]
        if len(fields) != self._count or not all(map(_INTEGER.fullmatch, fields)):
            example = f"whole numbers of pixels, for example {self._example}"
            self.fail(f"{value!r} is not {self.name}: {example}", param, ctx)
        return [int(field) for field in fields]


class _Point(_Integers):
    """``X,Y``, converted to (row, column)."""

    def convert(
        self, value: str | tuple[int, int], param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        if isinstance(value, tuple):  # converted already
            return value
        x, y = self.numbers(value, param, ctx)
        return y, x


class _Rectangle(_Integers):
    """``X,Y,W,H``, converted to a `Rectangle`."""

    def convert(
        self, value: str | Rectangle, param: click.Parameter | None, ctx: click.Context | None
    ) -> Rectangle:
        from poisson_cli.settings import Rectangle

        if isinstance(value, Rectangle):
            return value
        x, y, width, height = self.numbers(value, param, ctx)
        if width < 1 or height < 1:
            self.fail(f"{value!r} has no area: W and H must be at least 1", param, ctx)
        return Rectangle(row=y, col=x, height=height, width=width)


class _File(click.ParamType):  # type: ignore[type-arg]
    """A path as typed; whether it can be read or written is no matter of usage, so it is not asked here."""

    name = "path"

    def convert(self, value: str | Path, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        from pathlib import Path

        from poisson_cli.streams import STANDARD

        if "\0" in str(value):
            self.fail("a path cannot hold a null character", param, ctx)
        path = Path(value)
        # `Path` takes ./- for -, which stands for the standard streams.
        return path.absolute() if str(path) == STANDARD != str(value) else path

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Leave it to the shell, which knows the files."""
        from click.shell_completion import CompletionItem

        return [CompletionItem(incomplete, type="file")]


class _Between(click.ParamType):  # type: ignore[type-arg]
    """A whole number between two, both allowed (click's IntRange writes its bounds into the help a second time)."""

    name = "whole number"

    def __init__(self, least: int, most: int) -> None:
        self._least = least
        self._most = most

    def convert(self, value: str | int, param: click.Parameter | None, ctx: click.Context | None) -> int:
        if isinstance(value, int):
            return value
        if not _INTEGER.fullmatch(value) or not self._least <= int(value) <= self._most:
            self.fail(f"{value!r} is not a whole number from {self._least} to {self._most}", param, ctx)
        return int(value)


class _Positive(click.ParamType):  # type: ignore[type-arg]
    """A finite number greater than zero (click's FLOAT lets nan and inf through)."""

    name = "number"

    def convert(self, value: str | float, param: click.Parameter | None, ctx: click.Context | None) -> float:
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and number > 0):
            self.fail(f"{value!r} is not a number greater than 0", param, ctx)
        return number


FILE: Final = _File()
POINT: Final = _Point("X,Y", "40,-12")
RECTANGLE: Final = _Rectangle("X,Y,W,H", "10,20,300,200")
EIGHT_BIT: Final = _Between(1, 255)
QUALITY: Final = _Between(1, 100)
COUNT: Final = _Between(1, 999_999_999)
POSITIVE: Final = _Positive()
