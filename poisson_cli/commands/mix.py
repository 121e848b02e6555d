"""``poisson mix``: cloning with mixed gradients, eq. (13)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FILE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Placement, Reporting, Selection, Solver, Then

__all__ = ["command"]


@click.command(short_help="Clone, keeping the stronger detail of the two pictures.")
@click.argument("source", type=FILE)
@click.argument("destination", type=FILE)
@options.selection
@options.placement
@options.then
@options.bleeding
@options.rescale
@options.space
@options.inputs
@options.output
@options.solver
@options.reporting
def command(
    source: Path,
    destination: Path,
    selection: Selection,
    placement: Placement,
    then: Then,
    solver: Solver,
    inputs: Inputs,
    output: Output,
    reporting: Reporting,
    **parameters: Any,
) -> None:
    """Clone a selection of SOURCE into DESTINATION, keeping the stronger gradient of the two everywhere.

    For what has holes or can be looked through: writing, a rainbow, smoke, a fence. The texture of DESTINATION shows
    where SOURCE is plain.

    \b
    Example: handwriting onto a wall, the whole of note.png (400x300) at column 80, row 120:
      poisson mix note.png wall.jpg --rect 0,0,400,300 --at 80,120 -o out.png
    """
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="mix",
                source=source,
                destination=destination,
                selection=selection,
                placement=placement,
                then=then,
                parameters=parameters,
                solver=solver,
                inputs=inputs,
                output=output,
            )
        ],
        reporting,
    )
