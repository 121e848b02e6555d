"""What a line of a manifest may say: the arguments and options of the command that it names, and nothing else.

There is no second list of options. A line becomes the words of a command line, and click, which declares the options,
reads them: so names, types, defaults, rules and error messages are those of the command.
"""

from __future__ import annotations

import difflib
import functools
import json
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import click

from poisson_cli import options, params
from poisson_cli.batch.manifest import Pairs

__all__ = ["SELECTION", "TOOL", "Tool", "key_of", "tools"]

TOOL: Final = "tool"
"""The name under which a line names its command."""

SELECTION: Final = "selection"
"""The name of a list of steps, for a selection in which something comes twice; `poisson_cli.masks.plan` has it too."""

_SWITCHES: Final = ("add", "subtract", "intersect")


@dataclass(frozen=True)
class Tool:
    """A command whose jobs a batch can do.

    Parameters
    ----------
    name
        Of the command.
    command
        As click has it.
    keys
        What a line may say, by the name under which it does.
    """

    name: str
    command: click.Command
    keys: Mapping[str, click.Parameter]

    @property
    def selects(self) -> bool:
        """Whether it takes a selection, and so the steps of one."""
        return {"mask", *_SWITCHES} <= self.keys.keys()

    def knows(self, name: str) -> bool:
        """Whether a line may say this."""
        return key_of(name) in self.keys or (self.selects and key_of(name) == SELECTION)

    def words(self, pairs: Pairs, folder: str) -> list[str]:
        """What would be said on the command line.

        Parameters
        ----------
        pairs
            A line, without the tool.
        folder
            What paths in it are relative to.

        Returns
        -------
        list of str
            Options in the order of the line, steps of a selection after them, then the arguments.

        Raises
        ------
        ValueError
            If the line says what the command does not know, or not all that it needs.
        """
        given: dict[str, list[str]] = {}
        spoken: list[str] = []
        steps: list[str] = []
        for name, value in pairs:
            if value is None:
                continue
            key = key_of(name)
            if key == SELECTION and self.selects:
                steps += self._steps(value, folder)
                continue
            parameter = self.keys.get(key)
            if parameter is None:
                raise ValueError(self._unknown(name))
            said = list(_said(name, parameter, value, folder))
            if isinstance(parameter, click.Argument):
                given.setdefault(key, []).extend(said)
            else:
                spoken += (_option(parameter, word) for word in said)
        times = Counter(key_of(name) for name, value in pairs if value is not None)
        for key, parameter in self.keys.items():
            if parameter.required and not times[key]:
                raise ValueError(f'"{key}" is missing')
            if times[key] > 1 and not _may_repeat(parameter):
                raise ValueError(f'"{key}" is there twice')
        arguments = [word for key in self.keys for word in given.get(key, ())]
        return [*spoken, *steps, "--", *arguments]

    def _steps(self, value: Any, folder: str) -> Iterator[str]:
        """The words of ``[{"rect": [...]}, {"subtract": {"ellipse": [...]}}, {"grow": 3}]``."""
        if not isinstance(value, list):
            raise ValueError(f'"{SELECTION}" is {_shown(value)}, not a list of steps')
        current = "add"
        for number, step in enumerate(value, start=1):
            what = f"step {number} of the selection"
            name, inner = _only(step, what)
            how = name if name in _SWITCHES else "add"
            if name in _SWITCHES:
                name, inner = _only(inner, f'"{name}" of {what}')
            key = key_of(name)
            parameter = self.keys.get(key)
            if key not in _SELECTING or parameter is None:
                raise ValueError(f'{what} has no "{name}"; it has {", ".join(_SELECTING)}')
            if how != current and key not in ("grow", "shrink"):
                yield f"--{how}"
                current = how
            for word in _said(name, parameter, inner, folder):
                yield _option(parameter, word)

    def _unknown(self, name: str) -> str:
        near = difflib.get_close_matches(key_of(name), self.keys, 1)
        hint = f'did you mean "{near[0]}"?' if near else f"it has {', '.join(self.keys)}"
        return f'{self.name} has no "{name}"; {hint}'


_SELECTING: Final = ("mask", "rect", "ellipse", "polygon", "lasso", "grow", "shrink")


@functools.cache
def tools() -> Mapping[str, Tool]:
    """All commands that make files of files: those with an ``--output``."""
    from poisson_cli.main import cli

    context = click.Context(cli)
    found = {}
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command is not None
        keys = {_name(parameter): parameter for parameter in command.params}
        if "output" in keys:
            own = {
                key: parameter for key, parameter in keys.items() if parameter.name not in _about_the_run()
            }
            found[name] = Tool(name, command, own)
    return found


@functools.cache
def _about_the_run() -> frozenset[str]:
    """Options about how much is said: that is for the batch to choose, not for a job."""

    @options.reporting
    def nothing(**_: Any) -> None:
        pass

    declared: list[click.Parameter] = nothing.__click_params__  # type: ignore[attr-defined]
    return frozenset(parameter.name or "" for parameter in declared)


def key_of(name: str) -> str:
    """A name with its underscores: ``mask-on``, as the command line has it, is ``mask_on`` as well."""
    return name.strip().replace("-", "_")


def _name(parameter: click.Parameter) -> str:
    """What a parameter is called in a line: an argument by its name, an option by its longest form."""
    if isinstance(parameter, click.Argument):
        return parameter.name or ""
    return key_of(max(parameter.opts, key=len).lstrip("-"))


def _may_repeat(parameter: click.Parameter) -> bool:
    return parameter.multiple or parameter.nargs == -1


def _option(parameter: click.Parameter, word: str) -> str:
    """An option as one word; a flag has no value."""
    longest = max(parameter.opts, key=len)
    return longest if isinstance(parameter, click.Option) and parameter.is_flag else f"{longest}={word}"


def _said(name: str, parameter: click.Parameter, value: Any, folder: str) -> Iterator[str]:
    """A value as words: one for each time that the parameter is said."""
    if isinstance(parameter, click.Option) and parameter.is_flag:
        if _truth(name, value):
            yield ""
        return
    between = params.separators(parameter.type)
    several = _may_repeat(parameter) and isinstance(value, list) and not _is_one(value, len(between))
    for one in value if several else [value]:
        word = _word(name, one, between)
        if params.is_file(parameter.type):
            if word in ("", "-"):
                raise ValueError(f'"{name}" is "{word}", but a batch needs names of files')
            try:
                os.fsencode(word)
            except UnicodeEncodeError as error:
                raise ValueError(f'"{name}" is {_shown(word)}, which no file can be called') from error
            word = os.path.join(folder, word)
        yield word


def _is_one(value: list[Any], depth: int) -> bool:
    """Whether a list is a single value, a list of numbers or a list of lists of them, and not several values."""
    if depth == 0 or not value:
        return False
    if depth == 1:
        return all(isinstance(item, int | float) for item in value)
    return all(isinstance(item, list) and _is_one(item, depth - 1) for item in value)


def _word(name: str, value: Any, between: Sequence[str]) -> str:
    """A value as it would be written on the command line."""
    if isinstance(value, str):
        if "\0" in value:
            raise ValueError(f'"{name}" has a null character')
        return value
    if isinstance(value, int | float) and not isinstance(value, bool):
        # To JSON, 40.0 is a whole number; programs that make tables of numbers write it so.
        whole = isinstance(value, float) and value.is_integer()
        return repr(int(value) if whole else value)
    if isinstance(value, list) and between:
        return between[0].join(_word(name, item, between[1:]) for item in value)
    example = "a list of numbers" if between else "text or a number"
    raise ValueError(f'"{name}" is {_shown(value)}, not {example}')


def _truth(name: str, value: Any) -> bool:
    """Whether a flag is to be said; CSV has words for it."""
    if isinstance(value, bool):
        return value
    if isinstance(value, str):
        try:
            return bool(click.BOOL.convert(value, None, None))
        except click.BadParameter:
            pass
    raise ValueError(f'"{name}" is {_shown(value)}, not true or false')


def _only(value: Any, what: str) -> tuple[str, Any]:
    """The one name of an object, and its value."""
    if not isinstance(value, dict) or len(value) != 1:
        raise ValueError(
            f'{what} is {_shown(value)}, not one name and its value, as in {{"rect": [0, 0, 9, 9]}}'
        )
    return next(iter(value.items()))


def _shown(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
