"""Types of command-line values. Here, and nowhere else, X,Y of the command line becomes row, column."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Final, Literal

import click

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from click.shell_completion import CompletionItem

    from poisson_cli.settings import Ellipse, MaskFile, Polygon, Rectangle

__all__ = [
    "COUNT",
    "EIGHT_BIT",
    "ELLIPSE",
    "FACTOR",
    "FACTORS",
    "FACTOR_ABOVE_0",
    "FILE",
    "LASSO",
    "MASK",
    "NOT_NEGATIVE",
    "NUMBER",
    "POINT",
    "POLYGON",
    "POSITIVE",
    "QUALITY",
    "RECTANGLE",
    "SHARD",
    "SIZE",
    "is_file",
    "separators",
    "within",
]

LARGEST_FACTOR: Final = 1000
"""Of what multiplies colours or gradients; that of the tools."""

_INTEGER: Final = re.compile(r"[+-]?[0-9]{1,9}")
"""At most nine digits: any picture fits, and no sum or product of two of them leaves 64 bits."""


class _Integers(click.ParamType):  # type: ignore[type-arg]  # generic in new versions of click only
    """Integers separated by commas, one for each field of the name."""

    separators = (",",)

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


class _Ellipse(_Rectangle):
    """``X,Y,W,H`` of the rectangle around it, converted to an `Ellipse`."""

    def convert(  # type: ignore[override]
        self, value: str | Ellipse, param: click.Parameter | None, ctx: click.Context | None
    ) -> Ellipse:
        from poisson_cli.settings import Ellipse

        return value if isinstance(value, Ellipse) else Ellipse(super().convert(value, param, ctx))


class _Polygon(click.ParamType):  # type: ignore[type-arg]
    """``X,Y X,Y ...``, fractions allowed, converted to a `Polygon`."""

    name = "x,y x,y ..."
    separators = (" ", ",")

    def __init__(self, rule: Literal["even-odd", "nonzero"]) -> None:
        self._rule = rule

    def convert(
        self, value: str | Polygon, param: click.Parameter | None, ctx: click.Context | None
    ) -> Polygon:
        from poisson_cli.errors import InputError
        from poisson_cli.masks.points import parse_points
        from poisson_cli.settings import Polygon

        if isinstance(value, Polygon):
            return value
        try:
            return Polygon(parse_points(value), self._rule)
        except InputError as error:
            self.fail(str(error), param, ctx)


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


class _MaskFile(_File):
    """A path, perhaps with a colon and a part of the file behind it, converted to a `MaskFile`."""

    def convert(  # type: ignore[override]
        self, value: str | MaskFile, param: click.Parameter | None, ctx: click.Context | None
    ) -> MaskFile:
        from poisson_cli.settings import MaskFile

        if isinstance(value, MaskFile):
            return value
        super().convert(value, param, ctx)
        return MaskFile(value)


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


def _finite(text: str | float) -> float:
    """A finite number, or nan for anything else (click's FLOAT lets nan and inf through)."""
    try:
        number = float(text)
    except ValueError:
        return math.nan
    return number if math.isfinite(number) else math.nan


class _Number(click.ParamType):  # type: ignore[type-arg]
    """A finite number, and what it must be."""

    name = "number"

    def __init__(self, requirement: str, allowed: Callable[[float], bool]) -> None:
        self._requirement = requirement
        self._allowed = allowed

    def convert(self, value: str | float, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number = _finite(value)
        if not self._allowed(number):
            self.fail(f"{value!r} is not a number{self._requirement}", param, ctx)
        return number


def within(low: float, high: float, *, above_low: bool = False) -> _Number:
    """Numbers in a range: from `low`, or above it, to `high`.

    Those are the bounds that the tools have; said here, they are seen before anything is read.
    """
    if above_low:
        return _Number(f" greater than {low:g} and at most {high:g}", lambda number: low < number <= high)
    return _Number(f" from {low:g} to {high:g}", lambda number: low <= number <= high)


class _Factors(click.ParamType):  # type: ignore[type-arg]
    """``R,G,B``: a factor from 0 to 1000 for each colour."""

    name = "R,G,B"
    separators = (",",)

    def convert(
        self,
        value: str | tuple[float, float, float],
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> tuple[float, float, float]:
        if isinstance(value, tuple):
            return value
        factors = [_finite(field) for field in value.split(",")]
        if len(factors) != 3 or not all(0 <= factor <= LARGEST_FACTOR for factor in factors):
            self.fail(
                f"{value!r} is not R,G,B: three numbers from 0 to {LARGEST_FACTOR:g}, for example 1.5,.5,.5",
                param,
                ctx,
            )
        red, green, blue = factors
        return red, green, blue


class _Shard(click.ParamType):  # type: ignore[type-arg]
    """``I/N``, the I-th of N equal shares, converted to (I, N)."""

    name = "I/N"

    def convert(
        self, value: str | tuple[int, int], param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        fields = value.split("/")
        if len(fields) != 2 or not all(re.fullmatch("[0-9]{1,9}", field) for field in fields):
            self.fail(f"{value!r} is not I/N, for example 1/4: the first of four shares", param, ctx)
        share, shares = map(int, fields)
        if not 1 <= share <= shares:
            self.fail(f"{value!r} is no share: the first of {shares} is 1/{shares}", param, ctx)
        return share, shares


class _Size(click.ParamType):  # type: ignore[type-arg]
    """A number of bytes, such as ``800M`` or ``1.5G``."""

    name = "size"
    _units: Final = {"": 1, "K": 1 << 10, "M": 1 << 20, "G": 1 << 30, "T": 1 << 40}

    def convert(self, value: str | int, param: click.Parameter | None, ctx: click.Context | None) -> int:
        if isinstance(value, int):
            return value
        match = re.fullmatch(r"([0-9]{1,15}(?:\.[0-9]{1,9})?)([KMGT]?)(?:i?B)?", value.strip(), re.IGNORECASE)
        size = 0 if match is None else int(float(match[1]) * self._units[match[2].upper()])
        if size < 1:
            self.fail(f"{value!r} is no amount of memory, for example 800M or 1.5G", param, ctx)
        return size


def separators(kind: click.ParamType) -> tuple[str, ...]:  # type: ignore[type-arg]
    """What stands between the numbers of a value that is a list of them, or a list of lists, outermost first."""
    found: tuple[str, ...] = getattr(kind, "separators", ())
    return found


def is_file(kind: click.ParamType) -> bool:  # type: ignore[type-arg]
    """Whether a value is the name of a file, perhaps with a part of it behind a colon."""
    return isinstance(kind, _File)


FILE: Final = _File()
MASK: Final = _MaskFile()
POINT: Final = _Point("X,Y", "40,-12")
RECTANGLE: Final = _Rectangle("X,Y,W,H", "10,20,300,200")
ELLIPSE: Final = _Ellipse("X,Y,W,H", "10,20,300,200")
POLYGON: Final = _Polygon("even-odd")
LASSO: Final = _Polygon("nonzero")
EIGHT_BIT: Final = _Between(1, 255)
QUALITY: Final = _Between(1, 100)
COUNT: Final = _Between(1, 999_999_999)
FACTOR: Final = within(0, LARGEST_FACTOR)
FACTOR_ABOVE_0: Final = within(0, LARGEST_FACTOR, above_low=True)
NUMBER: Final = _Number("", lambda number: not math.isnan(number))
NOT_NEGATIVE: Final = _Number(", 0 or greater", lambda number: number >= 0)
POSITIVE: Final = _Number(" greater than 0", lambda number: number > 0)
FACTORS: Final = _Factors()
SHARD: Final = _Shard()
SIZE: Final = _Size()
