"""What the command lines of a manifest ask for, read by the commands themselves, thousands of them in a second.

click goes through all options of a command, of which most lines say only a few; and what is not said has the same
value in every line. So a line that says the same options as one before is read by a copy of the command that has
those alone, and gets the values of the others from there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import click
from click.core import ParameterSource

from poisson_cli import attended
from poisson_cli.batch.grammar import Tool
from poisson_cli.job import Job
from poisson_cli.masking import MaskJob
from poisson_cli.options import Chatter

__all__ = ["Reader"]

_QUIET: Final = "--quiet"


class _Known(NamedTuple):
    """A command that has some of the options, and the values of those that it has not."""

    command: click.Command
    unsaid: Mapping[str, Any]


class Reader:
    """Reads command lines; one reader for a manifest."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, frozenset[str]], _Known] = {}

    def jobs(self, tool: Tool, words: Sequence[str]) -> tuple[Job | MaskJob, ...]:
        """What a command would do.

        Parameters
        ----------
        tool
            The command.
        words
            Its options, each in one word, ``--``, and its arguments, as `Tool.words` makes them.

        Raises
        ------
        ValueError
            As the command itself says what is wrong.
        PoissonError
            Likewise.
        """
        key = tool.name, frozenset(word.partition("=")[0] for word in words[: words.index("--")])
        known = self._known.get(key)
        try:
            if known is not None:
                try:
                    return _jobs(tool.name, known.command, words, known.unsaid)[0]
                except click.ClickException:
                    pass  # what is wrong is for the whole command to say
            jobs, context = _jobs(tool.name, tool.command, words, {})
        except click.ClickException as error:
            raise ValueError(error.format_message()) from error
        if known is None:
            self._known[key] = _known(tool, context)
        return jobs


def _jobs(
    name: str, command: click.Command, words: Sequence[str], unsaid: Mapping[str, Any]
) -> tuple[tuple[Job | MaskJob, ...], click.Context]:
    """What a command hands over, and the context that it did it in."""
    with (
        attended.handed_over() as jobs,
        command.make_context(name, [_QUIET, *words], obj=Chatter()) as context,
    ):
        for parameter, value in unsaid.items():
            context.params[parameter] = value
            context.set_parameter_source(parameter, ParameterSource.DEFAULT)
        command.invoke(context)
    return tuple(jobs), context


def _known(tool: Tool, context: click.Context) -> _Known:
    """What can be learned from a line that the whole command has read."""
    unsaid = {
        name: value
        for name, value in context.params.items()
        if context.get_parameter_source(name) is ParameterSource.DEFAULT and name not in _ORDERING
    }
    said = [parameter for parameter in tool.command.params if parameter.name not in unsaid]
    return _Known(
        click.Command(tool.name, callback=tool.command.callback, params=said, add_help_option=False), unsaid
    )


_ORDERING: Final = ("mask",)
"""The option that notes in which order all came, see `poisson_cli.options`: it has to be there in any case."""
