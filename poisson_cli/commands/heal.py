"""``poisson heal``: concealment, Fig. 2."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import COUNT, FILE, POINT

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Reporting, Selection, Solver

__all__ = ["command"]


@click.command(short_help="Hide a selection under another part of the picture.")
@click.argument("image", type=FILE)
@options.selection
@click.option(
    "--from",
    "offset",
    type=POINT,
    metavar="DX,DY",
    help="Take the patch from so many pixels to the right and below the selection; negative: to the left, above. By "
    "default the place is searched whose surroundings fit best, and the report says which it is.",
)
@click.option(
    "--reach",
    type=COUNT,
    metavar="PIXELS",
    help="Search so far from the selection only.",
)
@options.bleeding
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
    """Hide a selection of IMAGE under a patch from elsewhere in the same picture.

    Leave a margin of a few pixels around what is to go: the patch is chosen by what lies along the border.

    \b
    Example: a mole, white in mole.png:
      poisson heal portrait.jpg -m mole.png -o out.png
    The same with skin from 60 pixels to the right:
      poisson heal portrait.jpg -m mole.png --from 60,0 -o out2.png
    """
    if parameters["offset"] is not None and parameters["reach"] is not None:
        raise click.UsageError("--reach is for the search; with --from nothing is searched for.")
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="heal",
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
