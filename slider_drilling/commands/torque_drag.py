"""`slider-drilling torque-drag`: broomstick chart of a well, with a log's points on it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option, namespace_option, units_option, write_and_print

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slider_drilling.log import RigLog
    from slider_drilling.rig import Rig
    from slider_drilling.units import Units
    from slider_drilling.wellbore.broomstick import Broomstick

FRICTIONS = (0.15, 0.2, 0.25, 0.3, 0.35)
EXAMPLES = """\
Examples:

\b
  slider-drilling torque-drag --rig rig.yaml -o torque_drag
  slider-drilling torque-drag --log run.mcap --friction 0.2 --friction 0.3
  slider-drilling torque-drag --rig rig.yaml --survey path.csv --units field
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
@namespace_option
@units_option
@json_option
def command(
    rig_path: Path | None, log_path: Path | None, survey_path: Path | None, frictions: tuple[float, ...], output: Path,
    elements: int, namespace: str | None, units: Units, as_json: bool,
) -> None:  # fmt: skip
    """Draw hook load and torque against depth for several friction coefficients, and loads along the string."""
    from slider_drilling.analysis.torque_drag import hook_load_chart, log_points, torque_chart, torque_drag_page
    from slider_drilling.console.streams import stderr
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically
    from slider_drilling.log import read_log
    from slider_drilling.pages import write_page
    from slider_drilling.pages.png import render_png
    from slider_drilling.rig import dump_rig
    from slider_drilling.wellbore.broomstick import broomstick

    make_folder(output)
    page, image, table, changed = (output / name for name in ("torque_drag.html", "torque_drag.png", "torque_drag.csv",
                                                              "torque_drag.rig.yaml"))  # fmt: skip
    written = [page, image, table, *([changed] if survey_path is not None else [])]
    check_outputs(written, (rig_path, log_path, survey_path))
    log = None if log_path is None else read_log(log_path, rig_path, namespace)
    rig = _rig(rig_path, log, survey_path)
    sticks = [broomstick(rig, friction, elements=elements) for friction in (None, *(frictions or FRICTIONS))]
    points = None if log is None else log_points(log, rig)
    notes = () if log is None else log.notes
    for note in notes:
        stderr().print(f"note: {note}")

    def write() -> list[Path]:
        write_page(page, torque_drag_page(rig, sticks, points, notes, units), units)
        write_atomically(image, render_png((hook_load_chart(sticks, points), torque_chart(sticks, points)), units))
        write_atomically(table, _csv(sticks).encode())
        if survey_path is not None:
            write_atomically(changed, dump_rig(rig).encode())
        return written

    tree = {"at_total_depth": [_at_total_depth(stick) for stick in sticks], "notes": notes}
    write_and_print(tree if as_json else None, lambda: _print(sticks, units), write)


def _rig(rig_path: Path | None, log: RigLog | None, survey_path: Path | None) -> Rig:
    import dataclasses

    from slider_drilling.api.rigs import load_rig
    from slider_drilling.rig import check_rig
    from slider_drilling.wellbore.survey_table import read_survey

    has_own = log is not None and (rig_path is not None or log.rig_text is not None)
    rig = log.rig() if log is not None and has_own else load_rig(rig_path)
    if survey_path is None:
        return rig
    well = dataclasses.replace(rig.well, survey=read_survey(survey_path), name="")
    return check_rig(dataclasses.replace(rig, well=well), str(survey_path))


def _at_total_depth(stick: Broomstick) -> dict[str, float | None]:
    return {"friction": stick.friction, "slack_off_n": stick.slack_off[-1], "turning_n": stick.rotating[-1],
            "pick_up_n": stick.pick_up[-1], "torque_to_turn_n_m": stick.torque[-1]}  # fmt: skip


def _csv(sticks: Sequence[Broomstick]) -> str:
    lines = ["friction,bit_depth_m,slack_off_n,turning_n,pick_up_n,torque_to_turn_n_m"]
    for stick in sticks:
        name = "contact" if stick.friction is None else f"{stick.friction:g}"
        columns = zip(stick.depth, stick.slack_off, stick.rotating, stick.pick_up, stick.torque, strict=True)
        lines += [",".join([name, *(f"{value:.8g}" for value in row)]) for row in columns]
    return "\n".join(lines) + "\n"


def _print(sticks: Sequence[Broomstick], units: Units) -> None:
    from rich.table import Table

    from slider_drilling.console.streams import stdout

    force, torque = units.display_unit("kN"), units.display_unit("kN m")
    table = Table("at total depth", f"slack off {force}", f"turning {force}", f"pick up {force}", f"to turn {torque}")
    for stick in sticks:
        name = "rig's contact" if stick.friction is None else f"friction {stick.friction:g}"
        loads = (units.convert(float(v[-1]) / 1e3, "kN") for v in (stick.slack_off, stick.rotating, stick.pick_up))
        table.add_row(name, *(f"{load:.1f}" for load in loads), f"{units.convert(stick.torque[-1] / 1e3, 'kN m'):.4g}")
    stdout().print(table)
