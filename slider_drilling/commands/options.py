"""Options that several commands have."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from slider_drilling.units import Units

namespace_option = click.option(
    "--namespace", help="Whose topics to read, where the log holds several rigs'; / for none."
)


def _units(context: click.Context, option: click.Parameter, value: str) -> Units:
    from slider_drilling.units import UNITS

    return UNITS[value]


units_option = click.option(
    "--units", type=click.Choice(["si", "field"]), default="si", show_default=True, envvar="SLIDER_DRILLING_UNITS",
    show_envvar=True, callback=_units,
    help="Of tables, pages and pictures: m, kN, bar, kN m, rad; or ft, klbf, psi, ft lbf, turns.",
)  # fmt: skip
