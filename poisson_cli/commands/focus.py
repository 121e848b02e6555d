"""``poisson focus``: an apparent change of focus, the paper's conclusion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FACTOR, FILE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Reporting, Selection, Solver

__all__ = ["command"]


@click.command(short_help="Sharpen or soften a selection, seamlessly.")
@click.argument("image", type=FILE)
@options.selection
@click.option(
    "--amount",
    type=FACTOR,
    metavar="F",
    required=True,
    help="Multiply the gradients: above 1 sharper, below 1 paler and hazier (not a blur), 0 smooth.",
)
@options.rescale
@options.space
@options.inputs
@options.output
@options.solver
@options.reporting
def command(
    image: Path,
    selection: Selection,
    solver: Solver,
    inputs: Inputs,
    output: Output,
    reporting: Reporting,
    **parameters: Any,
) -> None:
    """Sharpen or soften a selection of IMAGE: its gradients are multiplied, and nothing shows where that begins.

    It does not blur: below 1 the selection loses contrast like in haze, and what touches the border bleeds in, because
    large differences of brightness are multiplied as well as fine detail. It is no depth of field.

    \b
    Example: a sharper face, white in face.png:
      poisson focus portrait.jpg -m face.png --amount 1.5 -o out.png
    """
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="focus",
                destination=image,
                selection=selection,
                parameters=parameters,
                solver=solver,
                inputs=inputs,
                output=output,
            )
        ],
        reporting,
    )
