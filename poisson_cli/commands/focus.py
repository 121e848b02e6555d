"""``poisson focus``: an apparent change of focus, the paper's conclusion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FILE, NOT_NEGATIVE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Output, Reporting, Selection, Solver

__all__ = ["command"]


@click.command(short_help="Sharpen or soften a selection, seamlessly.")
@click.argument("image", type=FILE)
@options.selection
@click.option(
    "--amount",
    type=NOT_NEGATIVE,
    metavar="F",
    required=True,
    help="Multiply the gradients: above 1 sharper, below 1 softer, 0 smooth.",
)
@options.rescale
@options.space
@options.output
@options.solver
@options.reporting
def command(
    image: Path,
    selection: Selection,
    solver: Solver,
    output: Output,
    reporting: Reporting,
    **parameters: Any,
) -> None:
    """Sharpen or soften a selection of IMAGE; nothing shows where the change begins.

    \b
    Example: what is not white in people.png, softened:
      poisson focus party.jpg -m people.png --invert-mask --amount .5 -o out.png
    """
    from poisson_cli import attended
    from poisson_cli.job import Job

    attended.run(
        [
            Job(
                tool="focus",
                destination=image,
                selection=selection,
                parameters=parameters,
                solver=solver,
                output=output,
            )
        ],
        reporting,
    )
