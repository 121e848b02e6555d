"""Picture files: bytes in, arrays and what belongs to them out, and back.

`read` gives a `Picture`; `prepare` checks an output before any work is done for it, `write` puts a picture there
whole or not at all, `write_together` several of them. Nothing outside this package knows a decoder.
"""

from __future__ import annotations

from poisson_cli.images.picture import Picture
from poisson_cli.images.reading import decode, decode_indices, read, read_bytes
from poisson_cli.images.target import Target, prepare
from poisson_cli.images.together import refuse_doubles, write_together
from poisson_cli.images.writing import write

__all__ = [
    "Picture",
    "Target",
    "decode",
    "decode_indices",
    "prepare",
    "read",
    "read_bytes",
    "refuse_doubles",
    "write",
    "write_together",
]
