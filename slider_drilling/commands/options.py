"""Options that several commands have."""

from __future__ import annotations

import click

namespace_option = click.option(
    "--namespace", help="Whose topics to read, where the log holds several rigs'; / for none."
)
