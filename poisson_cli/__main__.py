"""``python -m poisson_cli`` is ``poisson``."""

from __future__ import annotations

from poisson_cli.main import main

main()
