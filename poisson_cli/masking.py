"""One selection from files to a file: read, select, write. What `poisson_cli.job` is to an edit, without the edit."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from poisson_cli import images, interrupts
from poisson_cli.errors import OutputError
from poisson_cli.images import Picture
from poisson_cli.masks import Canvas, select, show
from poisson_cli.settings import MaskJob

__all__ = ["MaskJob", "MaskSummary", "run"]


class MaskSummary(NamedTuple):
    """What was selected.

    Parameters
    ----------
    selected
        Pixels in the selection.
    pixels
        Pixels of the picture.
    rectangle
        (row, column, height, width) of the selection's bounding box.
    output
        The file that was written.
    notices
        What the user should know about the inputs, a line each.
    """

    selected: int
    pixels: int
    rectangle: tuple[int, int, int, int]
    output: Path
    notices: tuple[str, ...] = ()


def run(job: MaskJob, before_commit: images.Committing = interrupts.finishing.set) -> MaskSummary:
    """Write a selection.

    Parameters
    ----------
    job
        What to do.
    before_commit
        As in `poisson_cli.job.run`.

    Raises
    ------
    InputError, OutputError
        Nothing was written.
    """
    image, output, over = job.image, job.output, job.over
    target = images.prepare(
        output.path, overwrite=output.overwrite, form=output.format, quality=output.quality
    )
    if not over and (not target.form.exact or output.quality is not None):
        raise OutputError(
            f"{output.path}: {target.form.name} would blur the mask; choose another format, such as PNG"
        )
    with images.asking(job.inputs.page, job.inputs.max_pixels) as asking:
        picture = images.read(image)
        selected = select(job.selection, Canvas("image", picture))
        asking.refuse_unpaged()
    mask = selected.mask
    if over:
        metadata = picture.metadata
        if picture.pixels.ndim == 2:  # grey becomes RGB, which a profile for one channel says nothing about
            metadata = metadata._replace(profile=None)
        shown = Picture(picture.name, show(picture.in_8_bits().pixels, mask), metadata=metadata)
    else:
        shown = Picture(picture.name, np.where(mask, np.uint8(255), np.uint8(0)))
    shown, _ = shown.converted(output.bit_depth or "8")
    images.write(target, shown, before_commit)
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return MaskSummary(
        selected=int(np.count_nonzero(mask)),
        pixels=mask.size,
        rectangle=(int(rows[0]), int(cols[0]), int(np.ptp(rows)) + 1, int(np.ptp(cols)) + 1),
        output=output.path,
        notices=(*asking.notices, *selected.notices),
    )
