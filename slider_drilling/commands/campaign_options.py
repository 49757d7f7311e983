"""Options of commands that run many jobs."""

from __future__ import annotations

import click

jobs_option = click.option(
    "--jobs", default=1, show_default=True, type=click.IntRange(1, 1024),
    help="Processes on this machine, one thread each.",
)  # fmt: skip

scheduler_option = click.option(
    "--scheduler", default="", metavar="ADDRESS",
    help="Run on a dask.distributed cluster: address of its scheduler, tcp://HOST:8786.",
)  # fmt: skip
