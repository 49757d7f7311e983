"""Whether the top drive's angle and speed agree with each other and with what the drive can do."""

from __future__ import annotations

import numpy as np

from slider_drilling.diagnosis.first_look.finding import Finding
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.units import KINDS

_CLOSE = 0.1  # how near a ratio must be to that of two units
_BEYOND = 1.5  # times the drive's limit of speed
_SPEEDS = {name: KINDS["angular speed"][name] for name in ("deg/s", "rpm", "rev/s")}
_ANGLES = {name: KINDS["angle"][name] for name in ("deg", "rev")}


def look_at_motion(log: RigLog, rig: Rig) -> list[Finding]:
    """Units and signs of angle against speed, speeds beyond the drive's limit, angles that step."""
    drive = log.top_drive
    if drive is None:
        return []
    known = np.isfinite(drive.position)
    slope = np.diff(drive.position[known]) / np.diff(drive.time[known]) if np.count_nonzero(known) > 2 else np.empty(0)
    speed = drive.velocity[known]
    speed = 0.5 * (speed[1:] + speed[:-1])
    both = np.isfinite(speed) & np.isfinite(slope) if slope.size else np.zeros(0, dtype=bool)
    if np.count_nonzero(both) > 10:
        disagreement = _disagreement(slope[both], speed[both])
        if disagreement is not None:
            return [Finding("refuse", "top_drive", disagreement)]
        stepped = _steps(drive.time[known][1:][both], slope[both], speed[both], rig)
        if stepped is not None:
            return [Finding("refuse", "top_drive", stepped)]
    return _too_fast(slope, drive.velocity[np.isfinite(drive.velocity)], rig)


def _disagreement(slope: np.ndarray, speed: np.ndarray) -> str | None:
    """Why a speed is not the slope of its angle. Their ratio is a median over what moves: steps do not count."""
    moving = np.abs(slope) > 0.2 * np.quantile(np.abs(slope), 0.95)
    if np.quantile(np.abs(slope), 0.95) <= 0.0 or np.count_nonzero(moving) < 10:
        return None
    ratio = float(np.median(speed[moving] / slope[moving]))
    within = np.abs(speed[moving] - ratio * slope[moving]) < 0.25 * np.abs(ratio * slope[moving])
    if np.mean(within) < 0.5:
        return None
    if ratio < 0.0:
        return f"the top drive's speed is {ratio:.2f} times the slope of its angle: one of the two has its sign turned"
    if 0.8 < ratio < 1.25:
        return None
    speeds = [name for name, si in _SPEEDS.items() if abs(ratio * si - 1.0) < _CLOSE]
    angles = [name for name, si in _ANGLES.items() if abs(ratio / si - 1.0) < _CLOSE]
    says = f"the top drive's speed is {ratio:.4g} times the slope of its angle"
    if speeds:
        return f"{says}: the speed looks like {' or '.join(speeds)}, rad/s is wanted"
    if angles:
        return f"{says}: the angle looks like {' or '.join(angles)}, rad is wanted"
    return f"{says}: one of the two is not in rad and s"


def _steps(time: np.ndarray, slope: np.ndarray, speed: np.ndarray, rig: Rig) -> str | None:
    """An encoder that wraps or is reset: the angle leaps faster than the drive can turn, the speed does not."""
    leaps = (np.abs(slope) > 2.0 * rig.top_drive.max_speed) & (np.abs(speed) < 0.5 * np.abs(slope))
    if not leaps.any():
        return None
    first = int(np.flatnonzero(leaps)[0])
    return (
        f"the top drive's angle steps at {np.count_nonzero(leaps)} places, first at {time[first]:.1f} s, where its "
        f"speed is {speed[first]:.2f} rad/s: an encoder that wraps or was reset; make the angle continuous"
    )


def _too_fast(slope: np.ndarray, speed: np.ndarray, rig: Rig) -> list[Finding]:
    known = speed if speed.size else slope
    if known.size < 3:
        return []
    fastest, limit = float(np.quantile(np.abs(known), 0.99)), rig.top_drive.max_speed
    if fastest <= _BEYOND * limit:
        return []
    units = [name for name, si in _SPEEDS.items() if fastest * si <= limit]
    looks = f"; it looks like {' or '.join(units)}" if units else ""
    text = f"the top drive turns at {fastest:.4g} rad/s, the rig file's top_drive.max_speed is {limit:g} rad/s{looks}"
    return [Finding("refuse", "top_drive", text)]
