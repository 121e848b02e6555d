"""What a run says about itself: one line on stderr, more on request, or one JSON object on stdout.

Rows and columns are turned back into X,Y here, as `params` turned them the other way.
"""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING, Any, TextIO

from poisson_cli.errors import OutputError
from poisson_cli.hints import hints
from poisson_cli.streams import STANDARD, printable, silence

if TYPE_CHECKING:
    from pathlib import Path

    from poisson_cli.editing import EditReport
    from poisson_cli.job import Summary
    from poisson_cli.masking import MaskSummary
    from poisson_cli.settings import Reporting

__all__ = ["as_dict", "details", "line", "mask_as_dict", "mask_line", "tell", "tell_mask"]


def tell(summary: Summary, reporting: Reporting) -> None:
    """Say what was done, as much of it as was asked for.

    The result is on the disk by now, so nobody listening any more is no failure. A report in JSON that finds no room is
    one: whoever reads it later would miss it.

    Parameters
    ----------
    summary
        What was done.
    reporting
        How much to say.
    """
    if not reporting.quiet:
        for notice in summary.notices:
            _print(f"poisson: note: {printable(notice)}", sys.stderr)
        _print(line(summary), sys.stderr)
        if reporting.verbose:
            _print(details(summary), sys.stderr)
        for hint in hints(summary):
            _print(f"poisson: hint: {hint}", sys.stderr)
    if reporting.json:
        _print_report(as_dict(summary))


def tell_mask(summary: MaskSummary, reporting: Reporting) -> None:
    """Say what was selected, as `tell` does it for an edit.

    Parameters
    ----------
    summary
        What was selected.
    reporting
        How much to say.
    """
    if not reporting.quiet:
        for notice in summary.notices:
            _print(f"poisson: note: {printable(notice)}", sys.stderr)
        _print(mask_line(summary), sys.stderr)
    if reporting.json:
        _print_report(mask_as_dict(summary))


def _print(text: str, stream: TextIO) -> None:
    try:
        print(text, file=stream, flush=True)
    except OSError:  # nobody reads it, or there is no room for it
        silence(stream)


def _print_report(report: dict[str, Any]) -> None:
    import json

    try:
        print(json.dumps(report), flush=True)
    except BrokenPipeError:
        silence(sys.stdout)
    except OSError as error:
        silence(sys.stdout)
        reason = error.strerror or error
        raise OutputError(
            f"standard output: the report cannot be written ({reason}), but {report['output']} was"
        ) from error


def line(summary: Summary) -> str:
    """One line for a person.

    Parameters
    ----------
    summary
        What was done.

    Returns
    -------
    str
        Such as ``clone: 12,345 pixels at 40,60 (200x180), multigrid F x 6, error < 0.0002 levels, 31 ms -> out.png``.
    """
    edit = summary.edit
    row, col, height, width = edit.rectangle
    # A cycle that stalls is replaced by a stronger one: say what was done, not what was asked for.
    method = edit.solver if edit.cycle is None else edit.method.replace(",", "")
    parts = [
        f"{edit.tool}: {_counted(edit.unknowns, 'pixel')} at {col},{row} ({width}x{height})",
        f"{method} x {edit.iterations}" if edit.iterations else method,
        _error(edit),
    ]
    if edit.floating and summary.selected is not None:  # of a whole picture that is understood
        parts.append("no known pixel around a part: its mean is kept")
    if edit.offset is not None:
        parts.append(f"patch from {_from(edit.offset)}")
    if edit.edge_share is not None:
        parts.append(f"{edit.edge_share:.1%} edges")
    if edit.scale != 1:
        parts.append(f"gradients x {edit.scale:.2g} to fit the range")
    if edit.clipped:
        parts.append(f"{_counted(edit.clipped, 'value')} clipped")
    if summary.profile_dropped:
        parts.append("colour profile dropped: the format cannot hold it")
    parts.append(_duration(sum(summary.seconds.values())))
    beside = "".join(f", {what} -> {printable(str(path))}" for what, path in summary.beside.items())
    return f"{', '.join(parts)} -> {_named(summary.output)}{beside}"


def details(summary: Summary) -> str:
    """A few more lines for a person who wants to know.

    Parameters
    ----------
    summary
        What was done.

    Returns
    -------
    str
        Indented lines without a final newline.
    """
    edit = summary.edit
    rows = []
    if summary.selected is not None:
        inside = "all of them" if edit.unknowns == summary.selected else f"{edit.unknowns:,} of them"
        rows.append(("selected", f"{_counted(summary.selected, 'pixel')}, {inside} inside the picture"))
    if edit.boundary_mismatch is not None:
        mismatch = ", ".join(f"{value:.1f}" for value in edit.boundary_mismatch)
        outliers = "" if edit.outliers is None else f"; exceptional at {edit.outliers:.1%} of it"
        rows.append(
            (
                "mismatch",
                f"{mismatch} levels between source and destination along the boundary, mean{outliers}",
            )
        )
    rows.append(("method", edit.method))
    proven = "" if edit.error_bound is None else f", {_proven(edit.error_bound)}"
    rows.append(
        ("error", f"{edit.error_estimate:.2g} levels estimated{proven}, {edit.tolerance:.2g} allowed")
    )
    farthest = f", by {edit.overshoot:.1f} levels at most" if edit.overshoot > 0 else ""
    rows.append(("clipped", f"{_counted(edit.clipped, 'value')} outside the picture's range{farthest}"))
    rows.append(
        ("stages", ", ".join(f"{name} {_duration(spent)}" for name, spent in summary.seconds.items()))
    )
    return "\n".join(f"  {name:<9} {text}" for name, text in rows)


def as_dict(summary: Summary) -> dict[str, Any]:
    """What ``--json`` prints.

    Parameters
    ----------
    summary
        What was done.

    Returns
    -------
    dict
        ``region``: pixels selected, null for a tool that needs no selection; ``unknowns``: those of them on the
        destination, in ``rectangle``; errors, ``boundary_mismatch``, ``boundary_shift`` (the same with its sign) and
        ``overshoot`` in levels; ``outliers`` and ``edge_share`` from 0 to 1; ``scale``: what the gradients were
        multiplied by to fit the range; ``offset``: where a patch came from; ``beside``: other files that were written;
        ``seconds`` per stage and in ``total``.
    """
    edit = summary.edit
    row, col, height, width = edit.rectangle
    return {
        "tool": edit.tool,
        "output": str(summary.output),
        "beside": {what: str(path) for what, path in summary.beside.items()},
        "region": summary.selected,
        "rectangle": {"x": col, "y": row, "width": width, "height": height},
        "unknowns": edit.unknowns,
        "solver": edit.solver,
        "cycle": edit.cycle,
        "method": edit.method,
        "iterations": edit.iterations,
        "tolerance": edit.tolerance,
        "error_estimate": edit.error_estimate,
        "error_bound": edit.error_bound
        if edit.error_bound is None or math.isfinite(edit.error_bound)
        else None,
        "floating": edit.floating,
        "boundary_mismatch": None if edit.boundary_mismatch is None else list(edit.boundary_mismatch),
        "boundary_shift": None if edit.boundary_shift is None else list(edit.boundary_shift),
        "outliers": edit.outliers,
        "space": edit.space,
        "overshoot": edit.overshoot,
        "clipped": edit.clipped,
        "scale": edit.scale,
        "offset": None if edit.offset is None else {"x": edit.offset[1], "y": edit.offset[0]},
        "edge_share": edit.edge_share,
        "advice": edit.advice,
        "hints": hints(summary),
        "profile_dropped": summary.profile_dropped,
        "notices": list(summary.notices),
        "seconds": {**summary.seconds, "total": sum(summary.seconds.values())},
    }


def mask_line(summary: MaskSummary) -> str:
    """One line for a person.

    Parameters
    ----------
    summary
        What was selected.

    Returns
    -------
    str
        Such as ``mask: 12,345 of 307,200 pixels at 40,60 (200x180) -> mask.png``.
    """
    row, col, height, width = summary.rectangle
    pixels = f"{summary.selected:,} of {_counted(summary.pixels, 'pixel')}"
    return f"mask: {pixels} at {col},{row} ({width}x{height}) -> {_named(summary.output)}"


def mask_as_dict(summary: MaskSummary) -> dict[str, Any]:
    """What ``--json`` prints; the names are those of `as_dict`.

    Parameters
    ----------
    summary
        What was selected.
    """
    row, col, height, width = summary.rectangle
    return {
        "tool": "mask",
        "output": str(summary.output),
        "region": summary.selected,
        "pixels": summary.pixels,
        "rectangle": {"x": col, "y": row, "width": width, "height": height},
        "notices": list(summary.notices),
    }


def _named(path: Path) -> str:
    """Where a result went."""
    return "standard output" if str(path) == STANDARD else printable(str(path))


def _error(edit: EditReport) -> str:
    """The proven bound if there is one, else the estimate."""
    if edit.error_bound is not None and math.isfinite(edit.error_bound):
        return f"error < {_rounded_up(edit.error_bound)} levels, proven"
    return f"error < {_rounded_up(edit.error_estimate)} levels"


def _proven(bound: float) -> str:
    return f"at most {bound:.2g} proven" if math.isfinite(bound) else "no bound proven"


def _from(offset: tuple[int, int]) -> str:
    """Where a patch was taken from, in words and as an option."""
    row, col = offset
    steps = [(abs(col), "left" if col < 0 else "right"), (abs(row), "up" if row < 0 else "down")]
    words = ", ".join(f"{pixels} {direction}" for pixels, direction in steps if pixels)
    return f"{words or 'where it is'} (--from {col},{row})"


def _counted(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def _rounded_up(error: float) -> str:
    """One significant digit, never less than the number, and nothing finer than a millionth of a level."""
    error = max(error, 1e-6)
    digits = max(0, -math.floor(math.log10(error)))
    unit = 10.0**-digits
    return f"{math.ceil(error / unit - 1e-9) * unit:.{digits}f}"


def _duration(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds >= 1 else f"{seconds * 1000:.0f} ms"
