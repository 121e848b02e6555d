"""``poisson demo``: a gallery of every tool at work."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from poisson_cli.params import FILE

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["command"]


@click.command(short_help="Make a gallery that shows every tool at work.")
@click.argument("directory", type=FILE, metavar="DIR")
@click.option("--overwrite", is_flag=True, help="Replace files of an earlier gallery in DIR.")
def command(directory: Path, overwrite: bool) -> None:
    """Make a gallery in DIR that shows every tool at work on photographs; no files of yours are needed.

    Each example has its own folder with the pictures, the selection, the result and a sheet that shows them side by
    side; index.html shows them all, with the command lines that made them. The photographs come with scikit-image:
    pip install 'poisson-cli[demo]'.

    \b
    Example:
      poisson demo gallery
    """
    from poisson_cli import demo

    demo.run(directory, overwrite)
