"""`slider-drilling rocking-plan`: how to rock at each depth."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option, units_option_with, write_and_print
from slider_drilling.commands.quantity import QuantityType, read_depths

if TYPE_CHECKING:
    from slider_drilling.api.rocking_plan import RockingPlanResult
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling rocking-plan --rig rig.yaml --depths 9000ft:14500ft
  slider-drilling rocking-plan --rig rig.yaml --depths 9000ft:14500ft:500ft \\
      --differential-pressure 300psi --make-up-torque 26800ft.lbf
  slider-drilling rocking-plan --rig torque_drag/torque_drag.rig.yaml --block-weight 62klbf
"""


@click.command(epilog=EXAMPLES)
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), required=True, help="Rig file.")
@click.option("--depths", help="Measured depths of the bit: FROM:TO, FROM:TO:STEP or one depth, with units: "
              "9000ft:14500ft:500ft. [default: 8 depths from half of the string's length to all of it]")  # fmt: skip
@click.option("--rate-of-penetration", type=QuantityType("m/s", "9m/h"), help="That gives the load of the bit. "
              "[default: 9 m/h]")  # fmt: skip
@click.option("--differential-pressure", type=QuantityType("Pa", "300psi"),
              help="That gives the load of the bit, instead of the rate of penetration.")  # fmt: skip
@click.option("--toolface-swing", type=QuantityType("rad", "5deg"),
              help="Largest swing of the toolface to either side. [default: 5 deg]")  # fmt: skip
@click.option("--make-up-torque", type=QuantityType("N m", "26800ft.lbf"),
              help="Of the weakest connection. [default: the rig file's]")  # fmt: skip
@click.option("--back-off-torque", type=QuantityType("N m", "16000ft.lbf"),
              help="That loosens a connection. [default: 60 % of the make-up torque]")  # fmt: skip
@click.option("--period", type=QuantityType("s", "20s"),
              help="Rocking period. [default: 16 times the travel time of torsion, at least 10 s]")  # fmt: skip
@click.option("--block-weight", type=QuantityType("N", "62klbf"), default=0.0,
              help="Added to the hook loads of table, page and sheet. [default: 0, the string alone]")  # fmt: skip
@click.option("--elements", default=70, show_default=True, type=click.IntRange(10, 1000),
              help="Elements of the string.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("rocking_plan"), show_default=True,
              help="Folder for rocking_plan.html, .pdf, .json and the controllers' settings.")  # fmt: skip
@units_option_with("field")
@json_option
def command(
    rig_path: Path, depths: str | None, rate_of_penetration: float | None, differential_pressure: float | None,
    toolface_swing: float | None, make_up_torque: float | None, back_off_torque: float | None, period: float | None,
    block_weight: float, elements: int, output: Path, units: Units, as_json: bool,
) -> None:  # fmt: skip
    """Plan how to rock: turns right and left, torque, period, offset, what that frees and carries to the bit.

    One sheet for the driller (page and PDF), JSON, and settings for the controllers.
    """
    from slider_drilling.api.rigs import load_rig
    from slider_drilling.api.rocking_plan import plan_files, rocking_plan
    from slider_drilling.console.streams import progress_stages
    from slider_drilling.errors import InputError
    from slider_drilling.files.output_files import check_outputs, make_folder
    from slider_drilling.rocking_design.plan import PlanOptions

    if rate_of_penetration is not None and differential_pressure is not None:
        raise InputError("--rate-of-penetration and --differential-pressure: each gives the load of the bit; keep one")
    rig = load_rig(rig_path)
    places = None if depths is None else read_depths(depths, "--depths")
    options = PlanOptions(
        0.0025 if rate_of_penetration is None else rate_of_penetration, differential_pressure,
        math.radians(5.0) if toolface_swing is None else toolface_swing, make_up_torque, back_off_torque, period,
        elements,
    )  # fmt: skip
    make_folder(output)
    check_outputs(plan_files(output), (rig_path,))
    with progress_stages() as report:
        result = rocking_plan(rig, places, options=options, progress=lambda share: report("planning", share))
    write_and_print(result.tree if as_json else None, lambda: _print(result, units, block_weight),
                    lambda: result.save(output, units, block_weight))  # fmt: skip


def _print(result: RockingPlanResult, units: Units, block_weight: float) -> None:
    """One line for each quantity and a column for each depth, so that it fits a terminal."""
    from rich.table import Table

    from slider_drilling.console.streams import stdout
    from slider_drilling.rocking_design.plan_table import cell, columns, head, notes

    first, *rest = columns(block_weight)
    table = Table(", ".join(head(first, units)), *(cell(first, row, units) for row in result.rows))
    for column in rest:
        table.add_row(", ".join(filter(None, head(column, units))), *(cell(column, row, units) for row in result.rows))
    stdout().print(table)
    for note in notes(result.plan):
        stdout().print(units.convert_text(note))
