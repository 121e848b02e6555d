"""``poisson warmup``: compile ahead of time."""

from __future__ import annotations

import click

__all__ = ["command"]


@click.command(short_help="Compile the solver ahead of time.")
@click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
def command(quiet: bool) -> None:
    """Compile the solver for this machine, and keep it for all later runs.

    Without this the first run does it, which then takes some seconds longer: of use in images of containers, and
    before anything is timed. Prints where the compiled solver is kept and how large it is.

    \b
    It is kept in the folder that POISSON_CACHE_DIR names, by default in the user's
    cache folder, and compiled anew when this program, numba or the processor changes.
    """
    from poisson_cli import compiling
    from poisson_cli.errors import OutputError
    from solvers.kernels.policy import library
    from solvers.native import store
    from solvers.native.library import VOLUMES

    compiling.announce(quiet=quiet)
    obstacle = store.obstacle(store.folder())
    for volume in VOLUMES:
        if obstacle is not None and not library.is_kept(volume):
            raise OutputError(f"the solver is not compiled, {compiling.unkept(obstacle)}")
        library.addresses(volume)
    if library.trouble is not None:
        raise OutputError(
            f"the solver cannot be compiled ahead of time here ({library.trouble}); "
            "it works all the same, but begins more slowly"
        )
    for shelf in map(library.shelf, VOLUMES):
        if shelf.read() is None:
            reason = shelf.trouble or library.unkept or "no reason is known"
            raise OutputError(f"the solver was compiled in vain, {compiling.unkept(reason)}")
        if not quiet:
            click.echo(f"{shelf.path}: {shelf.path.stat().st_size / 1024:.0f} KiB")
