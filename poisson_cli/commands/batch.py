"""``poisson batch``: many jobs from a list."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from poisson_cli.params import COUNT, FILE, POSITIVE, SHARD, SIZE

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["command"]


@click.command(short_help="Do many jobs from a list, on every core or on a cluster.")
@click.argument("manifest", type=FILE)
@click.option(
    "-j",
    "--jobs",
    type=COUNT,
    metavar="N",
    help="Jobs to do at a time, each in a process and on a thread of its own; by default as many as there are cores.",
)
@click.option(
    "--keep-going/--fail-fast",
    default=True,
    show_default=True,
    help="After a job has failed, go on with the others; or begin no more, and finish those that run.",
)
@click.option(
    "--skip-existing",
    is_flag=True,
    help="Skip jobs whose outputs are there: so a batch that was stopped goes on.",
)
@click.option("--overwrite", is_flag=True, help="Replace outputs that exist.")
@click.option("--make-folders", is_flag=True, help="Make the folders of outputs that are not there.")
@click.option(
    "--shard",
    type=SHARD,
    metavar="I/N",
    default="1/1",
    help="Do the I-th of N equal shares only, for several machines on one list.",
)
@click.option(
    "--default",
    "defaults",
    metavar="NAME=VALUE",
    multiple=True,
    help="Say this for every job that does not say otherwise, such as tolerance=.001; may be repeated.",
)
@click.option(
    "--report",
    type=FILE,
    metavar="FILE",
    help="Write a JSON line for each job as it ends, and one for the whole at the end; - is stdout. With "
    "--skip-existing they go behind those that are there.",
)
@click.option(
    "--dry-run", is_flag=True, help="Check the list, print each job as a command line, and do nothing."
)
@click.option(
    "--memory",
    type=SIZE,
    metavar="SIZE",
    help="Begin a job only if it fits beside those that run, by an estimate from the sizes of its pictures: together "
    "they may need so much, such as 800M or 12G; by default most of what is free.",
)
@click.option(
    "--timeout",
    type=POSITIVE,
    metavar="SECONDS",
    help="A job that takes longer has failed, and its process is ended; by default it may take for ever.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Do the jobs on the Dask cluster whose scheduler is at ADDRESS, or on one that is started here, if that is "
    "local. Needs pip install 'poisson-cli[cluster]'.",
)
@click.option("-q", "--quiet", is_flag=True, help="Say nothing on stderr but why jobs failed.")
def command(
    manifest: Path,
    jobs: int | None,
    keep_going: bool,
    skip_existing: bool,
    overwrite: bool,
    make_folders: bool,
    shard: tuple[int, int],
    defaults: tuple[str, ...],
    report: Path | None,
    dry_run: bool,
    memory: int | None,
    timeout: float | None,
    scheduler: str | None,
    quiet: bool,
) -> None:
    """Do all jobs that MANIFEST lists, one a line: JSON Lines or CSV, from standard input if it is -.

    A line names a command as its tool and says what its command line would say, under the same names: arguments, and
    options without their dashes. Paths are relative to MANIFEST. All lines are checked before the first job runs.

    A job that fails, or takes its process along, stops no other. Ends with 0 if all were done, with 1 if some failed.

    \b
    Example: jobs.jsonl has lines such as
      {"tool": "clone", "source": "a.png", "destination": "b.png", "mask": "m.png",
       "at": [40, 25], "output": "out/a.png"}
    in one line each. Do them, and go on where it was stopped if it was:
      poisson batch jobs.jsonl --skip-existing --report report.jsonl
    """
    if skip_existing and overwrite:
        raise click.UsageError("--skip-existing and --overwrite contradict each other.")
    if scheduler is not None and memory is not None:
        raise click.UsageError(
            "--memory is for this machine; the workers of a cluster have their own limits."
        )
    if scheduler is not None and timeout is not None:
        raise click.UsageError("--timeout is for this machine; no job of a cluster can be ended by itself.")
    if report is not None and report.exists() and manifest.exists() and report.samefile(manifest):
        raise click.UsageError("--report would write into MANIFEST; give it another name.")
    pairs = [default.partition("=") for default in defaults]
    if wrong := next((name for name, equals, _ in pairs if not (name and equals)), None):
        raise click.UsageError(f"--default {wrong} has no value: write it as NAME=VALUE.")

    from poisson_cli.batch import command as batch
    from poisson_cli.batch.mistakes import Mistakes

    choices = batch.Choices(
        jobs=jobs,
        keep_going=keep_going,
        skip_existing=skip_existing,
        overwrite=overwrite,
        make_folders=make_folders,
        shard=shard,
        defaults=tuple((name, value) for name, _, value in pairs),
        report=report,
        dry_run=dry_run,
        memory=memory,
        timeout=timeout,
        scheduler=scheduler,
        quiet=quiet,
    )
    try:
        code = batch.run(manifest, choices)
    except Mistakes as mistakes:
        for line in mistakes.lines():
            click.echo(f"poisson: error: {line}", err=True)
        code = mistakes.exit_code
    click.get_current_context().exit(code)
