"""What would have been better: said after an edit whose numbers look like a picture that disappoints.

The thresholds were found by looking at results for real photographs. They are meant to stay silent about every good
one: a hint that comes each time is not read.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from poisson_cli.editing import EditReport
    from poisson_cli.job import Summary

__all__ = ["hints"]

LARGE_MISMATCH: Final = {"clone": 100.0, "mix": 100.0, "heal": 40.0, "recolor": 40.0}
"""Levels between the two pictures, the mean along the border, from which the inside is not what was wanted.

Half of a clone's is nothing unusual in good ones: an even shift of brightness is what cloning is for. A patch of the
same picture should fit better, and a border should lead through what recolouring leaves alone.
"""

LARGE_CAST: Final = 80.0
"""Levels by which the channels of a clone are shifted apart, from which it takes on another hue.

A cat in coffee that turns orange: 100; pictures that look right: up to 65.
"""

MANY_CLIPPED: Final = 0.12
"""Share of the values of a clone that were clipped, from which detail is missed. Good pictures have up to .1."""

MUCH_WEAKER: Final = 0.5
"""What gradients were multiplied by to fit the range, below which little more than a ghost is left."""

_MOVE: Final = "move the border to where they are alike, or keep the source's colours with --screen .001"
_AGAINST_MISMATCH: Final = {
    "clone": ("the pictures differ by", "colours bleed in", _MOVE),
    "mix": ("the pictures differ by", "colours bleed in", _MOVE),
    "heal": (
        "the patch and the picture differ by",
        "it will show",
        "leave a margin of a few pixels around what is to go, or name a patch that is more like it, with --from",
    ),
    "recolor": (
        "the new colours differ by",
        "the inside is shifted back by as much",
        "lead the border through what keeps its colour, or add --screen .001",
    ),
}
"""For each tool that imports gradients: what differs along the border, what comes of it, and what helps."""


def hints(summary: Summary) -> list[str]:
    """What would have been better, each in one line.

    Parameters
    ----------
    summary
        What was done.
    """
    edit = summary.edit
    found = [
        edit.advice,
        None if summary.guarded else _bleeding(edit, summary.tinted),
        _weakened(edit, summary.guarded),
        _textureless(edit),
    ]
    return [hint for hint in found if hint is not None]


def _bleeding(edit: EditReport, tinted: bool) -> str | None:
    """Of what went wrong because the pictures are unlike each other along the border, the most telling."""
    if edit.tool not in _AGAINST_MISMATCH or edit.boundary_mismatch is None:
        return None
    mismatch, channels = max(edit.boundary_mismatch), len(edit.boundary_mismatch)
    if mismatch >= LARGE_MISMATCH[edit.tool]:
        what, so, remedy = _AGAINST_MISMATCH[edit.tool]
        return f"along the border {what} {mismatch:.0f} levels on average, so that {so}; {remedy}"
    if edit.tool == "recolor":  # what it shifts and clips is what was asked for
        return None
    shift = edit.boundary_shift or ()
    if not tinted and len(shift) == 3 and max(shift) - min(shift) >= LARGE_CAST:
        told = ", ".join(f"{value:+.0f}" for value in shift)
        return (
            f"along the border the pictures differ by {told} levels (R, G, B) on average, so that the inside takes on "
            f"another hue; {_AGAINST_MISMATCH[edit.tool][2]}"
        )
    share = edit.clipped / max(edit.unknowns * channels, 1)
    if share >= MANY_CLIPPED:
        return (
            f"{share:.0%} of the values left the range and were clipped; --rescale fits them in, "
            "--screen .001 keeps the source's own brightness"
        )
    return None


def _weakened(edit: EditReport, guarded: bool) -> str | None:
    """What to do where gradients had to be weakened so much that little is left of them."""
    if edit.scale >= MUCH_WEAKER:
        return None
    if edit.tool == "focus":
        return (
            f"--rescale weakened the gradients to {edit.scale:.0%} of what was asked for, since the picture has no "
            "room for more; choose a smaller --amount"
        )
    could = [] if guarded or edit.tool not in _AGAINST_MISMATCH else ["--screen .001"]
    could += [] if edit.space == "lab" else ["--space lab"]
    remedy = f"try {' or '.join(could)} instead" if could else "leave --rescale out"
    return f"--rescale weakened the gradients to {edit.scale:.0%}, which leaves a ghost; {remedy}"


def _textureless(edit: EditReport) -> str | None:
    """What to do where a flattening kept nothing."""
    if edit.edge_share != 0:
        return None
    return (
        "there is no edge in the selection, so that all detail is gone; lower --high and --low, or mark edges where "
        "it is to stay"
    )
