"""Check the signs of the channels: against the log's conventions, the energy balance, and a simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.drillstring.recorded_channels import Response
from slider_drilling.log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.log_checks.expected_levels import simulate_as_given
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.rig import Rig
from slider_drilling.units import Quantity, displayed, sentence

_OPPOSITE = -0.5  # correlation of measured and simulated torque
_RAISED = 0.2  # m
_BETTER = 0.5  # scatter of the residual with the opposite sign, over the scatter with the logged sign
_MIN_SAMPLES = 10


def check_signs(log: RigLog, rig: Rig, response: Response | None) -> list[LogIssue]:
    """Every channel with a wrong sign.

    Args:
        log: The log.
        rig: Its rig file.
        response: The simulation of the log as it is; without one only conventions are checked.
    """
    issues = _negative_levels(log)
    if response is not None and not issues:
        issues += _torque(log, response)
        issues += _block(log, rig, response)
    return issues


def _negative_levels(log: RigLog) -> list[LogIssue]:
    """Hook load, pressure and pump speed must be positive."""
    levels = []
    if log.draw_works is not None:
        levels.append(("hook_load", log.draw_works.effort, "N", "tension is positive"))
    if log.standpipe_pressure is not None:
        levels.append(("standpipe_pressure", log.standpipe_pressure.value, "Pa", "pressure is positive"))
    if log.mud_pump is not None:
        levels.append(("mud_pump", log.mud_pump.velocity, "rad/s", "its speed is positive"))
    issues = []
    for name, values, unit, rule in levels:
        known = values[np.isfinite(values)]
        if known.size and float(np.quantile(known, 0.9)) < 0.0:
            median = displayed(float(np.median(known)), unit, 4)
            text = sentence(f"{name} is negative (", median, f"): {rule}; import it with sign: -1")
            issues.append(LogIssue("unusable", name, text, "signs"))
    return issues


def _torque(log: RigLog, response: Response) -> list[LogIssue]:
    """A drive does work against friction: negative work, and torque opposite to the simulated one, is a wrong sign."""
    drive = log.top_drive
    if drive is None:
        return []
    inside = np.isfinite(drive.effort) & np.isfinite(drive.position) & (drive.time <= response.time[-1])
    if np.count_nonzero(inside) < _MIN_SAMPLES or np.ptp(drive.position[inside]) == 0.0:
        return []
    torque = drive.effort[inside]
    work = float(np.trapezoid(torque, drive.position[inside]))
    simulated = np.interp(drive.time[inside], response.time, response.surface_torque)
    if np.std(torque) == 0.0 or np.std(simulated) == 0.0:
        return []
    correlation = float(np.corrcoef(torque, simulated)[0, 1])
    if work >= 0.0 or correlation > _OPPOSITE:
        return []
    text = sentence(
        "surface_torque opposes the rotation: the drive would gain ", Quantity(-work / 1e3, "kJ"),
        " from friction; one of the two has the wrong sign; import it with sign: -1",
    )  # fmt: skip
    return [LogIssue("unusable", "surface_torque", text, "signs")]


def _block(log: RigLog, rig: Rig, response: Response) -> list[LogIssue]:
    """Positive lowers the block: one that rises, while hook load and pressure fit a lowered block, has a wrong sign."""
    works = log.draw_works
    if works is None:
        return []
    position = works.position[np.isfinite(works.position)]
    if position.size < 2 or position[-1] - position[0] > -_RAISED:
        return []
    turned = replace(log, draw_works=replace(works, position=-works.position, velocity=-works.velocity))
    opposite = simulate_as_given(turned, rig)
    if opposite is None:
        return []
    ratios = []
    if np.isfinite(works.effort).any():
        ratios.append(_scatter_ratio(works.time, works.effort, opposite, "hook_load", response))
    pressure = log.standpipe_pressure
    if pressure is not None and np.isfinite(pressure.value).any():
        ratios.append(_scatter_ratio(pressure.time, pressure.value, opposite, "standpipe_pressure", response))
    if not ratios or max(ratios) > _BETTER:
        return []
    text = sentence(
        "the block rises by ", Quantity(float(position[0] - position[-1]), "m", 2),
        " while hook load and pressure are those of a lowered block: positive lowers; import it with sign: -1",
    )  # fmt: skip
    return [LogIssue("unusable", "draw_works", text, "signs")]


def _scatter_ratio(time: Array, values: Array, opposite: Response, name: str, as_logged: Response) -> float:
    """Scatter of the residual with the opposite sign over that with the logged sign."""
    known = np.isfinite(values) & (time >= 0.0) & (time <= as_logged.time[-1])
    if np.count_nonzero(known) < _MIN_SAMPLES:
        return 1.0
    time, values = time[known], values[known]
    scatter = [float(np.std(values - np.interp(time, r.time, getattr(r, name)))) for r in (opposite, as_logged)]
    return scatter[0] / scatter[1] if scatter[1] > 0.0 else 1.0
