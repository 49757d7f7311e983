"""A weak observer at the top drive: measured torque keeps a simulated run near the measured one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sample_gaps import in_gap


@dataclass(frozen=True)
class Observer:
    """Feedback of measured torque during a fit, never during a prediction (`boundary_conditions.apply_observer`).

    Attributes:
        time: s, (n,).
        torque: Measured surface torque then, N m, (n,).
        gain: Over the string's wave impedance: 0 is a free run, 1 (the most that a step can hold) absorbs every wave
            from below.
        memory: s, after which constant errors show again.
        smoothing: s, time constant with which the error of the torque is smoothed before it turns the drive; see
            `observer_noise.needed_smoothing`.
    """

    time: Array
    torque: Array
    gain: float = 0.3
    memory: float = 5.0
    smoothing: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.gain <= 1.0:
            raise ValueError(f"observer: gain = {self.gain:g}: must be 0 to 1")

    def measured_at(self, time: Array) -> Array:
        """Torque (m,) N m at other times; NaN outside the samples and inside their gaps."""
        known = np.interp(time, self.time, self.torque, left=np.nan, right=np.nan)
        return np.where(in_gap(self.time, time), np.nan, known)
