"""``poisson tonemap``: compression of the dynamic range (Fattal, Lischinski and Werman, 2002)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FACTOR_ABOVE_0, FILE, within

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Reporting, Solver

__all__ = ["command"]


@click.command(short_help="Lighten shadows and hold back lights, keeping detail.")
@click.argument("image", type=FILE)
@click.option(
    "--alpha",
    type=FACTOR_ABOVE_0,
    metavar="F",
    default=0.1,
    show_default=True,
    help="Gradients of the logarithm above F times their mean become weaker, those below it stronger, at every scale.",
)
@click.option(
    "--beta",
    type=within(0, 1),
    metavar="F",
    default=0.1,
    show_default=True,
    help="How much so, from 0 to 1: 0 is not at all, .2 looks unreal.",
)
@click.option(
    "--saturation",
    type=within(0, 10),
    metavar="F",
    default=0.6,
    show_default=True,
    help="How much of the colour to keep: 1 is all of it, and glows where much was dark.",
)
@click.option(
    "--black",
    type=within(0, 100),
    metavar="PERCENT",
    default=0.5,
    show_default=True,
    help="Share of the pixels that may become darker than they are, so that the others need not.",
)
@click.option(
    "--white",
    type=within(0, 100, above_low=True),
    metavar="PERCENT",
    default=99.5,
    show_default=True,
    help="Share of the pixels that stay below the greatest brightness.",
)
@click.option(
    "--floor",
    type=FACTOR_ABOVE_0,
    metavar="F",
    default=0.01,
    show_default=True,
    help="What is darker than F times the lights counts for little: less for pictures of a large range.",
)
@click.option(
    "--gamma",
    type=within(0.5, 10),
    metavar="F",
    default=1.0,
    show_default=True,
    help="Brighten the middle tones of the result: for pictures that store linear light.",
)
@options.space
@options.inputs
@options.output
@options.solver
@options.reporting
def command(
    image: Path,
    solver: Solver,
    inputs: Inputs,
    output: Output,
    reporting: Reporting,
    **parameters: Any,
) -> None:
    """Lighten the shadows of IMAGE and hold back its lights, keeping the detail in both.

    For dark or contrasty pictures, and for files of a larger range than a screen's, which store linear light; the whole
    picture changes.

    \b
    Example:
      poisson tonemap church.jpg -o out.png
    The same from a Radiance HDR or OpenEXR file:
      poisson tonemap church.hdr --floor .001 --gamma 2.2 --bit-depth 8 -o out.png
    """
    if parameters["black"] >= parameters["white"]:
        raise click.UsageError(f"--black is {parameters['black']:g}, but must be less than --white.")
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="tonemap",
                destination=image,
                parameters=parameters,
                solver=solver,
                inputs=inputs,
                output=output,
            )
        ],
        reporting,
    )
