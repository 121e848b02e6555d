"""The picture that a selection is drawn on."""

from __future__ import annotations

from typing import NamedTuple

from poisson_cli.errors import InputError
from poisson_cli.images import Picture

__all__ = ["Canvas"]


class Canvas(NamedTuple):
    """The picture that a selection is drawn on.

    Parameters
    ----------
    role
        What it is to the user: ``source``, ``destination`` or ``image``.
    picture
        The picture.
    other
        The picture that a mask may have been drawn on instead, with its role; None if there is no other.
    """

    role: str
    picture: Picture
    other: tuple[str, Picture] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W) of the picture."""
        return self.picture.shape

    def refuse_other_size(self, what: str, shape: tuple[int, int]) -> None:
        """Refuse a mask that was made for a picture of another size, with both sizes and the way out.

        Parameters
        ----------
        what
            The mask, as ``mask m.png is``: what its size is said after.
        shape
            (H, W) of the mask.

        Raises
        ------
        InputError
            If it is not that of the picture.
        """
        if shape == self.shape:
            return
        problem = (
            f"{what} {shape[1]}x{shape[0]}, but the {self.role} {self.picture.name} is {self.picture.size}"
        )
        if shape == self.shape[::-1]:
            problem += " (pictures are turned upright, as a camera's orientation tag asks for)"
        if self.other is None:
            raise InputError(f"{problem}; a mask must have the size of the {self.role}")
        role, other = self.other
        if shape == other.shape:
            raise InputError(
                f"{problem}; it has the size of the {role}: if it was drawn there, add --mask-on {role}"
            )
        raise InputError(
            f"{problem}; give it the size of the {self.role}, "
            f"or that of the {role} ({other.size}) and add --mask-on {role}"
        )
