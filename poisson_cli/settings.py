"""What can be chosen about an edit, as plain frozen values.

The command line builds them in `options`; anything else that describes an edit (a manifest, a test) builds the same
ones. They hold no arrays, open no files and import nothing heavy. Axes are rows and columns here; X,Y ends in `params`.

They are named tuples, here and wherever else a command needs plain values to start: `dataclasses` writes and compiles
six functions for each frozen class, which takes five times as long, and there are dozens of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple

from poisson_cli import defaults

__all__ = [
    "Area",
    "Combine",
    "Edges",
    "Ellipse",
    "Grow",
    "How",
    "Inputs",
    "Job",
    "MaskFile",
    "MaskJob",
    "Output",
    "Placement",
    "Polygon",
    "Rectangle",
    "Relight",
    "Reporting",
    "Selection",
    "Solver",
    "Then",
]


class Rectangle(NamedTuple):
    """An axis-parallel block of pixels; its top-left corner may lie outside the picture."""

    row: int
    col: int
    height: int
    width: int


class Ellipse(NamedTuple):
    """The ellipse that touches the four sides of a rectangle."""

    box: Rectangle


class Polygon(NamedTuple):
    """What a closed line encloses.

    Parameters
    ----------
    points
        (row, column) of each corner, at least three; the last is joined to the first. In pixels, where whole numbers
        are corners of pixels: (0, 0) is the picture's top-left corner, and the first pixel's centre is (.5, .5).
    rule
        What is inside where the line crosses itself. ``"even-odd"``: what the line must be crossed an odd number of
        times to leave, so that an overlap is a hole. ``"nonzero"``: all that the line winds round.
    """

    points: tuple[tuple[float, float], ...]
    rule: Literal["even-odd", "nonzero"] = "even-odd"


class MaskFile(NamedTuple):
    """A file that says which pixels.

    Parameters
    ----------
    name
        A path, and after a colon the part of the file that is meant, if not all of it. No `Path`, because what
        follows the colon is none: a label may have slashes. See `poisson_cli.masks.source`.
    """

    name: str


Area = MaskFile | Rectangle | Ellipse | Polygon
"""Whatever selects pixels by itself."""

How = Literal["add", "subtract", "intersect"]
"""What an area does to what is selected so far: join it, be taken away from it, or keep only what lies in both."""


class Combine(NamedTuple):
    """A step of a selection: what an area does to what is selected so far."""

    area: Area
    how: How = "add"


class Grow(NamedTuple):
    """A step of a selection: move the border of what is selected so far.

    Parameters
    ----------
    pixels
        How far, outwards; negative shrinks. Euclidean: to grow by N selects every pixel whose centre is at most N
        pixels from that of a selected one, to shrink by N does the same to what is not selected.
    """

    pixels: int


class Placement(NamedTuple):
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


class Selection(NamedTuple):
    """Which pixels to edit: steps, done in order beginning with nothing selected, and inverted last if asked.

    Parameters
    ----------
    steps
        What is added, subtracted, intersected, grown and shrunk. The parts of areas outside the picture are ignored.
    invert
        Select what the steps leave out.
    threshold
        8-bit value from which a pixel of a mask picture is selected.

    Notes
    -----
    `poisson_cli.masks.plan` says what a selection looks like in JSON.

    Examples
    --------
    A ring, and what a file selects:

    >>> disk, hole = Ellipse(Rectangle(0, 0, 50, 50)), Ellipse(Rectangle(10, 10, 30, 30))
    >>> ring = Selection((Combine(disk), Combine(hole, "subtract"), Combine(MaskFile("more.png:alpha"))))
    """

    steps: tuple[Combine | Grow, ...] = ()
    invert: bool = False
    threshold: int = defaults.THRESHOLD


class Solver(NamedTuple):
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


class Edges(NamedTuple):
    """Where edges are, for a flattening.

    Parameters
    ----------
    file
        Picture that is white on edges; None to find them.
    low, high, sigma
        What Canny's detector finds them by: both thresholds, in levels per pixel, and the blur in pixels.
    show
        Where to write the edges that were used, white on black; None for nowhere. Of an import, those of the source.
    """

    file: Path | None = None
    low: float = defaults.LOW
    high: float = defaults.HIGH
    sigma: float = defaults.SIGMA
    show: Path | None = None


class Relight(NamedTuple):
    """How strongly gradients are evened out, eq. (16); the fields are those of `poisson_cli.editing.Attenuate`."""

    alpha: float = defaults.ALPHA
    beta: float = defaults.BETA


class Then(NamedTuple):
    """What else is done to the gradients that a clone imports, in this order; None is nothing.

    Parameters
    ----------
    flatten
        Keep those across edges of the source only.
    focus
        Multiply them by so much.
    relight
        Even them out.
    """

    flatten: Edges | None = None
    focus: float | None = None
    relight: Relight | None = None


class Inputs(NamedTuple):
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


class Output(NamedTuple):
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


class Reporting(NamedTuple):
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


class Job(NamedTuple):
    """What to do with which files.

    Parameters
    ----------
    tool
        Name of a function in `poisson_cli.editing`.
    destination
        The picture that is edited.
    output
        Where the result goes.
    selection
        Which pixels; None for a tool that edits the whole picture.
    source
        The picture whose gradients are cloned; None for a tool that needs none.
    placement
        Where the source lies; of no effect without one.
    solver
        How the equations are solved.
    then
        What is done to the gradients that are imported, for a tool that imports any; None for the others.
    edges
        Where the edges of the picture are, for a tool that flattens it; None for the others.
    preview
        Where to write the result three times three, side by side; None for nowhere.
    inputs
        How all the pictures are read.
    parameters
        Further keywords of the tool.
    """

    tool: str
    destination: Path
    output: Output
    selection: Selection | None = None
    source: Path | None = None
    placement: Placement = Placement()
    solver: Solver = Solver()
    then: Then | None = None
    edges: Edges | None = None
    preview: Path | None = None
    inputs: Inputs = Inputs()
    parameters: Mapping[str, Any] = {}


class MaskJob(NamedTuple):
    """What to select, and where to write it.

    Parameters
    ----------
    image
        The picture that it is drawn on.
    selection
        Which pixels.
    output
        Where to write it.
    over
        Show it on the picture, instead of writing a mask of 0 and 255.
    inputs
        How pictures are read.
    """

    image: Path
    selection: Selection
    output: Output
    over: bool = False
    inputs: Inputs = Inputs()
