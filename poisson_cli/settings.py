"""What can be chosen about an edit, as plain frozen values.

The command line builds them in `options`; anything else that describes an edit (a manifest, a test) builds the same
ones. They hold no arrays, open no files and import nothing heavy. Axes are rows and columns here; X,Y ends in `params`.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from poisson_cli import defaults

__all__ = [
    "Inputs",
    "Output",
    "Placement",
    "Rectangle",
    "Reporting",
    "Selection",
    "Solver",
]


class Rectangle(NamedTuple):
    """An axis-parallel block of pixels; its top-left corner may lie outside the picture."""

    row: int
    col: int
    height: int
    width: int


@dataclass(frozen=True, slots=True)
class Placement:
    """Where the source lies on the destination, and which of the two the selection was drawn on.

    Parameters
    ----------
    offset
        (row, column) of the source's top-left corner on the destination, in pixels; may be negative.
    mask_on
        The picture whose grid the masks and rectangles use.
    """

    offset: tuple[int, int] = (0, 0)
    mask_on: Literal["source", "destination"] = "source"


@dataclass(frozen=True, slots=True)
class Selection:
    """Which pixels to edit: the union of all masks and rectangles, inverted last if asked.

    Parameters
    ----------
    masks
        Mask pictures; see `poisson_cli.masks.picture_selects` for which of their pixels count.
    rectangles
        Rectangles on the same grid; the part outside the picture is ignored.
    invert
        Select what the union leaves out.
    threshold
        8-bit value from which a pixel of a mask picture is selected.
    """

    masks: tuple[Path, ...] = ()
    rectangles: tuple[Rectangle, ...] = ()
    invert: bool = False
    threshold: int = defaults.THRESHOLD


@dataclass(frozen=True, slots=True)
class Solver:
    """How the equations are solved; the fields are the keywords of the functions in `poisson_cli.editing`.

    Parameters
    ----------
    solver
        ``"multigrid"`` or ``"sor"``.
    cycle
        ``"V"``, ``"F"`` or ``"W"``; multigrid only.
    tolerance
        Largest error allowed in any pixel, in levels (1/255 of full scale).
    max_iterations
        Cycles or sweeps after which to give up; None leaves it to the solver.
    threads
        Threads to compute with; None leaves it to the solver.
    certify
        Whether to prove a bound of the error as well.
    """

    solver: Literal["multigrid", "sor"] = "multigrid"
    cycle: Literal["V", "F", "W"] = defaults.CYCLE
    tolerance: float = defaults.TOLERANCE
    max_iterations: int | None = None
    threads: int | None = None
    certify: bool = False


@dataclass(frozen=True, slots=True)
class Inputs:
    """How pictures are read, all of them alike.

    Parameters
    ----------
    page
        Which picture of a file that holds several, from 1; None: the first.
    max_pixels
        Pixels of the largest picture that is read.
    """

    page: int | None = None
    max_pixels: int = defaults.MAX_PIXELS


@dataclass(frozen=True, slots=True)
class Output:
    """Where the result goes, and as what.

    Parameters
    ----------
    path
        The file; ``-`` is the standard output.
    overwrite
        Whether a file that is already there may be replaced.
    format
        Ending without its dot that tells the format; None: that of the path.
    bit_depth
        Depth to convert the destination to; None: as it is.
    quality
        Of JPEG and WebP, 1 to 100; None leaves it to the format.
    """

    path: Path
    overwrite: bool = False
    format: str | None = None
    bit_depth: Literal["8", "16", "float"] | None = None
    quality: int | None = None


@dataclass(frozen=True, slots=True)
class Reporting:
    """How much a run says about itself.

    Parameters
    ----------
    quiet
        Say nothing on stderr (errors are still said).
    verbose
        Say more on stderr.
    json
        Print one JSON object on stdout.
    """

    quiet: bool = False
    verbose: bool = False
    json: bool = False
