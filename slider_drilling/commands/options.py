"""Options that several commands have."""

from __future__ import annotations

import math

import click

namespace_option = click.option(
    "--namespace", help="Whose topics to read, where the log holds several rigs'; / for none."
)

jobs_option = click.option(
    "--jobs", default=1, show_default=True, type=click.IntRange(1, 1024),
    help="Processes of this machine, one thread each; a core each is what they can use.",
)  # fmt: skip

scheduler_option = click.option(
    "--scheduler", default="", metavar="ADDRESS",
    help="Run on the workers of this dask.distributed scheduler (tcp://HOST:8786) instead.",
)  # fmt: skip

seeds = click.IntRange(0, 2**31 - 1)


def finite(value: float | None) -> float | None:
    """The number for JSON, which has none that is not finite: None then."""
    return value if value is not None and math.isfinite(value) else None
