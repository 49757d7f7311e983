"""Options that several commands have."""

from __future__ import annotations

import math

import click

namespace_option = click.option(
    "--namespace", help="Whose topics to read, where the log holds several rigs'; / for none."
)

seeds = click.IntRange(0, 2**31 - 1)


def finite(value: float | None) -> float | None:
    """The number for JSON, which has none that is not finite: None then."""
    return value if value is not None and math.isfinite(value) else None
