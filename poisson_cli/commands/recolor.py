"""``poisson recolor``: local colour changes, Fig. 11."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FACTOR, FACTORS, FILE, NUMBER

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Reporting, Selection, Solver

__all__ = ["command"]


@click.command(short_help="Change the colours in a selection, seamlessly.")
@click.argument("image", type=FILE)
@options.selection
@click.option(
    "--gain",
    type=FACTORS,
    metavar="R,G,B",
    default="1,1,1",
    show_default=True,
    help="Multiply red, green and blue. There is next to no blue to multiply in a saturated red: to make it blue, use "
    "--hue.",
)
@click.option(
    "--hue",
    type=NUMBER,
    metavar="DEGREES",
    default=0.0,
    help="Turn the colours round the circle: 180 is opposite.",
)
@click.option(
    "--saturation",
    type=FACTOR,
    metavar="F",
    default=1.0,
    help="Multiply how colourful they are: 0 is grey.",
)
@click.option(
    "--decolor-background",
    is_flag=True,
    help="Make the picture grey outside the selection. Where the surroundings were warm, greys inside turn bluish: "
    "--screen .0005 keeps them.",
)
@options.screen
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
    """Change the colours in a selection of IMAGE; a loose outline around the object will do.

    The recoloured picture is cloned into the original, so that what is around the object keeps its colour. Lead the
    border through what hardly changes: where it crosses strong colours, the inside is shifted back.

    \b
    Example: a yellow flower made red, roughly outlined in flower.png:
      poisson recolor garden.jpg -m flower.png --gain 1.5,.5,.5 -o out.png
    """
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="recolor",
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
