"""`slider-drilling torque-drag`: broomstick chart of a well, with a log's points on it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from slider_drilling.commands.options import (
    json_option,
    namespace_option,
    topics_option,
    units_option,
    write_and_print,
)
from slider_drilling.commands.weight_options import read_weights, weight_options

if TYPE_CHECKING:
    from slider_drilling.api.torque_drag import TorqueDragResult
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling torque-drag --rig rig.yaml -o torque_drag
  slider-drilling torque-drag --log run.mcap --friction 0.2 --friction 0.3
  slider-drilling torque-drag --rig rig.yaml --survey path.csv --units field
  slider-drilling torque-drag --rig rig.yaml --pick-up 260klbf --slack-off 121klbf --rotating 193klbf \\
      --free-torque 7000ft.lbf --block-weight 62klbf --units field
"""


@click.command(epilog=EXAMPLES)
@click.option("--rig", "rig_path", type=click.Path(path_type=Path),
              help="Rig file. [default: the log's own, or the example well]")  # fmt: skip
@click.option("--log", "log_path", type=click.Path(path_type=Path), help="Log to draw on the chart.")
@click.option("--survey", "survey_path", type=click.Path(path_type=Path),
              help="CSV survey instead of the rig file's: measured depth with unit (md_m, MD [ft]), inclination, "
              "azimuth. Also writes torque_drag.rig.yaml with it.")  # fmt: skip
@click.option("--friction", "frictions", multiple=True, type=click.FloatRange(0.0, 2.0),
              help="Friction coefficient; repeatable. [default: 0.15 to 0.35]")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("torque_drag"), show_default=True,
              help="Folder for torque_drag.html, .png and .csv.")  # fmt: skip
@click.option("--elements", default=200, show_default=True, type=click.IntRange(10, 5000),
              help="Elements of the string.")  # fmt: skip
@weight_options
@namespace_option
@topics_option
@units_option
@json_option
def command(
    rig_path: Path | None, log_path: Path | None, survey_path: Path | None, frictions: tuple[float, ...], output: Path,
    elements: int, namespace: str | None, topics_path: Path | None, units: Units, as_json: bool, **weights: Any,
) -> None:  # fmt: skip
    """Draw hook load and torque against depth for several friction coefficients, and loads along the string.

    Pick-up, slack-off and rotating weights and the free torque, typed in, from a table or found in the log, calibrate
    the friction of cased and open hole; torque_drag.rig.yaml then is the rig file with it.
    """
    from slider_drilling.api.torque_drag import FRICTIONS, torque_drag
    from slider_drilling.commands.torque_drag_rig import charted_rig
    from slider_drilling.console.streams import stderr
    from slider_drilling.files.output_files import check_outputs, make_folder
    from slider_drilling.log import read_log
    from slider_drilling.units import quantities_in

    make_folder(output)
    written = [output / f"torque_drag.{suffix}" for suffix in ("html", "png", "csv", "rig.yaml")]
    check_outputs(written, (rig_path, log_path, survey_path, topics_path, weights["weights_path"]))
    log = None if log_path is None else read_log(log_path, rig_path, namespace, topics_path)
    rig, remarks = charted_rig(rig_path, log, survey_path)
    result = torque_drag(
        rig, log=log, weights=read_weights(rig.string.length, weights), block_weight=weights["block_weight"],
        frictions=frictions or FRICTIONS, elements=elements, units=units,
    )  # fmt: skip
    result = replace(result, notes=(*remarks, *result.notes))
    for note in (*result.notes, *(result.calibration.notes if result.calibration else ())):
        stderr().print(f"note: {units.convert_text(quantities_in(str(note)))}", markup=False)
    write_and_print(result.tree() if as_json else None, lambda: _print(result, units),
                    lambda: result.save(output, units, survey_path is not None))  # fmt: skip


def _print(result: TorqueDragResult, units: Units) -> None:
    from rich.table import Table

    from slider_drilling.analysis.friction_tables import calibration_tables
    from slider_drilling.commands.options import print_tables
    from slider_drilling.console.streams import stdout
    from slider_drilling.units import format_number

    force, torque = units.display_unit("kN"), units.display_unit("kN m")
    table = Table("at total depth", f"slack off {force}", f"turning {force}", f"pick up {force}", f"to turn {torque}")
    for stick in result.sticks:
        name = {"contact": "rig's contact", "calibrated": "calibrated"}.get(stick.label, f"friction {stick.label}")
        loads = (units.convert(float(v[-1]) / 1e3, "kN") for v in (stick.slack_off, stick.rotating, stick.pick_up))
        turning = units.convert(float(stick.torque[-1]) / 1e3, "kN m")
        table.add_row(name, *(f"{load:.1f}" for load in loads), format_number(turning, 4))
    stdout().print(table)
    if result.calibration is not None:
        print_tables(calibration_tables(result.calibration, units), units)
