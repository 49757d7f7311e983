"""Says where a rig's values are none that such a rig has: another unit, or another rig's file."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log_checks import expected_levels
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_checks.units_and_levels import check_level, check_pump_unit, check_tool_face_unit
from slider_drilling.rig import Rig
from slider_drilling.twin.channels import CHANNELS, READING_RANGES
from slider_drilling.twin.samples import Array

LEVELS_AFTER_S = 60
"""s of a rig's work after which its levels are checked."""
_MOST_LEFT_OUT = 0.5  # of a channel's values
_LEAST_TURN = 3.0  # rad of the drive, below which friction need not show in the torque


class LeftOut:
    """Counts values that no sensor of a rig gives."""

    def __init__(self) -> None:
        self._given, self._left_out = dict.fromkeys(CHANNELS, 0), dict.fromkeys(CHANNELS, 0)

    def without(self, channel: str, values: Array) -> Array:
        """The values (n,) with NaN for those that lie outside what a rig can have."""
        low, high = READING_RANGES[channel]
        inside = (values >= low) & (values <= high)
        given = np.isfinite(values)
        self._given[channel] += int(np.count_nonzero(given))
        self._left_out[channel] += int(np.count_nonzero(given & ~inside))
        return np.where(inside, values, np.nan)

    def remarks(self) -> tuple[str, ...]:
        """A sentence for each channel of which most values were left out."""
        return tuple(
            _outside(name) for name, count in self._left_out.items() if count > _MOST_LEFT_OUT * self._given[name]
        )


def _outside(channel: str) -> str:
    low, high = READING_RANGES[channel]
    return f"{channel} mostly lies outside {low:g} to {high:g} (SI), which no rig has; it is left out: check its unit"


def level_remarks(log: RigLog, rig: Rig, expected: Mapping[str, Array]) -> tuple[str, ...]:
    """A sentence for each channel whose level no calibration reaches.

    Args:
        log: The first minute.
        rig: The rig file.
        expected: `time`, s of the log, and `surface_torque` of the plants then, (n,).
    """
    rig = expected_levels.rig_off_bottom(log, rig)
    found: list[LogIssue] = check_level("hook_load", expected_levels.hook_load(log, rig))
    pressure = expected_levels.standpipe_pressure(log, rig)
    found += check_pump_unit(log, rig) or check_level("standpipe_pressure", pressure)
    if log.top_drive is not None and _turned(log.top_drive.position) > _LEAST_TURN:
        torque = expected_levels.surface_torque(log, expected["time"], expected["surface_torque"])
        found += check_level("surface_torque", torque)
    found += check_tool_face_unit(log)
    return tuple(str(issue.text) for issue in found)


def _turned(angle: Array) -> float:
    """Range of an angle, rad; 0 where none is known."""
    known = angle[np.isfinite(angle)]
    return float(np.ptp(known)) if known.size else 0.0
