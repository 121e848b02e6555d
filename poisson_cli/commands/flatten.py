"""``poisson flatten``: texture flattening, eqs. (14) and (15)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FILE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Edges, Inputs, Output, Reporting, Selection, Solver

__all__ = ["command"]


@click.command(short_help="Flatten the texture of a selection, keeping its edges.")
@click.argument("image", type=FILE)
@options.selection
@options.edges
@options.rescale
@options.space
@options.inputs
@options.output
@options.solver
@options.reporting
def command(
    image: Path,
    selection: Selection,
    edges: Edges,
    solver: Solver,
    inputs: Inputs,
    output: Output,
    reporting: Reporting,
    **parameters: Any,
) -> None:
    """Flatten the texture of a selection of IMAGE: gradients stay where an edge is, all others go.

    Skin without wrinkles, a drawing made of a photograph. Edges are found by Canny's detector (it needs OpenCV: pip
    install 'poisson-cli[edges]'), or come from a picture of yours. Look at them with --show-edges.

    \b
    Example: a face, white in face.png, with strong edges only:
      poisson flatten portrait.jpg -m face.png --high 25 --show-edges edges.png -o out.png
    """
    from poisson_cli import attended
    from poisson_cli.settings import Job

    attended.run(
        [
            Job(
                tool="flatten",
                destination=image,
                selection=selection,
                edges=edges,
                parameters=parameters,
                solver=solver,
                inputs=inputs,
                output=output,
            )
        ],
        reporting,
    )
