"""Options that subcommands share.

Each decorator here adds a bundle of options and hands the command *one* frozen value built from them, under the
decorator's own name. What the values mean is said in `settings`; this module only parses.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final, Literal

import click
from click.core import ParameterSource

from poisson_cli import defaults
from poisson_cli.params import COUNT, EIGHT_BIT, FILE, POINT, POSITIVE, QUALITY, RECTANGLE

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.settings import Inputs, Output, Placement, Rectangle, Reporting, Selection, Solver

__all__ = ["Chatter", "inputs", "output", "placement", "reporting", "selection", "solver"]

_Command = Callable[..., None]
_Decorator = Callable[[_Command], _Command]


class Chatter:
    """What the process must know of a command even after it failed; the context's ``obj``.

    Parameters
    ----------
    verbose
        Whether an unforeseen exception is shown with its traceback.
    """

    def __init__(self, verbose: bool = False) -> None:
        self.verbose = verbose


def _bundle(name: str, build: Callable[..., Any], options: Sequence[_Decorator]) -> _Decorator:
    """Make one decorator of several options.

    Parameters
    ----------
    name
        Keyword under which the command gets the value.
    build
        Makes the value; its keywords are the options' names.
    options
        click's decorators, in the order of ``--help``.
    """

    def decorate(command: _Command) -> _Command:
        @functools.wraps(command)
        def with_value(**values: Any) -> None:
            own = {option: values.pop(option) for option in names}
            command(**values, **{name: build(**own)})

        before = len(getattr(with_value, "__click_params__", ()))
        for option in reversed(options):
            option(with_value)
        added: list[click.Parameter] = with_value.__click_params__[before:]  # type: ignore[attr-defined]
        names = [parameter.name for parameter in added]
        return with_value

    return decorate


def _placement(at: tuple[int, int], mask_on: Literal["source", "destination"]) -> Placement:
    from poisson_cli.settings import Placement

    return Placement(offset=at, mask_on=mask_on)


placement: Final = _bundle(
    "placement",
    _placement,
    (
        click.option(
            "--at",
            type=POINT,
            metavar="X,Y",
            default="0,0",
            show_default=True,
            help="Where the source's top-left corner lies on the destination, in pixels; may be negative. What hangs "
            "over is left out.",
        ),
        click.option(
            "--mask-on",
            type=click.Choice(["source", "destination"]),
            default="source",
            show_default=True,
            help="The picture that the selection was drawn on.",
        ),
    ),
)


def _selection(
    masks: tuple[Path, ...], rectangles: tuple[Rectangle, ...], invert: bool, threshold: int
) -> Selection:
    from poisson_cli.settings import Selection

    if not masks and not rectangles:
        raise click.UsageError("No selection given: name a mask with -m, or a rectangle with --rect X,Y,W,H.")
    return Selection(masks=masks, rectangles=rectangles, invert=invert, threshold=threshold)


selection: Final = _bundle(
    "selection",
    _selection,
    (
        click.option(
            "-m",
            "--mask",
            "masks",
            type=FILE,
            multiple=True,
            help="Picture that is white where to edit. Of one that is transparent in places, what is opaque counts; "
            "of one with a colour palette, what is not black. May be repeated: the selections are joined.",
        ),
        click.option(
            "--rect",
            "rectangles",
            type=RECTANGLE,
            metavar="X,Y,W,H",
            multiple=True,
            help="Rectangle to edit, W by H pixels with its top-left corner at X,Y. May be repeated.",
        ),
        click.option("--invert-mask", "invert", is_flag=True, help="Edit what was not selected instead."),
        click.option(
            "--mask-threshold",
            "threshold",
            type=EIGHT_BIT,
            metavar="1-255",
            default=defaults.THRESHOLD,
            show_default=True,
            help="Brightness (or opacity) from which a pixel of a mask is selected.",
        ),
    ),
)


def _solver(solver: Literal["multigrid", "sor"], **choices: Any) -> Solver:
    from poisson_cli.settings import Solver

    context = click.get_current_context()
    if solver == "sor" and context.get_parameter_source("cycle") is not ParameterSource.DEFAULT:
        raise click.UsageError("--cycle belongs to --solver multigrid; sor has no cycles.")
    return Solver(solver=solver, **choices)


solver: Final = _bundle(
    "solver",
    _solver,
    (
        click.option(
            "--solver",
            type=click.Choice(["multigrid", "sor"]),
            default="multigrid",
            show_default=True,
            help="Method; both give the same picture.",
        ),
        click.option(
            "--cycle",
            type=click.Choice(["V", "F", "W"]),
            default=defaults.CYCLE,
            show_default=True,
            help="Order in which multigrid visits its grids.",
        ),
        click.option(
            "--tolerance",
            type=POSITIVE,
            metavar="LEVELS",
            default=defaults.TOLERANCE,
            show_default=True,
            help="Largest error allowed in any pixel, in levels: 1/255 of full scale.",
        ),
        click.option(
            "--max-iterations",
            type=COUNT,
            metavar="N",
            help="Give up, and write nothing, after so many cycles or sweeps; by default after 100 cycles or 100,000 "
            "sweeps, more than any selection needs.",
        ),
        click.option(
            "--threads",
            type=COUNT,
            metavar="N",
            help="Threads to compute with; by default as many as pay. Any number gives the same picture.",
        ),
        click.option(
            "--certify",
            is_flag=True,
            help="Also prove how large the error can be at most; takes two or three times as long.",
        ),
    ),
)


def _inputs(page: int | None, max_pixels: int) -> Inputs:
    from poisson_cli.settings import Inputs

    return Inputs(page=page, max_pixels=max_pixels)


inputs: Final = _bundle(
    "inputs",
    _inputs,
    (
        click.option(
            "--page",
            type=COUNT,
            metavar="N",
            help="Which page or frame to read of a file that holds several; by default the first.",
        ),
        click.option(
            "--max-pixels",
            type=COUNT,
            metavar="N",
            default=defaults.MAX_PIXELS,
            show_default=True,
            help="Refuse pictures that claim to have more pixels, before memory is asked for.",
        ),
    ),
)


def _output(path: Path, **choices: Any) -> Output:
    from poisson_cli.settings import Output
    from poisson_cli.streams import STANDARD

    if str(path) == STANDARD and click.get_current_context().params.get("json"):
        raise click.UsageError(
            "--json prints on the standard output, where the picture goes: name a file with -o."
        )
    return Output(path=path, **choices)


output: Final = _bundle(
    "output",
    _output,
    (
        click.option(
            "-o",
            "--output",
            "path",
            type=FILE,
            required=True,
            help="File to write; its ending says the format: .png, .jpg, .tif, .bmp, .webp, .ppm, .pfm, .hdr or .exr. "
            "JPEG is not exact: it changes pixels everywhere a little. - is the standard output.",
        ),
        click.option("--overwrite", is_flag=True, help="Replace the output if it exists."),
        click.option(
            "--format",
            type=click.Choice(defaults.FORMATS),
            help="Format of the output, whatever its ending.",
        ),
        click.option(
            "--bit-depth",
            type=click.Choice(["8", "16", "float"]),
            help="Convert to this depth; by default the output has the destination's.",
        ),
        click.option(
            "--quality",
            type=QUALITY,
            metavar="1-100",
            help="Quality of a JPEG, by default 95, or of a WebP, by default without loss.",
        ),
    ),
)


def _reporting(quiet: bool, verbose: bool, json: bool) -> Reporting:
    from poisson_cli import compiling
    from poisson_cli.settings import Reporting

    if quiet and verbose:
        raise click.UsageError("--quiet and --verbose contradict each other.")
    compiling.announce(quiet=quiet)
    return Reporting(quiet=quiet, verbose=verbose, json=json)


def _remember_verbose(context: click.Context, _: click.Parameter, verbose: bool) -> bool:
    if verbose:
        context.ensure_object(Chatter).verbose = True
    return verbose


reporting: Final = _bundle(
    "reporting",
    _reporting,
    (
        click.option("-q", "--quiet", is_flag=True, help="Say nothing on stderr but errors."),
        click.option(
            "-v",
            "--verbose",
            is_flag=True,
            callback=_remember_verbose,
            help="Say more on stderr; show the traceback of an unforeseen error.",
        ),
        click.option("--json", is_flag=True, help="Print what was done as one JSON object on stdout."),
    ),
)
