"""The tables inside the package as text, each with the document that holds such values and what was compared."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from slider_drilling.rig_papers import equipment, tubulars

Row = tuple[str, ...]


@dataclass(frozen=True)
class EquipmentTable:
    """A table.

    Attributes:
        head: Heads with units.
        source: Documents that hold such values, with their years.
        compared: Which rows were compared with which published text, and which could not be.
        rows: Function that gives the rows.
    """

    head: Row
    source: str
    compared: str
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
        "API Spec 5DP (2009), API RP 7G (1998)",
        "OD, weight and ID of each row: equal in at least one public list of drill pipe. Tool joints of NC46 (16.6"
        " X, S), NC50 (19.5 G, S) and 6 5/8 FH (27.7 S): equal in RP 7G's errata (2000) or a public list. Make-up "
        "torque of 5 1/2 FH 21.9 S: 52302 in RP 7G's errata (2000). The other tool joints could not be compared. "
        "Torques and weights follow from RP 7G's formulas; the longer tongs of 5DP (NC50: 21 in) would add 3 % to "
        "a weight",
        _drill_pipe,
    ),
    "heavy-weight": EquipmentTable(
        ("OD in", "ID in", "weight lb/ft", "connection", "tool joint in", "make-up ft lbf"),
        "Smith Services Dimensional Data Handbook (2002), API RP 7G (1998)",
        "3 1/2 to 5 in: ID and weight equal in a public list, which gives the 5 in a joint of 6 5/8. 5 1/2 and 6 "
        "5/8 in could not be compared: public lists hold other makes (5 1/2: ID 3.25; 6 5/8: joint 8.5)",
        _heavy_weight,
    ),
    "motors": EquipmentTable(
        ("size in", "lobes", "stages", "flow gal/min", "rev/gal", "ft lbf/psi", "full load psi", "stall psi", "leak"),
        f"{equipment.MOTOR_SOURCE}; torque, pressures and leak are usual values, see the motor's sheet",
        "no row: no public text of the handbook's table was at hand", _motors,
    ),
    "top-drives": EquipmentTable(
        ("name", "torque ft lbf", "speed rpm", "source"), "makers' data sheets",
        "TDS-11SA: torque equal in a public rig description. The other rows could not be compared",
        lambda: [(row.name, f"{row.torque:.0f}", f"{row.speed:.0f}", row.source) for row in equipment.TOP_DRIVES],
    ),
    "pumps": EquipmentTable(
        ("name", "stroke in", "largest liner in", "strokes/min"), equipment.PUMP_SOURCE,
        "all rows: stroke, largest liner and speed equal in public lists of pumps; one of two gives the 9-P-100 "
        "154 a minute",
        lambda: [(row.name, f"{row.stroke:g}", f"{row.largest_liner:g}", f"{row.speed:g}") for row in equipment.PUMPS],
    ),
}  # fmt: skip
