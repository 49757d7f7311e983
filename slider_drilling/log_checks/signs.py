"""Channels whose sign is turned: against the conventions of a log, against energy, against the replay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.drillstring.recorded_channels import Response
from slider_drilling.log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.log_checks.expected_levels import simulate_as_given
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.rig import Rig

_OPPOSITE = -0.5  # correlation of the torque with the replay's
_RAISED = 0.2  # m
_BETTER = 0.5  # RMS of what is left with a turned sign over that as logged


def check_signs(log: RigLog, rig: Rig, response: Response | None) -> list[LogIssue]:
    """Everything about signs; response: the replay of the log as it is."""
    found = _positive(log)
    if response is not None and not found:
        found += _torque(log, response)
        found += _block(log, rig, response)
    return found


def _positive(log: RigLog) -> list[LogIssue]:
    """Loads, pressures and pump speeds of a rig are positive."""
    levels = []
    if log.draw_works is not None:
        levels.append(("hook_load", log.draw_works.effort, "tension is positive"))
    if log.standpipe_pressure is not None:
        levels.append(("standpipe_pressure", log.standpipe_pressure.value, "pressure is positive"))
    if log.mud_pump is not None:
        levels.append(("mud_pump", log.mud_pump.velocity, "its speed is positive"))
    found = []
    for name, values, rule in levels:
        known = values[np.isfinite(values)]
        if known.size and float(np.quantile(known, 0.9)) < 0.0:
            text = f"{name} is negative ({float(np.median(known)):.4g}): {rule}; import it with sign: -1"
            found.append(LogIssue("unusable", name, text))
    return found


def _torque(log: RigLog, response: Response) -> list[LogIssue]:
    """A drive that turns a string with friction does work on it; torque of the other sign would take work out of it."""
    drive = log.top_drive
    if drive is None:
        return []
    inside = np.isfinite(drive.effort) & np.isfinite(drive.position) & (drive.time <= response.time[-1])
    if np.count_nonzero(inside) < 10 or np.ptp(drive.position[inside]) == 0.0:
        return []
    torque = drive.effort[inside]
    work = float(np.trapezoid(torque, drive.position[inside]))
    simulated = np.interp(drive.time[inside], response.time, response.surface_torque)
    if np.std(torque) == 0.0 or np.std(simulated) == 0.0:
        return []
    alike = float(np.corrcoef(torque, simulated)[0, 1])
    if work >= 0.0 or alike > _OPPOSITE:
        return []
    text = (
        f"surface_torque runs against the rotation (the drive would gain {-work / 1e3:.3g} kJ from a string that "
        "rubs): one of the two has its sign turned; import it with sign: -1"
    )
    return [LogIssue("unusable", "surface_torque", text)]


def _block(log: RigLog, rig: Rig, response: Response) -> list[LogIssue]:
    """Positive lowers: a block that rises while everything else is as if it went down."""
    works = log.draw_works
    if works is None:
        return []
    position = works.position[np.isfinite(works.position)]
    if position.size < 2 or position[-1] - position[0] > -_RAISED:
        return []
    turned = simulate_as_given(
        replace(log, draw_works=replace(works, position=-works.position, velocity=-works.velocity)), rig
    )
    if turned is None:
        return []
    ratios = []
    if np.isfinite(works.effort).any():
        ratios.append(_left(works.time, works.effort, turned[1], "hook_load", response))
    pipe = log.standpipe_pressure
    if pipe is not None and np.isfinite(pipe.value).any():
        ratios.append(_left(pipe.time, pipe.value, turned[1], "standpipe_pressure", response))
    if not ratios or max(ratios) > _BETTER:
        return []
    text = (
        f"the block rises by {position[0] - position[-1]:.2f} m while hook load and pressure are those of a block that "
        "goes down: positive lowers; import it with sign: -1"
    )
    return [LogIssue("unusable", "draw_works", text)]


def _left(time: Array, values: Array, turned: Response, name: str, as_logged: Response) -> float:
    """Scatter of the residual with the turned sign over that without."""
    known = np.isfinite(values) & (time >= 0.0) & (time <= as_logged.time[-1])
    if np.count_nonzero(known) < 10:
        return 1.0
    time, values = time[known], values[known]
    left = [float(np.std(values - np.interp(time, r.time, getattr(r, name)))) for r in (turned, as_logged)]
    return left[0] / left[1] if left[1] > 0.0 else 1.0
