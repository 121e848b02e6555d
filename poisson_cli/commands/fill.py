"""``poisson fill``: the membrane, eq. (2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FILE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Reporting, Selection, Solver

__all__ = ["command"]


@click.command(short_help="Fill a selection smoothly from its border.")
@click.argument("image", type=FILE)
@options.selection
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
    """Fill a selection of IMAGE smoothly from the colours around it.

    For scratches, dust, wires and small blemishes; a large selection becomes a soft blur without texture.

    \b
    Example: two scratches, white in scratches.png, and a date stamp in a corner:
      poisson fill scan.png -m scratches.png --rect 560,440,70,24 -o out.png
    """
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="fill",
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
