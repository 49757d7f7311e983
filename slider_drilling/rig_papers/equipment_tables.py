"""The tables inside the package as text, each with the document to compare it with."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from slider_drilling.rig_papers import equipment, tubulars

Row = tuple[str, ...]


@dataclass(frozen=True)
class EquipmentTable:
    """Heads with units, the document that holds such values, and a function that gives the rows."""

    head: Row
    source: str
    rows: Callable[[], Iterable[Row]]


def _drill_pipe() -> Iterable[Row]:
    for pipe in tubulars.DRILL_PIPE:
        for grade, strength in tubulars.GRADES.items():
            outer, inner = pipe.tool_joint(grade)
            torque = tubulars.make_up_torque(tubulars.CONNECTIONS[pipe.connection], outer, inner)
            body = tubulars.torsional_yield(pipe.outer_diameter, pipe.inner_diameter, strength)
            yield (f"{pipe.outer_diameter:g}", f"{pipe.nominal_weight:g}", grade, f"{pipe.inner_diameter:g}",
                   f"{tubulars.adjusted_weight(pipe, grade):.2f}", pipe.connection, f"{outer:g} x {inner:g}",
                   f"{torque:.0f}", f"{body:.0f}")  # fmt: skip


def _heavy_weight() -> Iterable[Row]:
    for pipe in tubulars.HEAVY_WEIGHT_PIPE:
        torque = tubulars.make_up_torque(tubulars.CONNECTIONS[pipe.connection], *pipe.tool_joint)
        yield (f"{pipe.outer_diameter:g}", f"{pipe.inner_diameter:g}", f"{pipe.weight:g}", pipe.connection,
               f"{pipe.tool_joint[0]:g} x {pipe.tool_joint[1]:g}", f"{torque:.0f}")  # fmt: skip


def _motors() -> Iterable[Row]:
    for motor in equipment.MOTORS:
        full = motor.stages * equipment.PRESSURE_PER_STAGE
        ideal = 231.0 / motor.revolutions / (2.0 * 3.141592653589793) / 12.0  # ft lbf/psi; a gallon has 231 in3
        yield (f"{motor.size:g}", motor.lobes, f"{motor.stages:g}", f"{motor.flow[0]:g} to {motor.flow[1]:g}",
               f"{motor.revolutions:g}", f"{equipment.TORQUE_EFFICIENCY * ideal:.2f}", f"{full:.0f}",
               f"{equipment.STALL_OVER_FULL_LOAD * full:.0f}", f"{equipment.LEAK:g}")  # fmt: skip


EQUIPMENT_TABLES = {
    "drill-pipe": EquipmentTable(
        ("OD in", "nominal lb/ft", "grade", "ID in", "adjusted lb/ft", "connection", "tool joint in", "make-up ft lbf",
         "torsional yield ft lbf"),
        "API Spec 5DP (2009), API RP 7G (1998)", _drill_pipe,
    ),
    "heavy-weight": EquipmentTable(
        ("OD in", "ID in", "weight lb/ft", "connection", "tool joint in", "make-up ft lbf"),
        "Smith Services Dimensional Data Handbook (2002), API RP 7G (1998)", _heavy_weight,
    ),
    "motors": EquipmentTable(
        ("size in", "lobes", "stages", "flow gal/min", "rev/gal", "ft lbf/psi", "full load psi", "stall psi", "leak"),
        f"{equipment.MOTOR_SOURCE}; torque, pressures and leak are usual values, see the motor's sheet", _motors,
    ),
    "top-drives": EquipmentTable(
        ("name", "torque ft lbf", "speed rpm", "source"), "makers' data sheets",
        lambda: [(row.name, f"{row.torque:.0f}", f"{row.speed:.0f}", row.source) for row in equipment.TOP_DRIVES],
    ),
    "pumps": EquipmentTable(
        ("name", "stroke in", "largest liner in", "strokes/min"), equipment.PUMP_SOURCE,
        lambda: [(row.name, f"{row.stroke:g}", f"{row.largest_liner:g}", f"{row.speed:g}") for row in equipment.PUMPS],
    ),
}  # fmt: skip
