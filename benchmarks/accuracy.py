"""How far an answer is from the exact one, and what it did where nothing may change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.case import TIE, Case

Array = np.ndarray[Any, Any]


@dataclass(frozen=True)
class Answer:
    """What a tool gave: the picture, and the values before they were rounded where it shows them."""

    picture: Array  # (H, W, 3) uint8
    values: Array | None = None  # (n, 3) float, in the order of `region.nonzero()`
    disturbed: int = (
        0  # pixels outside the region whose values changed by too little for the picture to show it
    )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Answer):
            return NotImplemented
        return np.array_equal(self.picture, other.picture)

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True)
class Accuracy:
    largest: float  # levels, any channel of any pixel inside, both sides clipped to 0..255
    rms: float  # levels, likewise
    rounded: bool  # the two above were taken from an 8-bit picture, so .5 is as good as can be
    identical: float  # share of the 8-bit values inside that equal the exact ones rounded, ties aside
    outside: int  # pixels changed outside the region


def of(case: Case, answer: Answer) -> Accuracy:
    """Hold an answer against `case.exact`, a channel at a time (the pictures may be huge)."""
    largest, squares, identical, count = 0.0, 0.0, 0, case.exact.size
    for channel in range(case.exact.shape[1]):
        exact = np.clip(case.exact[:, channel], 0, 255)
        eight_bit = answer.picture[..., channel][case.region]
        given = eight_bit if answer.values is None else np.clip(answer.values[:, channel], 0, 255)
        error = abs(given - exact)
        largest = max(largest, float(error.max())) if np.isfinite(error).all() else float("nan")
        squares += float(error @ error)
        tie = abs(exact % 1 - 0.5) < TIE
        identical += int(((eight_bit == np.rint(exact)) | (tie & (abs(eight_bit - exact) < 0.5 + TIE))).sum())
    outside = (answer.picture != case.destination).any(axis=2) & ~case.region
    return Accuracy(
        largest=largest,
        rms=float(np.sqrt(squares / count)),
        rounded=answer.values is None,
        identical=identical / count,
        outside=max(int(outside.sum()), answer.disturbed),
    )
