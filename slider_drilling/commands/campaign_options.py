"""Options of the commands that run a campaign."""

from __future__ import annotations

import click

jobs_option = click.option(
    "--jobs", default=1, show_default=True, type=click.IntRange(1, 1024),
    help="Processes of this machine, one thread each.",
)  # fmt: skip

scheduler_option = click.option(
    "--scheduler", default="", metavar="ADDRESS",
    help="Run on the workers of this dask.distributed scheduler (tcp://HOST:8786) instead.",
)  # fmt: skip
