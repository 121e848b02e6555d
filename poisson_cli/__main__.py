"""The process ``poisson``, also as ``python -m poisson_cli``."""

from __future__ import annotations

import gc

__all__ = ["main"]


def main() -> None:
    """Run the command line of this process, and end it."""
    # Before anything is imported: the collector would go through what imports make, which is there to stay, again and
    # again, for more than 15 ms.
    gc.set_threshold(100_000)
    from poisson_cli.main import main as begin

    begin()


if __name__ == "__main__":
    main()
