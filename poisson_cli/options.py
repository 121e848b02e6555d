"""Options that subcommands share.

Most decorators here add a bundle of options and hand the command *one* frozen value built from them, under the
decorator's own name. What the values mean is said in `settings`; this module only parses. A few add options that are
keywords of the tools, and hand them over as they are.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Literal, cast

import click
from click.core import ParameterSource

from poisson_cli import defaults
from poisson_cli.params import (
    COUNT,
    EIGHT_BIT,
    ELLIPSE,
    FACTOR,
    FACTOR_ABOVE_0,
    FILE,
    LASSO,
    MASK,
    NOT_NEGATIVE,
    POINT,
    POLYGON,
    POSITIVE,
    QUALITY,
    RECTANGLE,
    within,
)

if TYPE_CHECKING:
    from pathlib import Path

    from click.parser import _OptionParser

    from poisson_cli.settings import (
        Combine,
        Edges,
        Grow,
        How,
        Inputs,
        Output,
        Placement,
        Reporting,
        Selection,
        Solver,
        Then,
    )

__all__ = [
    "Chatter",
    "bleeding",
    "edges",
    "inputs",
    "output",
    "outputs",
    "placement",
    "relight",
    "reporting",
    "rescale",
    "screen",
    "selection",
    "solver",
    "space",
    "then",
]

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


_ORDER: Final = f"{__name__}.order"
"""Where `_NotesOrder` leaves the names of the options, as often as they came, in a context's ``meta``."""


class _NotesOrder(click.Option):
    """An option that also notes in which order all options of its command came.

    Only click's parser knows the order, and drops it: a command gets the values of each option by themselves.
    """

    def add_to_parser(self, parser: _OptionParser, ctx: click.Context) -> None:
        super().add_to_parser(parser, ctx)
        parse = parser.parse_args

        def parse_and_note(
            args: list[str],
        ) -> tuple[dict[str, Any], list[str], list[click.Parameter]]:
            values, rest, order = parse(args)
            ctx.meta[_ORDER] = [parameter.name for parameter in order]
            return values, rest, order

        parser.parse_args = parse_and_note  # type: ignore[method-assign]


_SWITCHES: Final = ("add", "subtract", "intersect")


def _selection(invert: bool, threshold: int, **given: Any) -> Selection:
    from poisson_cli.settings import Selection

    areas = {name: iter(values) for name, values in given.items() if isinstance(values, tuple)}
    order = click.get_current_context().meta[_ORDER]
    steps = tuple(_steps([name for name in order if name in given], areas))
    if not steps:
        raise click.UsageError(
            "No selection given: name a mask with -m, or draw one with --rect, --ellipse, --polygon or --lasso."
        )
    return Selection(steps=steps, invert=invert, threshold=threshold)


def _steps(order: Sequence[str], values: Mapping[str, Iterator[Any]]) -> Iterator[Combine | Grow]:
    """The steps of a selection, in the order of the command line.

    Parameters
    ----------
    order
        Names of the options that select, as often as they came.
    values
        What came with each.
    """
    from poisson_cli.settings import Combine, Grow

    how = "add"
    unused = ""  # a switch that no mask or shape has followed yet
    nothing_yet = True
    for name in order:
        if name in _SWITCHES:
            _refuse_unused(unused)
            how = unused = name
        elif name in ("grow", "shrink"):
            if nothing_yet:
                raise click.UsageError(f"--{name} works on what was selected before it, and nothing was.")
            pixels: int = next(values[name])
            yield Grow(pixels if name == "grow" else -pixels)
        else:
            if nothing_yet and how != "add":
                raise click.UsageError(f"--{how} works on what was selected before it, and nothing was.")
            yield Combine(next(values[name]), cast("How", how))
            unused, nothing_yet = "", False
    _refuse_unused(unused)


def _refuse_unused(switch: str) -> None:
    if switch:
        raise click.UsageError(
            f"--{switch} has no effect: put it before the masks and shapes that it is for."
        )


selection: Final = _bundle(
    "selection",
    _selection,
    (
        click.option(
            "-m",
            "--mask",
            "mask",
            cls=_NotesOrder,
            type=MASK,
            metavar="FILE[:PART]",
            multiple=True,
            help="What to edit. A picture, white where to edit: of one that is transparent in places, what is opaque "
            "counts; of one with a colour palette, what is not black. Of a picture, PART can be alpha, red, green, "
            "blue or index=N, an entry of its palette. Or labelme's or COCO's JSON; PART is a label, a category, or "
            "the id of an annotation. Or a text file with the corners of a polygon, x,y in each line. "
            "May be repeated and mixed with the shapes below: all are joined, unless a switch below says otherwise.",
        ),
        click.option(
            "--rect",
            "rect",
            type=RECTANGLE,
            metavar="X,Y,W,H",
            multiple=True,
            help="Rectangle to edit, W by H pixels with its top-left corner at X,Y.",
        ),
        click.option(
            "--ellipse",
            type=ELLIPSE,
            metavar="X,Y,W,H",
            multiple=True,
            help="The ellipse inside such a rectangle.",
        ),
        click.option(
            "--polygon",
            type=POLYGON,
            metavar='"X,Y X,Y ..."',
            multiple=True,
            help="Polygon with these corners; fractions are allowed. Where it overlaps itself is a hole.",
        ),
        click.option(
            "--lasso",
            type=LASSO,
            metavar='"X,Y X,Y ..."',
            multiple=True,
            help="All that a line drawn by hand goes round, overlaps included; its ends are joined.",
        ),
        click.option(
            "--add", is_flag=True, help="Join the masks and shapes that follow, as is done by default."
        ),
        click.option(
            "--subtract",
            is_flag=True,
            help="Take the masks and shapes that follow, up to the next of these switches, away from what is "
            "selected so far.",
        ),
        click.option(
            "--intersect",
            is_flag=True,
            help="Of what is selected so far, keep what lies in each of the masks and shapes that follow.",
        ),
        click.option(
            "--grow",
            type=COUNT,
            metavar="N",
            multiple=True,
            help="Select also what is at most N pixels from what is selected so far.",
        ),
        click.option(
            "--shrink",
            type=COUNT,
            metavar="N",
            multiple=True,
            help="Leave out what is at most N pixels from what is not selected so far.",
        ),
        click.option(
            "--invert-mask", "invert", is_flag=True, help="In the end, edit what was not selected instead."
        ),
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


def _several(*options: _Decorator) -> _Decorator:
    """Options that go together, each handed over under its own name: that of the tool's keyword."""

    def decorate(command: _Command) -> _Command:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


space: Final = click.option(
    "--space",
    type=click.Choice(["rgb", "linear", "lab"]),
    default="rgb",
    show_default=True,
    help="Values to work on: as they are stored, linear light, or CIE-Lab; the last two take what is stored to be "
    "sRGB.",
)

rescale: Final = click.option(
    "--rescale",
    is_flag=True,
    help="Fit the selection into the range of the picture, rather than clip it: colours there lose some saturation if "
    "they must, and gradients are weakened until the brightness fits.",
)

screen: Final = click.option(
    "--screen",
    type=NOT_NEGATIVE,
    metavar="F",
    default=0.0,
    help="Against colours that bleed in from the border: bring the source's own colours back from about 1/sqrt(F) "
    "pixels inside; try .001. Off by default.",
)

bleeding: Final = _several(
    screen,
    click.option(
        "--robust",
        is_flag=True,
        help="Against colours that bleed in: where the two pictures differ far more than along the rest of the border, "
        "let the difference count less.",
    ),
)

relight: Final = _several(
    click.option(
        "--alpha",
        type=FACTOR_ABOVE_0,
        metavar="F",
        default=defaults.ALPHA,
        show_default=True,
        help="Gradients of the logarithm above F times their mean become weaker, those below it stronger.",
    ),
    click.option(
        "--beta",
        type=within(-1, 1),
        metavar="F",
        default=defaults.BETA,
        show_default=True,
        help="How much so, from -1 to 1: 0 is not at all; a negative number does the reverse.",
    ),
)


def _edges(low: float, high: float, sigma: float, file: Path | None, show: Path | None) -> Edges:
    from poisson_cli.settings import Edges

    if file is not None and (useless := _given("low", "high", "sigma")):
        raise click.UsageError(f"{useless[0]} is for finding edges; with --edges there is nothing to find.")
    if low > high:
        raise click.UsageError(f"--low is {low:g}, above --high, which is {high:g}.")
    return Edges(file=file, low=low, high=high, sigma=sigma, show=show)


def _edge_options(picture: str) -> tuple[_Decorator, ...]:
    """The options that say where edges are in a picture, called by its role."""
    return (
        click.option(
            "--low",
            type=NOT_NEGATIVE,
            metavar="F",
            default=defaults.LOW,
            show_default=True,
            help="An edge goes on while the brightness changes by more than this, in levels per pixel (Canny's lower "
            "threshold).",
        ),
        click.option(
            "--high",
            type=NOT_NEGATIVE,
            metavar="F",
            default=defaults.HIGH,
            show_default=True,
            help="An edge changes by more than this somewhere: a larger number leaves fewer edges.",
        ),
        click.option(
            "--sigma",
            type=NOT_NEGATIVE,
            metavar="PIXELS",
            default=defaults.SIGMA,
            show_default=True,
            help="Blur before edges are sought: a larger number finds larger shapes only; 0 is none.",
        ),
        click.option(
            "--edges",
            "file",
            type=FILE,
            help=f"Picture of the {picture}'s size that is white on edges, instead of finding them.",
        ),
        click.option(
            "--show-edges",
            "show",
            type=FILE,
            help=f"Also write the {picture}'s edges that were used, white on black.",
        ),
    )


edges: Final = _bundle("edges", _edges, _edge_options("image"))


def _then(flatten: bool, focus: float | None, relight: bool, **choices: Any) -> Then:
    from poisson_cli.settings import Relight, Then

    def chosen(step: bool, switch: str, build: Callable[..., Any], names: Sequence[str]) -> Any:
        if not step and (useless := _given(*names)):
            raise click.UsageError(f"{useless[0]} belongs to {switch}; add that.")
        return build(**{name: choices[name] for name in names}) if step else None

    return Then(
        flatten=chosen(flatten, "--flatten", _edges, ("low", "high", "sigma", "file", "show")),
        focus=focus,
        relight=chosen(relight, "--relight", Relight, ("alpha", "beta")),
    )


then: Final = _bundle(
    "then",
    _then,
    (
        click.option("--flatten", is_flag=True, help="Import only gradients across edges of the source."),
        *_edge_options("source"),
        click.option(
            "--focus",
            type=FACTOR,
            metavar="F",
            help="Multiply the imported gradients: above 1 sharper, below 1 paler.",
        ),
        click.option("--relight", is_flag=True, help="Even out the imported gradients, large and small."),
        relight,
    ),
)


def _given(*names: str) -> list[str]:
    """Those of these options that are on the command line, as they are written there."""
    context = click.get_current_context()
    return [
        parameter.opts[-1]
        for parameter in context.command.params
        if parameter.name in names
        and context.get_parameter_source(parameter.name) is not ParameterSource.DEFAULT
    ]


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
    from poisson_cli.streams import is_standard_output

    if is_standard_output(path) and click.get_current_context().params.get("json"):
        raise click.UsageError(
            "--json prints on the standard output, where the picture goes: name a file with -o."
        )
    return Output(path=path, **choices)


_FORMAT: Final = (
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
)
"""What the output is, beside where."""

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
        *_FORMAT,
    ),
)


def _outputs(paths: tuple[Path, ...], **choices: Any) -> tuple[Output, ...]:
    return tuple(_output(path, **choices) for path in paths)


outputs: Final = _bundle(
    "outputs",
    _outputs,
    (
        click.option(
            "-o",
            "--output",
            "paths",
            type=FILE,
            required=True,
            multiple=True,
            help="File to write, once for each picture in the same order; or once, a folder that exists, where each "
            "keeps its name. Formats as for the input.",
        ),
        click.option("--overwrite", is_flag=True, help="Replace the outputs that exist."),
        *_FORMAT,
    ),
)


def _reporting(quiet: bool, verbose: bool, json: bool) -> Reporting:
    from poisson_cli.settings import Reporting

    if quiet and verbose:
        raise click.UsageError("--quiet and --verbose contradict each other.")
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
