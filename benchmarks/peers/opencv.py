"""OpenCV's seamlessClone with NORMAL_CLONE: sine transforms of the bounding box, not eq. (7) on the region."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.accuracy import Answer
from benchmarks.case import Case
from benchmarks.peers import Peer, Prepared, Promise, Scope

Array = np.ndarray[Any, Any]


def prepare(case: Case, _limit: float) -> Prepared:
    import cv2

    cv2.setNumThreads(1)
    mask = case.region.astype(np.uint8) * 255
    row, col, height, width = cv2_box(case.region)
    centre = (col + width // 2, row + height // 2)  # (x, y): where OpenCV puts the middle of the mask's box

    def run() -> Array:
        # A copy of the mask each time: the call overwrites it.
        return np.asarray(
            cv2.seamlessClone(case.source, case.destination, mask.copy(), centre, cv2.NORMAL_CLONE)
        )

    run()  # warm-up
    return Prepared(run, Answer)


def cv2_box(region: Array) -> tuple[int, int, int, int]:
    """Row, column, height and width of the region's bounding box."""
    rows, cols = (np.flatnonzero(region.any(axis)) for axis in (1, 0))
    return int(rows[0]), int(cols[0]), int(rows[-1] - rows[0] + 1), int(cols[-1] - cols[0] + 1)


PEERS = (Peer("OpenCV seamlessClone", Scope.CLONE, Promise.IMPROVEMENT, prepare, needs=("cv2",)),)
