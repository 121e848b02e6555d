"""The command line: the group of subcommands, and the one place where an exception becomes an exit code.

``--help`` should answer at once, so neither this module nor a command imports anything at its top that only the work
itself needs.
"""

from __future__ import annotations

import contextlib
import errno
import importlib
import os
import sys
from typing import TYPE_CHECKING, Final

import click

from poisson_cli import __version__, commands, errors
from poisson_cli.options import Chatter
from poisson_cli.streams import complete, printable, silence

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["cli", "main", "run"]


_NO_ROOM: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


class _CommandFolder(click.Group):
    """A group whose commands are the modules of ``poisson_cli.commands``, each imported when it is asked for.

    The file's name is the command's name; its attribute ``command`` is the command.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        stems = (os.path.splitext(name) for name in os.listdir(commands.__path__[0]))
        return sorted(stem for stem, ending in stems if ending == ".py" and not stem.startswith("_"))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self.list_commands(ctx):
            return None
        module = importlib.import_module(f"{commands.__name__}.{cmd_name}")
        command: click.Command = module.command
        return command


@click.group(
    cls=_CommandFolder, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100}
)
@click.version_option(__version__, prog_name="poisson")
def cli() -> None:
    """Edit photographs by their gradients, exactly: clone, mix and fill, change texture, light and colours, make tiles
    (Perez, Gangnet and Blake, Poisson Image Editing, 2003).

    Only the pixels that you select change. All others keep their values, bit for bit.

    \b
    Example:
      poisson clone bird.jpg sky.png -m bird-mask.png --at 320,40 -o out.png
    """


def run(argv: Sequence[str]) -> int:
    """Run one command line in this process.

    Errors are printed as the real process prints them. An interrupt is not one of them: `KeyboardInterrupt` and
    its like pass through, because they are meant for the whole process.

    Parameters
    ----------
    argv
        The words after ``poisson``.

    Returns
    -------
    int
        The exit code; see `poisson_cli.errors`.
    """
    chatter = Chatter(verbose=bool(os.environ.get("POISSON_TRACEBACK")))
    try:
        with cli.make_context("poisson", list(argv), obj=chatter) as context:
            cli.invoke(context)
    except click.exceptions.Exit as stop:  # --help and --version end this way
        return stop.exit_code
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except BrokenPipeError:
        return errors.BROKEN_PIPE
    except Exception as error:
        if isinstance(error, OSError) and error.errno in _NO_ROOM and error.filename is None:
            # Files have been seen to by whoever wrote them, so it is what is printed that finds no room.
            silence(sys.stdout)
            error = errors.OutputError(f"standard output: cannot be written ({error.strerror})")
        code, message = errors.verdict(error)
        if isinstance(error, (errors.PoissonError, MemoryError)):
            _print_error(message)
        elif chatter.verbose:
            import traceback

            traceback.print_exc()
            _print_error(
                f"unexpected {type(error).__name__}; this is a bug, please report it with the lines above"
            )
        else:
            _print_error(f"{message}, -v shows where it happened")
        return code
    return errors.DONE


def main() -> None:
    """Be the process ``poisson``: run the command line and exit with its code."""
    complete()
    if "_POISSON_COMPLETE" in os.environ:  # a shell asks what could come next
        try:
            cli.main(prog_name="poisson")
        except SystemExit as stop:
            _leave_at_once(stop.code if isinstance(stop.code, int) else errors.DONE)
    # No thread pool that nobody asked for: it costs more to set up than a clone takes.  Read when numpy is loaded.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from poisson_cli import interrupts

    interrupts.listen()
    try:
        code = run(sys.argv[1:])
        sys.stdout.flush()
    except KeyboardInterrupt:
        _print_error("interrupted")
        code = errors.INTERRUPTED
    except errors.Terminated:
        _print_error("terminated")
        code = errors.TERMINATED
    except errors.HungUp:
        code = errors.HUNG_UP
    except BrokenPipeError:
        code = errors.BROKEN_PIPE
    if code == errors.BROKEN_PIPE:
        silence(sys.stdout)
    _leave_at_once(code)


def _leave_at_once(code: int) -> None:
    """End the process without taking it apart, which after a clone takes 30 ms for nothing.

    Nor does it wait for threads that still compute, when an interrupt left some behind; see `poisson_cli.answering`.
    """
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):
            stream.flush()
    os._exit(code)


def _print_error(message: str) -> None:
    """One line on stderr, whatever line breaks the message has."""
    with contextlib.suppress(OSError):  # nobody listens: the exit code says it as well
        click.echo(f"poisson: error: {printable(' '.join(message.split()))}", err=True)
