"""``poisson fill``: the membrane, eq. (2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
@options.inputs
@options.output
@options.solver
@options.reporting
def command(
    image: Path,
    selection: Selection,
    inputs: Inputs,
    solver: Solver,
    output: Output,
    reporting: Reporting,
) -> None:
    """Fill a selection of IMAGE smoothly from the colours around it.

    For scratches, dust, wires and small blemishes; a large selection becomes a soft blur without texture.

    \b
    Example: two scratches, white in scratches.png, and a date stamp in a corner:
      poisson fill scan.png -m scratches.png --rect 560,440,70,24 -o out.png
    """
    from poisson_cli import job, progress, report

    with progress.shown(reporting, solver) as watch:
        summary = job.run(
            job.Job(
                tool="fill",
                destination=image,
                selection=selection,
                inputs=inputs,
                solver=solver,
                output=output,
            ),
            progress=watch,
        )
    report.tell(summary, reporting)
