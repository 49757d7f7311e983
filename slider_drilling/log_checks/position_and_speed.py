"""Whether positions and speeds agree with each other and with what the top drive can do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array, JointSeries
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_inputs.drives_from_log import unfilled
from slider_drilling.log_inputs.fuse_position_and_speed import rounding_step
from slider_drilling.rig import Rig
from slider_drilling.units import KINDS

_CLOSE = 0.1  # how near a ratio must be to that of two units
_BEYOND = 1.5  # times the drive's limit of speed
_STEPS = 10.0  # of a coarse position, that a slope is taken over at least


@dataclass(frozen=True)
class _Axis:
    """What moves, its two quantities in words, and the units that either may wrongly be in."""

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
    """Units and signs of position against speed, speeds beyond the drive's limit, angles that step."""
    drive = log.top_drive
    if drive is None:
        return []
    disagreement = _disagreement(drive, _DRIVE)
    if disagreement is not None:
        return [LogIssue("unusable", "top_drive", disagreement)]
    stepped = _steps(*_slope_and_speed(drive), rig)
    if stepped is not None:
        return [LogIssue("unusable", "top_drive", stepped)]
    found = [*_unfilled(drive, _DRIVE, "top_drive"), *_too_fast(drive, rig)]
    if log.draw_works is not None:
        found += _unfilled(log.draw_works, _BLOCK, "draw_works")
        disagreement = _disagreement(log.draw_works, _BLOCK)
        found += [LogIssue("unusable", "draw_works", disagreement)] if disagreement is not None else []
    return found


def _unfilled(series: JointSeries, axis: _Axis, channel: str) -> list[LogIssue]:
    """A note of a position or a speed that is zero throughout and taken from the other."""
    empty = unfilled(series)
    if empty is None:
        return []
    words = ("speed", axis.position) if empty == "velocity" else (axis.position, "speed")
    text = f"{axis.name}'s {words[0]} is zero throughout, its {words[1]} is not: it is taken from the {words[1]}"
    return [LogIssue("note", channel, text)]


def _slope_and_speed(series: JointSeries, coarse: bool = False) -> tuple[Array, Array, Array]:
    """Times s between samples, slope of the position there and the speed that was logged, (m,) each; coarse: between
    samples that are so far apart that the position goes through some of its steps.
    """
    known = np.isfinite(series.position) & np.isfinite(series.velocity)
    if np.count_nonzero(known) < 3:
        return np.empty(0), np.empty(0), np.empty(0)
    time, position, speed = series.time[known], series.position[known], series.velocity[known]
    way = cumulative_trapezoid(speed, time, initial=0.0)
    apart = 1
    if coarse:
        usual = float(np.mean(np.abs(np.diff(position))))
        apart = max(1, int(np.ceil(_STEPS * rounding_step(position) / usual))) if usual > 0.0 else 1
    time, position, way = time[::apart], position[::apart], way[::apart]
    return time[1:], np.diff(position) / np.diff(time), np.diff(way) / np.diff(time)


def _disagreement(series: JointSeries, axis: _Axis) -> str | None:
    """Why a speed is not the slope of its position. Their ratio is a median over what moves: steps do not count."""
    _, slope, speed = _slope_and_speed(series, coarse=True)
    usual = float(np.quantile(np.abs(slope), 0.95)) if slope.size else 0.0
    moving = np.abs(slope) > 0.2 * usual
    if usual <= 0.0 or np.count_nonzero(moving) < 10:
        return None
    ratio = float(np.median(speed[moving] / slope[moving]))
    within = np.abs(speed[moving] - ratio * slope[moving]) < 0.25 * np.abs(ratio * slope[moving])
    if np.mean(within) < 0.5:
        return None
    says = f"{axis.name}'s speed is {ratio:.4g} times the slope of its {axis.position}"
    if ratio < 0.0:
        return f"{says}: one of the two has its sign turned"
    # By as much as half a step of the speed changes it.
    rounded = min(0.5 * rounding_step(series.velocity[np.isfinite(series.velocity)]) / usual, 1.0)
    if 0.8 - rounded < ratio < 1.25 + rounded:
        return None
    speeds = [name for name, si in axis.speeds.items() if abs(ratio * si - 1.0) < _CLOSE]
    positions = [name for name, si in axis.positions.items() if abs(ratio / si - 1.0) < _CLOSE]
    if speeds:
        return f"{says}: the speed looks like {' or '.join(speeds)}, {axis.units[1]} is wanted"
    if positions:
        return f"{says}: the {axis.position} looks like {' or '.join(positions)}, {axis.units[0]} is wanted"
    return f"{says}: one of the two is not in {axis.units[0]} and s"


def _steps(time: Array, slope: Array, speed: Array, rig: Rig) -> str | None:
    """An encoder that wraps or is reset: the angle leaps faster than the drive can turn, the speed does not."""
    leaps = (np.abs(slope) > 2.0 * rig.top_drive.max_speed) & (np.abs(speed) < 0.5 * np.abs(slope))
    if not leaps.any():
        return None
    first = int(np.flatnonzero(leaps)[0])
    return (
        f"the top drive's angle steps at {np.count_nonzero(leaps)} places, first at {time[first]:.1f} s, where its "
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
    if fastest <= _BEYOND * limit:
        return []
    units = [name for name, si in _DRIVE.speeds.items() if fastest * si <= limit]
    looks = f"; it looks like {' or '.join(units)}" if units else ""
    text = f"the top drive turns at {fastest:.4g} rad/s, the rig file's top_drive.max_speed is {limit:g} rad/s{looks}"
    return [LogIssue("unusable", "top_drive", text)]
