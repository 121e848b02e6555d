"""``poisson mask``: a selection as a file of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from poisson_cli import options
from poisson_cli.params import FILE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Reporting, Selection

__all__ = ["command"]


@click.command(short_help="Write a selection as a mask, or show it on the picture.")
@click.argument("image", type=FILE)
@options.selection
@click.option("--over", is_flag=True, help="Show the selection on IMAGE: outlined, and the rest dimmed.")
@options.inputs
@options.output
@options.reporting
def command(
    image: Path, selection: Selection, over: bool, inputs: Inputs, output: Output, reporting: Reporting
) -> None:
    """Write a selection of IMAGE as a mask: white where selected, black elsewhere, and nothing between.

    All commands select as this one does, so what it shows is what they edit. They also take the mask it writes,
    with -m.

    \b
    Example: a ring, and what is drawn in a file, without the picture's lower part:
      poisson mask cup.jpg --ellipse 40,40,200,180 --subtract --ellipse 70,65,140,130 \\
        --add -m handle.json:handle --subtract --rect 0,300,640,180 --over -o look.png
    """
    from poisson_cli import attended
    from poisson_cli.settings import MaskJob

    attended.run([MaskJob(image, selection, output, over, inputs)], reporting)
