"""The spaces that pictures can be edited in."""

from typing import Literal

SpaceName = Literal["rgb", "linear", "lab"]
