"""What a run says about itself: one line on stderr, more on request, or one JSON object on stdout.

Rows and columns are turned back into X,Y here, as `params` turned them the other way.
"""

from __future__ import annotations

import json
import math
import sys
from typing import TYPE_CHECKING, Any, TextIO

from poisson_cli.streams import STANDARD, printable, silence

if TYPE_CHECKING:
    from poisson_cli.editing import EditReport
    from poisson_cli.job import Summary
    from poisson_cli.settings import Reporting

__all__ = ["as_dict", "details", "line", "tell"]


def tell(summary: Summary, reporting: Reporting) -> None:
    """Say what was done, as much of it as was asked for.

    The result is on the disk by now, so nobody listening any more is no failure.

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
        if summary.edit.advice is not None:
            _print(f"poisson: hint: {summary.edit.advice}", sys.stderr)
    if reporting.verbose:
        _print(details(summary), sys.stderr)
    if reporting.json:
        _print(json.dumps(as_dict(summary)), sys.stdout)


def _print(text: str, stream: TextIO) -> None:
    try:
        print(text, file=stream, flush=True)
    except OSError:  # nobody reads it, or there is no room for it
        silence(stream)


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
        f"{method} x {edit.iterations}",
        _error(edit),
    ]
    if edit.floating:
        parts.append("no known pixel around a part: its mean is kept")
    if edit.clipped:
        parts.append(f"{_counted(edit.clipped, 'value')} clipped")
    if summary.profile_dropped:
        parts.append("colour profile dropped: the format cannot hold it")
    parts.append(_duration(sum(summary.seconds.values())))
    return f"{', '.join(parts)} -> {_output(summary)}"


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
    inside = "all of them" if edit.unknowns == summary.selected else f"{edit.unknowns:,} of them"
    rows = [("selected", f"{_counted(summary.selected, 'pixel')}, {inside} inside the picture")]
    if edit.boundary_mismatch is not None:
        mismatch = ", ".join(f"{value:.1f}" for value in edit.boundary_mismatch)
        rows.append(
            ("mismatch", f"{mismatch} levels between source and destination along the boundary, mean")
        )
    rows.append(("method", edit.method))
    proven = "" if edit.error_bound is None else f", {_proven(edit.error_bound)}"
    rows.append(
        ("error", f"{edit.error_estimate:.2g} levels estimated{proven}, {edit.tolerance:.2g} allowed")
    )
    rows.append(("clipped", f"{_counted(edit.clipped, 'value')} outside the picture's range"))
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
        ``region``: pixels selected; ``unknowns``: those of them on the destination, in ``rectangle``; errors and
        ``boundary_mismatch`` in levels; ``seconds`` per stage and in ``total``.
    """
    edit = summary.edit
    row, col, height, width = edit.rectangle
    return {
        "tool": edit.tool,
        "output": str(summary.output),
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
        "clipped": edit.clipped,
        "advice": edit.advice,
        "profile_dropped": summary.profile_dropped,
        "notices": list(summary.notices),
        "seconds": {**summary.seconds, "total": sum(summary.seconds.values())},
    }


def _output(summary: Summary) -> str:
    """Where the result went."""
    return "standard output" if str(summary.output) == STANDARD else printable(str(summary.output))


def _error(edit: EditReport) -> str:
    """The proven bound if there is one, else the estimate."""
    if edit.error_bound is not None and math.isfinite(edit.error_bound):
        return f"error < {_rounded_up(edit.error_bound)} levels, proven"
    return f"error < {_rounded_up(edit.error_estimate)} levels"


def _proven(bound: float) -> str:
    return f"at most {bound:.2g} proven" if math.isfinite(bound) else "no bound proven"


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
