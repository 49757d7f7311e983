"""Friction of hole intervals, and a calibration from the driller's weights, as tables and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from slider_drilling.analysis.calibrate_friction import FrictionCalibration
from slider_drilling.analysis.driller_weights import MOTIONS, DrillerWeights
from slider_drilling.analysis.fit_friction import IntervalFriction
from slider_drilling.pages import Table
from slider_drilling.pages.page import Cell
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Units


def calibration_tables(calibration: FrictionCalibration, units: Units) -> tuple[Table, ...]:
    """Friction factors with their intervals, and every reading beside what the calibrated model says."""
    return friction_table(calibration.intervals, _caption(calibration, units), units), _readings(calibration, units)


def friction_table(intervals: Sequence[IntervalFriction], caption: str, units: Units) -> Table:
    """Factor with its interval, that of the rig file, and the coefficients of each hole interval."""
    header = ("hole", "friction factor (95 %)", "in the rig file", "coefficient along", "coefficient around")
    rows: list[tuple[Cell, ...]] = []
    for row in intervals:
        low, high = row.factor_interval
        factor = f"{row.factor:.3f} ({low:.3f} to {high:.3f})" + ("" if row.is_determined else ", not determined")
        hole = f"{row.kind}, {units.format_range(row.top, row.bottom, 'm', 4)}"
        rows.append((hole, factor, f"{row.in_rig_file:.3f}", f"{row.axial:.3f}", f"{row.tangential:.3f}"))
    return Table(header, tuple(rows), caption)


def friction_json(intervals: Sequence[IntervalFriction]) -> list[dict[str, Any]]:
    """The intervals in SI units."""
    return [
        {
            "hole": row.kind, "from": row.top, "to": row.bottom, "factor": row.factor,
            "factor_interval": list(row.factor_interval), "factor_in_rig_file": row.in_rig_file,
            "friction_coefficient_along": row.axial, "friction_coefficient_around": row.tangential,
            "determined": row.is_determined,
        }
        for row in intervals
    ]  # fmt: skip


def _caption(calibration: FrictionCalibration, units: Units) -> str:
    change = 100.0 * (calibration.weight_factor - 1.0)
    text = f"The string weighs {abs(change):.1f} % {'more' if change >= 0.0 else 'less'} than in the rig file. "
    text += f"Block weight taken off: {units.format(calibration.block_weight / 1e3, 'kN')}; "
    text += f"tare error {units.format(calibration.tare_error / 1e3, 'kN', 2)}."
    if calibration.torque_factor is not None:
        text += f" Friction torque is {calibration.torque_factor:.2f} times that of the rig file's contact."
    if not all(row.is_determined for row in calibration.intervals):
        text += " Where the readings do not determine a factor, the rig file's ratio to the other intervals is kept."
    return text


def _readings(calibration: FrictionCalibration, units: Units) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for read, model in zip(calibration.weights, calibration.predicted, strict=True):
        for name in (*MOTIONS, "torque"):
            value, found = getattr(read, name), getattr(model, name)
            if value is not None:
                unit = "kN m" if name == "torque" else "kN"
                rows.append((units.format(read.depth, "m", 5), plain_name(name),
                             units.format(value / 1e3, unit, 4), units.format(found / 1e3, unit, 4)))  # fmt: skip
    return Table(("bit depth", "reading", "driller, without the block", "calibrated model"), tuple(rows), "Readings")


def calibration_json(calibration: FrictionCalibration | None) -> dict[str, Any] | None:
    """The calibration in SI units."""
    if calibration is None:
        return None
    return {
        "friction": friction_json(calibration.intervals),
        "block_weight": calibration.block_weight,
        "tare_error": calibration.tare_error,
        "weight_factor": calibration.weight_factor,
        "torque_factor": calibration.torque_factor,
        "readings": [_reading(row) for row in calibration.weights],
        "predicted": [_reading(row) for row in calibration.predicted],
        "notes": list(calibration.notes),
    }  # fmt: skip


def _reading(row: DrillerWeights) -> dict[str, float | None]:
    return {"depth": row.depth, "torque": row.torque, **{motion: getattr(row, motion) for motion in MOTIONS}}
