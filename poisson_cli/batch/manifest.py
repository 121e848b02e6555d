"""A manifest: JSON Lines or CSV, one job a line.

The two are told apart by their first character, so that standard input needs no name. The cells of CSV may be divided
by commas, or by semicolons or tabs, as spreadsheets do in half of the world: names have none of them, so the first
line tells. What the names and values mean is not asked here; see `poisson_cli.batch.grammar`.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NoReturn

from poisson_cli.batch.mistakes import Mistake

__all__ = ["Entry", "Manifest", "parse"]

Pairs = tuple[tuple[str, Any], ...]
"""Names and values in the order in which they are said, which for a selection makes a difference."""

DEFAULTS: Final = "defaults"


@dataclass(frozen=True)
class Entry:
    """One job as it is written down.

    Parameters
    ----------
    line
        Where, from 1.
    pairs
        Names and values. Text stands for what it would mean on the command line; other JSON values are allowed.
    """

    line: int
    pairs: Pairs


@dataclass
class Manifest:
    """What a manifest holds.

    Parameters
    ----------
    entries
        The jobs.
    defaults
        What is said once for all of them.
    columns
        The names in the head of CSV, if it is that.
    head
        The line that they are in.
    mistakes
        The lines that make no sense.
    """

    entries: list[Entry] = field(default_factory=list)
    defaults: Entry = Entry(0, ())
    columns: tuple[str, ...] = ()
    head: int = 0
    mistakes: list[Mistake] = field(default_factory=list)


def parse(data: bytes) -> Manifest:
    """Read a manifest.

    Parameters
    ----------
    data
        UTF-8 text.

    Returns
    -------
    Manifest
        All that could be read of it, and the mistakes in the rest.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        return Manifest(mistakes=[Mistake(line, "not UTF-8 text; save the manifest as that")])
    return _json_lines(text) if text.lstrip().startswith(("{", "[")) else _csv(text)


def _json_lines(text: str) -> Manifest:
    """One object a line. Lines end with a line feed: others, such as U+2028, may stand in a JSON text."""
    manifest = Manifest()
    first = True
    for number, line in enumerate(text.split("\n"), start=1):
        if not line.strip():
            continue
        try:
            pairs = _pairs(line)
            if first and [name for name, _ in pairs] == [DEFAULTS]:
                if not isinstance(pairs[0][1], dict):
                    raise ValueError('"defaults" is no object, as in {"defaults": {"tolerance": 0.001}}')
                manifest.defaults = Entry(number, tuple(pairs[0][1].items()))
            elif any(name == DEFAULTS for name, _ in pairs):
                raise ValueError('"defaults" belong into the first line, and nothing else beside them')
            else:
                manifest.entries.append(Entry(number, pairs))
        except (ValueError, RecursionError) as error:
            if first and _is_one_document(text):
                wrong = (
                    "JSON over several lines; write each job in one, as `jq -c .[]` does with a list of them"
                )
                return Manifest(mistakes=[Mistake(number, wrong)])
            manifest.mistakes.append(Mistake(number, str(error)))
        first = False
    return manifest


def _is_one_document(text: str) -> bool:
    """Whether this is a single JSON value of several lines, made by somebody who did not know that it is one a line."""
    if "\n" not in text.strip():
        return False
    try:
        json.loads(text)
    except (ValueError, RecursionError):
        return False
    return True


def _pairs(line: str) -> Pairs:
    """The names and values of one object; ValueError says what is wrong with it."""
    try:
        value = json.loads(line, object_pairs_hook=_object, parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        raise ValueError(f"not JSON: {error.msg} at character {error.colno}") from error
    if isinstance(value, list):
        raise ValueError("a JSON list; write each job in a line of its own, as `jq -c .[]` does")
    if not isinstance(value, dict):
        raise ValueError('not a JSON object, as in {"tool": "fill", "image": "a.png", ...}')
    return tuple(value.items())


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object that says nothing twice."""
    made: dict[str, Any] = {}
    for name, value in pairs:
        if name in made:
            raise ValueError(f'"{name}" is there twice; give a list if it may be repeated')
        made[name] = value
    return made


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number")


def _csv(text: str) -> Manifest:
    """A head with names, and a row for each job; an empty cell says nothing, a repeated name repeats an option."""
    manifest = Manifest()
    for line, row in _rows(text):
        try:
            cells = [cell.strip() for cell in _readable(row)]
            if not any(cells):
                continue
            if not manifest.columns:
                if "" in cells:
                    raise ValueError(f"not CSV: column {cells.index('') + 1} has no name")
                manifest.columns, manifest.head = tuple(cells), line
            elif len(cells) != len(manifest.columns):
                raise ValueError(
                    f"{len(cells)} cells, but the first line names {len(manifest.columns)} columns"
                )
            else:
                pairs = tuple(pair for pair in zip(manifest.columns, cells, strict=True) if pair[1])
                manifest.entries.append(Entry(line, pairs))
        except ValueError as error:
            manifest.mistakes.append(Mistake(line, str(error)))
            if not manifest.columns:
                break
    return manifest


def _rows(text: str) -> Iterator[tuple[int, Sequence[str] | csv.Error]]:
    """Each row, or what is wrong with it, with the line in which it begins."""
    lines = list(io.StringIO(text, newline=""))
    head = next((line for line in lines if line.strip()), "")
    divider = next((one for one in ";\t" if one in head and "," not in head), ",")
    reader = csv.reader(lines, strict=True, delimiter=divider)
    while True:
        line = reader.line_num + 1
        try:
            yield line, next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            yield line, error


def _readable(row: Sequence[str] | csv.Error) -> Sequence[str]:
    if isinstance(row, csv.Error):
        raise ValueError(f"not CSV: {row}")
    return row
