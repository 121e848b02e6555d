"""``poisson relight``: local illumination changes, eq. (16)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FILE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Reporting, Selection, Solver

__all__ = ["command"]


@click.command(short_help="Even out the light in a selection.")
@click.argument("image", type=FILE)
@options.selection
@options.relight
@click.option(
    "--per-channel",
    is_flag=True,
    help="Treat red, green and blue each by itself, which evens out coloured light too; by default colours keep the "
    "ratios of their channels.",
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
    """Even out the light in a selection of IMAGE: large changes of brightness become smaller, small ones larger.

    Brings out what lies in shadow, and softens reflections.

    \b
    Example: a face against the light, white in face.png:
      poisson relight portrait.jpg -m face.png --beta .3 -o out.png
    """
    if parameters["per_channel"] and parameters["space"] == "lab":
        raise click.UsageError(
            "--per-channel needs --space rgb or linear: colours in CIE-Lab are no intensities."
        )
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="relight",
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
