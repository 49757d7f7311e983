"""Whether each channel is as large as the rig file lets it be, and which unit it is in if it is not."""

from __future__ import annotations

import math

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log_checks.expected_levels import ExpectedLevel, standpipe_pressure
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.rig import Rig
from slider_drilling.units import KINDS

# SI unit, and the unit that a driller reads it in with its factor.
_READ = {"surface_torque": ("torque", "kN m"), "hook_load": ("force", "kN"), "standpipe_pressure": ("pressure", "bar")}
_NEAR, _NEARER = 3.0, 4.0  # a unit explains a level that it brings this near to the rig file's, and this much nearer
_OTHER_RIG = 0.1  # a level that far off may be another rig's; beyond, only a unit explains it
_ROUND = 2.0 * math.pi + 0.05  # rad


def check_level(channel: str, expected: ExpectedLevel | None) -> list[LogIssue]:
    """A level that no tuning reaches: the wrong unit, or another rig's file."""
    if expected is None or expected.fits:
        return []
    kind, shown = _READ[channel]
    names = KINDS[kind]
    si, read = next(iter(names)), names[shown]
    ratio = abs(expected.measured) / expected.expected
    near = _units(ratio, {name: factor for name, factor in names.items() if name != si})
    level = f"{channel} {expected.what} {expected.measured / read:.3g} {shown}, by the rig file "
    level += f"{expected.expected / read:.3g} {shown}: "
    other = "they cannot belong together; give this rig's own file with --rig"
    if near and _OTHER_RIG < ratio < 1.0 / _OTHER_RIG:
        level += f"either it is in {' or '.join(near[:2])} and wants importing with that unit, or {other}"
    elif near:
        level += f"it looks like {' or '.join(near[:2])}; import it with that unit"
    else:
        level += other
    return [LogIssue("unusable", channel, level)]


def check_pump_unit(log: RigLog, rig: Rig) -> list[LogIssue]:
    """A pressure that does not belong to the flow, because the pump's speed is in another unit."""
    as_logged = standpipe_pressure(log, rig)
    if as_logged is None or as_logged.fits or log.mud_pump is None:
        return []
    unit = KINDS["angular speed"]["rpm"]
    turned = standpipe_pressure(log, rig, unit)
    if turned is None or not 1.0 / _NEAR < turned.measured / turned.expected < _NEAR:
        return []
    speed = float(np.nanmedian(log.mud_pump.velocity))
    text = (
        f"mud_pump turns at {speed:.4g} rad/s, whose flow would need {as_logged.expected / 1e5:.0f} bar where "
        f"{as_logged.measured / 1e5:.0f} bar were measured: it looks like strokes a minute; import it with that unit"
    )
    return [LogIssue("unusable", "mud_pump", text)]


def _units(ratio: float, factors: dict[str, float]) -> list[str]:
    """Units that would bring a level over the rig file's near to one, the nearest first."""
    if ratio <= 0.0:
        return []
    apart = {name: abs(math.log(ratio * factor)) for name, factor in factors.items()}
    most = min(math.log(_NEAR), abs(math.log(ratio)) / _NEARER)
    return sorted((name for name in apart if apart[name] < most), key=lambda name: apart[name])


def check_tool_face_unit(log: RigLog) -> list[LogIssue]:
    """Toolfaces in degrees: a direction in rad has no number beyond a full turn."""
    if log.mwd_tool_face is None:
        return []
    values = log.mwd_tool_face.position[np.isfinite(log.mwd_tool_face.position)]
    beyond = int(np.count_nonzero(np.abs(values) > _ROUND))
    if beyond == 0:
        return []
    largest = float(np.max(np.abs(values)))
    looks = "it looks like deg; import it with that unit" if largest <= 360.5 else "wrap it into (-pi, pi]"
    return [LogIssue("unusable", "tool_face", f"tool_face reads up to {largest:.4g} rad, more than a turn: {looks}")]
