"""Each tool beside its oracle, under one way of calling, so that a test can be written once for all of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from poisson_cli.editing import Edit, clone, fill, mix
from tests import oracles


@dataclass(frozen=True)
class Tool:
    """One of ours, one of the oracle's, and the options that make the variant."""

    ours: Callable[..., Edit]
    oracle: Callable[..., np.ndarray]
    options: Mapping[str, Any] = field(default_factory=dict)
    takes_source: bool = True

    def edit(self, destination: np.ndarray, source: np.ndarray, mask: np.ndarray, **options: Any) -> Edit:
        """What our tool makes; `options` may hold solver options too."""
        pictures = (destination, source) if self.takes_source else (destination,)
        return self.ours(*pictures, mask, **self.options, **options)

    def exact(
        self, destination: np.ndarray, source: np.ndarray, mask: np.ndarray, **placement: Any
    ) -> np.ndarray:
        """The oracle's answer, float64, neither rounded nor clipped."""
        pictures = (destination, source) if self.takes_source else (destination,)
        return self.oracle(*pictures, mask, **self.options, **placement)


WITH_SOURCE = {
    "clone": Tool(clone, oracles.clone),
    "average": Tool(clone, oracles.clone, {"gradients": "average"}),
    "monochrome": Tool(clone, oracles.clone, {"monochrome": True}),
    "monochrome average": Tool(clone, oracles.clone, {"monochrome": True, "gradients": "average"}),
    "mix": Tool(mix, oracles.mix),
}
TOOLS = {**WITH_SOURCE, "fill": Tool(fill, oracles.fill, takes_source=False)}
