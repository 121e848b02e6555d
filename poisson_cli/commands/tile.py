"""``poisson tile``: seamless tiling, Fig. 12."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from poisson_cli import options
from poisson_cli.params import FILE, RECTANGLE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Reporting, Solver

__all__ = ["command"]


@click.command(short_help="Make pictures that repeat without a seam.")
@click.argument("images", type=FILE, metavar="IMAGE...", nargs=-1, required=True)
@click.option(
    "--rect",
    type=RECTANGLE,
    metavar="X,Y,W,H",
    help="Cut out this rectangle, W by H pixels with its top-left corner at X,Y; by default all of the picture.",
)
@click.option(
    "--axis",
    type=click.Choice(["both", "x", "y"]),
    default="both",
    show_default=True,
    help="Repeat in both directions, from left to right only, or from top to bottom only.",
)
@click.option(
    "--preview",
    "previews",
    type=FILE,
    multiple=True,
    help="Also write the result three times three, to look at; may be repeated, once for each IMAGE.",
)
@options.rescale
@options.space
@options.inputs
@options.outputs
@options.solver
@options.reporting
def command(
    images: tuple[Path, ...],
    previews: tuple[Path, ...],
    solver: Solver,
    inputs: Inputs,
    outputs: tuple[Output, ...],
    reporting: Reporting,
    **parameters: Any,
) -> None:
    """Make IMAGE a tile that repeats without a seam: opposite sides become equal, and the detail stays.

    Several maps of one material (colour, normals, height) are cut alike, each into an output of its own; either all of
    them are written or none.

    \b
    Example: a piece of a wall, and how it looks repeated:
      poisson tile wall.jpg --rect 40,30,256,256 --preview look.png -o tile.png
    Three maps, into a folder that exists:
      poisson tile colour.png normals.png height.png -o tiles
    """
    from poisson_cli import attended
    from poisson_cli.settings import Job

    if len(previews) > len(images):
        raise click.UsageError(f"{len(previews)} times --preview, but there are {len(images)} pictures.")
    attended.run(
        [
            Job(
                tool="tile",
                destination=image,
                preview=preview,
                parameters=parameters,
                solver=solver,
                inputs=inputs,
                output=output,
            )
            for image, output, preview in zip(
                images, _each(images, outputs), (*previews, *[None] * len(images)), strict=False
            )
        ],
        reporting,
    )


def _each(images: tuple[Path, ...], outputs: tuple[Output, ...]) -> tuple[Output, ...]:
    """The output of each picture."""
    if len(outputs) == 1 and outputs[0].path.is_dir():
        (folder,) = outputs
        return tuple(folder._replace(path=folder.path / image.name) for image in images)
    if len(outputs) != len(images):
        raise click.UsageError(
            f"{len(images)} pictures, but {len(outputs)} x -o: give it once for each, or once with a folder that "
            "exists."
        )
    return outputs
