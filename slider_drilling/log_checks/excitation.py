"""Whether a log does anything from which friction could be told."""

from __future__ import annotations

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.rig import Rig

_LEAST_TURN = 0.5  # rad
_LEAST_S = 30.0
_ON = 0.3  # of the reference flow
_LOWERED = 0.2  # m


def check_excitation(log: RigLog, rig: Rig) -> list[LogIssue]:
    """A drive that hardly turns, a log that is too short, a block that goes down while the motor stands still."""
    found = []
    drive = log.top_drive
    if drive is not None and drive.time.size > 1:
        seconds = float(drive.time[-1] - drive.time[0])
        if seconds < _LEAST_S:
            found.append(f"the log is {seconds:.3g} s long: shorter than any effect takes to show")
        turned = _turned(drive.time, drive.position, drive.velocity)
        if turned < _LEAST_TURN:
            found.append(
                f"the top drive turned {turned:.2f} rad in all: too little to tell friction from anything else"
            )
    return [LogIssue("uninformative", "top_drive", text) for text in found] + _lowered_without_flow(log, rig)


def _turned(time: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> float:
    known = np.isfinite(position)
    if known.any():
        return float(np.ptp(position[known]))
    known = np.isfinite(velocity)
    if not known.any():
        return 0.0
    steps = 0.5 * (velocity[known][1:] + velocity[known][:-1]) * np.diff(time[known])
    return float(np.ptp(np.r_[0.0, np.cumsum(steps)]))


def _lowered_without_flow(log: RigLog, rig: Rig) -> list[LogIssue]:
    works, pump = log.draw_works, log.mud_pump
    if works is None or pump is None:
        return []
    position, speed = works.position[np.isfinite(works.position)], pump.velocity[np.isfinite(pump.velocity)]
    if position.size < 10 or speed.size < 10:
        return []
    lowered, flow = float(np.ptp(position)), float(np.median(speed)) * rig.mud_pump.displacement
    if lowered < _LOWERED or flow >= _ON * rig.hydraulics.reference_flow:
        return []
    text = (
        f"the block moved {lowered:.1f} m with the pump at {flow * 1e3:.1f} L/s: the motor would not turn, nor the bit"
    )
    return [LogIssue("uninformative", "mud_pump", text)]
