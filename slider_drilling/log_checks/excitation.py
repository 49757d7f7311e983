"""Check that the log can show friction: it is long enough, the drive turns, the motor runs while the block moves."""

from __future__ import annotations

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.rig import Rig
from slider_drilling.units import Quantity, sentence

_MIN_TURN = 0.5  # rad
_MIN_DURATION = 30.0  # s
_MIN_FLOW = 0.3  # of the reference flow
_LOWERED = 0.2  # m


def check_excitation(log: RigLog, rig: Rig) -> list[LogIssue]:
    """A log that is too short, a drive that hardly turns, a block that is lowered without flow."""
    texts = []
    drive = log.top_drive
    if drive is not None and drive.time.size > 1:
        duration = float(drive.time[-1] - drive.time[0])
        if duration < _MIN_DURATION:
            texts.append(f"the log is {duration:.3g} s long: too short for any effect to show")
        turned = _turned(drive.time, drive.position, drive.velocity)
        if turned < _MIN_TURN:
            texts.append(f"the top drive turned {turned:.2f} rad in total: too little to identify friction")
    return [LogIssue("uninformative", "top_drive", text, "motion") for text in texts] + _lowered_without_flow(log, rig)


def _turned(time: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> float:
    """rad between the drive's extreme angles."""
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
    if lowered < _LOWERED or flow >= _MIN_FLOW * rig.hydraulics.reference_flow:
        return []
    text = sentence(
        "the block moved ", Quantity(lowered, "m", 2), " while the pump gave ", Quantity(flow * 1e3, "L/s", 2),
        ": neither motor nor bit turns at that flow",
    )  # fmt: skip
    return [LogIssue("uninformative", "mud_pump", text, "motion")]
