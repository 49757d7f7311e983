"""A rocking plan as a table of numbers, as notes, and as JSON."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from slider_drilling import __version__
from slider_drilling.pages.titles import well_name
from slider_drilling.rocking_design.controller_settings import fixed_rocking_settings, slide_settings
from slider_drilling.rocking_design.plan import BACK_OFF_SHARE, MAKE_UP_SHARE, Plan, PlanRow
from slider_drilling.units import Quantity, Sentence, Units, format_number, sentence

SCHEMA = "slider_drilling/rocking_plan/1"


@dataclass(frozen=True)
class Column:
    """A column of the driller's table.

    Attributes:
        head: Short, without unit.
        unit: Of `value`; "" for none, "turns" and "rpm" in both unit systems.
        value: Of a row; None where it is not known.
        digits: Significant digits.
    """

    head: str
    unit: str
    value: Callable[[PlanRow], float | None]
    digits: int = 3


def columns(block_weight: float = 0.0) -> tuple[Column, ...]:
    """The table's columns; block_weight (N) is added to hook loads."""
    turn, rpm = 2.0 * math.pi, 2.0 * math.pi / 60.0
    return (
        Column("bit depth", "m", lambda row: row.depth, 5),
        Column("right", "turns", lambda row: row.right / turn),
        Column("left", "turns", lambda row: row.left / turn),
        Column("offset", "turns", lambda row: row.offset / turn),
        Column("period", "s", lambda row: row.drive.period),
        Column("speed", "rpm", lambda row: row.drive.speed / rpm),
        Column("torque right", "kN m", lambda row: row.steady.torque_right / 1e3),
        Column("torque left", "kN m", lambda row: row.steady.torque_left / 1e3),
        Column("rocks down to", "m", lambda row: row.steady.rocked_to, 5),
        Column("hook load", "kN", lambda row: (row.steady.hook_load + block_weight) / 1e3),
        Column("let down", "kN", lambda row: row.weight_let_down / 1e3),
        Column("at the bit", "kN", lambda row: row.steady.weight_on_bit / 1e3),
        Column("without rocking", "kN", lambda row: row.weight_without_rocking / 1e3),
        Column("toolface swings", "deg", lambda row: math.degrees(0.5 * row.steady.bit_swing), 2),
        Column("of make-up", "%", lambda row: _percent(row.make_up_share), 2),
        Column("of back-off", "%", lambda row: _percent(row.back_off_share), 2),
        Column("of buckling", "%", lambda row: _percent(row.steady.buckling), 2),
    )


def _percent(share: float | None) -> float | None:
    return None if share is None else 100.0 * share


def cell(column: Column, row: PlanRow, units: Units) -> str:
    """One number of the table as text, without its unit."""
    value = column.value(row)
    if value is None:
        return "-"
    shown = units.convert(value, column.unit) if column.unit not in ("turns", "rpm", "%", "deg", "") else value
    if column.unit == "turns":
        return f"{round(shown, 1) + 0.0:.1f}"  # no -0.0
    if column.unit in ("%", "rpm"):
        return f"{shown:.0f}"
    if column.unit == "kN":
        return f"{round(shown, 1) + 0.0:.1f}"
    whole = column.unit in ("m", "kN m") and abs(shown) >= 1000.0
    return f"{shown:.0f}" if whole else format_number(shown, column.digits)


def head(column: Column, units: Units) -> tuple[str, str]:
    """Head and unit of a column."""
    return column.head, column.unit if column.unit in ("turns", "rpm", "%", "deg") else units.display_unit(column.unit)


def title(plan: Plan, units: Units) -> str:
    """The well."""
    return units.convert_text(well_name(plan.rig))


def facts(plan: Plan) -> tuple[tuple[str, Sentence], ...]:
    """What the plan was made for."""
    load, limits = plan.rows[-1].load, plan.rows[-1].limits
    return (
        ("rate of penetration", sentence(Quantity(3600.0 * load.rate_of_penetration, "m/h"))),
        ("differential pressure", sentence(Quantity(load.differential_pressure / 1e5, "bar"))),
        ("weight on bit", sentence(Quantity(load.weight_on_bit / 1e3, "kN"))),
        ("reactive torque", sentence(Quantity(load.torque / 1e3, "kN m"))),
        ("make-up torque", sentence(Quantity(None if limits.make_up is None else limits.make_up / 1e3, "kN m"))),
        ("back-off torque", sentence(Quantity(None if limits.back_off is None else limits.back_off / 1e3, "kN m"))),
        ("toolface may swing", sentence(Quantity(math.degrees(plan.options.tool_face_swing), "deg", 2),
                                        " to either side")),
    )


def notes(plan: Plan) -> tuple[Sentence, ...]:
    """How to read the table, and what deserves attention."""
    lines = [
        sentence("Neutral is the angle of the top drive at which the string holds no torque off bottom with the "
                 "toolface on target. Turns are counted from there; a negative left turning point lies to the right "
                 "of neutral. Come to the offset as the differential pressure builds up."),
        sentence("Without rocking is the weight on bit at the same hook load with the top drive held."),
        sentence(f"Torque right stays below {100 * MAKE_UP_SHARE:.0f} % of the make-up torque of the weakest "
                 f"connection, torque left below {100 * MAKE_UP_SHARE:.0f} % of the back-off torque."),
    ]  # fmt: skip
    if plan.rows[-1].limits.make_up is None:
        lines.append(sentence("The make-up torque is not known: give make_up_torque in the rig file's sections, or "
                              "--make-up-torque. Only the top drive limits the torque."))  # fmt: skip
    elif plan.options.back_off_torque is None:
        lines.append(sentence(f"Back-off torque is assumed to be {100 * BACK_OFF_SHARE:.0f} % of the make-up torque."))
    lines += [_limit(row) for row in plan.rows if row.limited_by != "toolface"]
    worst = max(plan.rows, key=lambda row: row.steady.buckling)
    if worst.steady.buckling > 1.0:
        lines.append(sentence(f"The string buckles: compression is up to {worst.steady.buckling:.1f} times what "
                              "buckles it, at ", Quantity(worst.steady.buckling_depth, "m", 4), " with the bit at ",
                              Quantity(worst.depth, "m", 5), "."))  # fmt: skip
    return tuple(lines)


def _limit(row: PlanRow) -> Sentence:
    where = ("With the bit at ", Quantity(row.depth, "m", 5))
    if row.limited_by == "range of amplitudes":
        return sentence(*where, " even rocking of the whole string does not swing the toolface.")
    return sentence(*where, f" the {row.limited_by} limits the rocking; it frees the string down to ",
                    Quantity(row.steady.rocked_to, "m", 4), " only.")  # fmt: skip


def plan_json(plan: Plan) -> dict[str, Any]:
    """The plan in SI units and radians."""
    return {
        "schema": SCHEMA,
        "version": __version__,
        "options": asdict(plan.options),
        "rows": [_row(plan, row) for row in plan.rows],
        "notes": [str(note) for note in notes(plan)],
    }


def _row(plan: Plan, row: PlanRow) -> dict[str, Any]:
    return {
        "depth": row.depth,
        "right": row.right,
        "left": row.left,
        "offset": row.offset,
        "amplitude": row.amplitude,
        "period": row.drive.period,
        "speed": row.drive.speed,
        "torque_right": row.steady.torque_right,
        "torque_left": row.steady.torque_left,
        "rocked_to": row.steady.rocked_to,
        "rocked_to_closed_form": row.closed_form_reach,
        "tool_face_swing": 0.5 * row.steady.bit_swing,
        "rotating_weight": row.rotating_weight,
        "hook_load": row.steady.hook_load,
        "weight_let_down": row.weight_let_down,
        "weight_on_bit": row.steady.weight_on_bit,
        "weight_on_bit_without_rocking": row.weight_without_rocking,
        "reactive_torque": row.load.torque,
        "differential_pressure": row.load.differential_pressure,
        "rate_of_penetration": row.load.rate_of_penetration,
        "make_up_torque": row.limits.make_up,
        "back_off_torque": row.limits.back_off,
        "make_up_share": row.make_up_share,
        "back_off_share": row.back_off_share,
        "buckling_share": row.steady.buckling,
        "buckling_depth": row.steady.buckling_depth,
        "limited_by": row.limited_by,
        "controllers": {
            "FixedRocking": asdict(fixed_rocking_settings(plan.rig, row)),
            "SlideController": asdict(slide_settings(row)),
        },
    }
