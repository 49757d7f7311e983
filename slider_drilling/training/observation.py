"""What an environment shows of a rig and what it rewards: shared by all environments, and by controllers that use them.

Only what a controller may measure is observed (`control.interface.Measurements`). The true state is used for the reward
alone.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from slider_drilling.control.interface import Measurements
from slider_drilling.drillstring.kernel_arrays import Array

Observation = NDArray[np.float32]

OBSERVED = (
    ("time", "s since the start of the episode"),
    ("top_drive_angle", "rad"),
    ("top_drive_speed", "rad/s"),
    ("surface_torque", "kN m"),
    ("block_position", "m lowered since the start"),
    ("block_speed", "m/s, positive lowers"),
    ("hook_load", "kN"),
    ("standpipe_pressure", "MPa"),
    ("pump_speed", "rad/s"),
    ("sine_of_error", "of the last MWD toolface minus the target; 0 before the first"),
    ("cosine_of_error", "likewise"),
    ("age", "s since that toolface was measured; 0 before the first"),
)
"""Name and unit of each number of an observation."""
SINE, COSINE, AGE = len(OBSERVED) - 3, len(OBSERVED) - 2, len(OBSERVED) - 1
SCALES = np.array([1.0, 1.0, 1.0, 1e3, 1.0, 1.0, 1e3, 1e6, 1.0])
"""SI units in the unit of each of the first nine numbers, which are those of `Measurements`."""

MAX_BLOCK_SPEED = 0.1  # m/s
REFERENCE_RATE = 9.0 / 3600.0  # m/s of new hole that earn 1 a second on target: 9 m/h

Number = TypeVar("Number", float, Array)


def reward(new_hole: Number, error: Number, seconds: float) -> Number:
    """Returns new hole over that of 9 m/h, times 1 on target, 0 at 90 degrees and -1 at 180 degrees.

    Args:
        new_hole: m drilled in the step.
        error: True toolface minus target at its end, rad.
        seconds: That the step lasts.
    """
    magnitude = np.abs((error + math.pi) % (2.0 * math.pi) - math.pi)
    return new_hole / (REFERENCE_RATE * seconds) * (1.0 - 2.0 / math.pi * magnitude)


class MeasurementObserver:
    """Observations from the measurements of one rig.

    A channel without a reading keeps its last value.
    """

    def __init__(self) -> None:
        self._observed = np.zeros(len(OBSERVED))
        self._tool_face, self._measured_at = 0.0, math.nan

    def observe(self, measurements: Measurements, target: float) -> Observation:
        """Take a sample and return what it shows; target: of the toolface, rad."""
        m = measurements
        values = np.array([m.time, m.top_drive_angle, m.top_drive_speed, m.surface_torque, m.block_position,
                           m.block_speed, m.hook_load, m.standpipe_pressure, m.pump_speed]) / SCALES  # fmt: skip
        read = np.isfinite(values)
        self._observed[: SCALES.size][read] = values[read]
        for sample in m.mwd:
            self._tool_face, self._measured_at = sample.tool_face, sample.measured_at
        if not math.isnan(self._measured_at):
            error = self._tool_face - target
            self._observed[SINE], self._observed[COSINE] = math.sin(error), math.cos(error)
            self._observed[AGE] = m.time - self._measured_at
        return self._observed.astype(np.float32)
