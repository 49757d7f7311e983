"""Check position against speed: their units and signs agree, the drive's limits hold, the angle is continuous."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array, JointSeries
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_inputs.commands_from_log import unfilled_field
from slider_drilling.log_inputs.fuse_position_and_speed import quantisation_step
from slider_drilling.rig import Rig
from slider_drilling.units import KINDS

_UNIT_TOLERANCE = 0.1  # relative, of a ratio to that of two units
_MAX_OVERSPEED = 1.5  # times the drive's limit
_MIN_STEPS = 10.0  # rounding steps of a coarse position over which its slope is taken


@dataclass(frozen=True)
class _Axis:
    """What moves.

    Attributes:
        name: In words.
        position: What its position is called.
        speeds: Units, with their SI value, that the speed may wrongly be in.
        positions: Likewise of the position.
        units: SI units of position and speed.
    """

    name: str
    position: str
    speeds: Mapping[str, float]
    positions: Mapping[str, float]
    units: tuple[str, str]


_DRIVE = _Axis(
    "the top drive", "angle", {name: KINDS["angular speed"][name] for name in ("deg/s", "rpm", "rev/s")},
    {name: KINDS["angle"][name] for name in ("deg", "rev")}, ("rad", "rad/s"),
)  # fmt: skip
_BLOCK = _Axis(
    "the block", "position", {name: KINDS["speed"][name] for name in ("m/min", "m/h", "ft/s", "ft/min", "ft/h")},
    {name: KINDS["length"][name] for name in ("ft", "mm", "cm")}, ("m", "m/s"),
)  # fmt: skip


def check_position_and_speed(log: RigLog, rig: Rig) -> list[LogIssue]:
    """Units and signs of position against speed, speeds beyond the drive's limit, angles that jump."""
    drive = log.top_drive
    if drive is None:
        return []
    disagreement = _disagreement(drive, _DRIVE, rig.top_drive.max_speed)
    if disagreement is not None:
        return [LogIssue("unusable", "top_drive", disagreement, "units and levels")]
    jumps = _angle_jumps(*_slope_and_speed(drive), rig)
    if jumps is not None:
        return [LogIssue("unusable", "top_drive", jumps, "units and levels")]
    issues = [*_all_zero(drive, _DRIVE, "top_drive"), *_too_fast(drive, rig)]
    if log.draw_works is not None:
        issues += _all_zero(log.draw_works, _BLOCK, "draw_works")
        disagreement = _disagreement(log.draw_works, _BLOCK)
        if disagreement is not None:
            issues.append(LogIssue("unusable", "draw_works", disagreement, "units and levels"))
    return issues


def _all_zero(series: JointSeries, axis: _Axis, channel: str) -> list[LogIssue]:
    """A note on a position or speed that is zero throughout and is computed from the other."""
    empty = unfilled_field(series)
    if empty is None:
        return []
    missing, given = ("speed", axis.position) if empty == "velocity" else (axis.position, "speed")
    text = f"{axis.name}'s {missing} is zero throughout, its {given} is not: {missing} is computed from {given}"
    return [LogIssue("note", channel, text)]


def _slope_and_speed(series: JointSeries, coarse: bool = False) -> tuple[Array, Array, Array]:
    """Slope of the position, and logged speed, between samples.

    Args:
        series: Position and speed.
        coarse: Take samples so far apart that the position passes several of its rounding steps.

    Returns:
        Time (m,) s, slope (m,) and speed (m,).
    """
    known = np.isfinite(series.position) & np.isfinite(series.velocity)
    if np.count_nonzero(known) < 3:
        return np.empty(0), np.empty(0), np.empty(0)
    time, position, speed = series.time[known], series.position[known], series.velocity[known]
    travelled = cumulative_trapezoid(speed, time, initial=0.0)
    every = 1
    if coarse:
        mean_step = float(np.mean(np.abs(np.diff(position))))
        every = max(1, int(np.ceil(_MIN_STEPS * quantisation_step(position) / mean_step))) if mean_step > 0.0 else 1
    time, position, travelled = time[::every], position[::every], travelled[::every]
    return time[1:], np.diff(position) / np.diff(time), np.diff(travelled) / np.diff(time)


def _disagreement(series: JointSeries, axis: _Axis, max_speed: float = math.inf) -> str | None:
    """Why the speed is not the slope of the position, None if it is; max_speed: that the rig file gives, SI."""
    _, slope, speed = _slope_and_speed(series, coarse=True)
    fast = float(np.quantile(np.abs(slope), 0.95)) if slope.size else 0.0
    moving = np.abs(slope) > 0.2 * fast
    if fast <= 0.0 or np.count_nonzero(moving) < 10:
        return None
    # A median over what moves: jumps of an encoder do not count.
    ratio = float(np.median(speed[moving] / slope[moving]))
    within = np.abs(speed[moving] - ratio * slope[moving]) < 0.25 * np.abs(ratio * slope[moving])
    if np.mean(within) < 0.5:
        return None
    finding = f"{axis.name}'s speed is {ratio:.4g} times the slope of its {axis.position}"
    if ratio < 0.0:
        return f"{finding}: one of the two has the wrong sign"
    # Rounding changes the speed by up to half of its step.
    rounding = min(0.5 * quantisation_step(series.velocity[np.isfinite(series.velocity)]) / fast, 1.0)
    if 0.8 - rounding < ratio < 1.25 + rounding:
        return None
    # Of a speed and a slope that no such drive reaches, that one is wrong: the other's unit does not explain it.
    speed_may_be_right = float(np.quantile(np.abs(speed), 0.95)) <= _MAX_OVERSPEED * max_speed
    position_may_be_right = fast <= _MAX_OVERSPEED * max_speed
    hints = _mistaken_speed(ratio, axis) if position_may_be_right else []
    hints += _mistaken_position(ratio, axis) if speed_may_be_right else []
    if not hints:
        return f"{finding}: one of the two is not in {axis.units[0]} and s"
    must = f"; the {axis.position} must be in {axis.units[0]}, the speed in {axis.units[1]}"
    return f"{finding}: {', or '.join(hints)}{must}"


def _mistaken_speed(ratio: float, axis: _Axis) -> list[str]:
    """What the speed looks like if the position is right: it is in another unit, or was converted from one."""
    given = [name for name, si in axis.speeds.items() if abs(ratio * si - 1.0) < _UNIT_TOLERANCE]
    converted = [name for name, si in axis.speeds.items() if abs(ratio / si - 1.0) < _UNIT_TOLERANCE]
    return _looks_like("speed", given, converted, axis.units[1])


def _mistaken_position(ratio: float, axis: _Axis) -> list[str]:
    """What the position looks like if the speed is right."""
    given = [name for name, si in axis.positions.items() if abs(ratio / si - 1.0) < _UNIT_TOLERANCE]
    converted = [name for name, si in axis.positions.items() if abs(ratio * si - 1.0) < _UNIT_TOLERANCE]
    return _looks_like(axis.position, given, converted, axis.units[0])


def _looks_like(name: str, given: Sequence[str], converted: Sequence[str], si: str) -> list[str]:
    hints = [f"the {name} looks like {' or '.join(given)}"] if given else []
    return hints + ([f"the {name} looks like {si} that was imported as {' or '.join(converted)}"] if converted else [])


def _angle_jumps(time: Array, slope: Array, speed: Array, rig: Rig) -> str | None:
    """An encoder that wraps or was reset: the angle jumps faster than the drive can turn, the speed does not."""
    jumps = (np.abs(slope) > 2.0 * rig.top_drive.max_speed) & (np.abs(speed) < 0.5 * np.abs(slope))
    if not jumps.any():
        return None
    first = int(np.flatnonzero(jumps)[0])
    return (
        f"the top drive's angle jumps at {np.count_nonzero(jumps)} places, first at {time[first]:.1f} s, where its "
        f"speed is {speed[first]:.2f} rad/s: an encoder that wraps or was reset; make the angle continuous"
    )


def _too_fast(drive: JointSeries, rig: Rig) -> list[LogIssue]:
    speeds = drive.velocity[np.isfinite(drive.velocity)]
    known = np.isfinite(drive.position)
    if speeds.size == 0 and np.count_nonzero(known) > 2:
        speeds = np.diff(drive.position[known]) / np.diff(drive.time[known])
    if speeds.size < 3:
        return []
    fastest, limit = float(np.quantile(np.abs(speeds), 0.99)), rig.top_drive.max_speed
    if fastest <= _MAX_OVERSPEED * limit:
        return []
    units = [name for name, si in _DRIVE.speeds.items() if fastest * si <= limit]
    advice = f"; it looks like {' or '.join(units)}" if units else ""
    text = (
        f"the top drive turns at {fastest:.4g} rad/s, but the rig file's top_drive.max_speed is {limit:g} rad/s{advice}"
    )
    return [LogIssue("unusable", "top_drive", text, "units and levels")]
