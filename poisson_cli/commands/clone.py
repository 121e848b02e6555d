"""``poisson clone``: seamless cloning, eqs. (9)-(11)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FILE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Placement, Reporting, Selection, Solver, Then

__all__ = ["command"]


@click.command(short_help="Clone a selection of one picture into another, seamlessly.")
@click.argument("source", type=FILE)
@click.argument("destination", type=FILE)
@options.selection
@options.placement
@click.option(
    "--gradients",
    type=click.Choice(["source", "average"]),
    default="source",
    show_default=True,
    help="Gradients to keep: the source's, or the average of the source's and the destination's.",
)
@click.option("--monochrome", is_flag=True, help="Keep the source's texture only, not its colours.")
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
    """Clone a selection of SOURCE into DESTINATION, seamlessly.

    The result keeps the gradients of SOURCE and meets DESTINATION all along the border of the selection, so a loose
    outline will do: leave some of the object's surroundings inside it.

    \b
    Example: a bird into a sky. mask.png has the size of bird.jpg and is white around
    the bird; the top-left corner of bird.jpg goes to column 320, row 40 of sky.png:
      poisson clone bird.jpg sky.png -m mask.png --at 320,40 -o out.png
    """
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="clone",
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
