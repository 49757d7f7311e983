"""A weak observer at the top drive: the torque that was measured, as a run is pulled by it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.drillstring.sample_gaps import in_gap


@dataclass(frozen=True)
class Observer:
    """What a fit simulates with (`kernel.pull`), never a prediction.

    time: (n,) s; torque: (n,) N m measured then; gain: of the string's wave impedance, 0 a free run, 1 (the most that a
    step can hold) takes all that arrives from below; memory: s, after which constant errors show again.
    """

    time: Array
    torque: Array
    gain: float = 0.3
    memory: float = 5.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.gain <= 1.0:
            raise ValueError(f"observer: gain {self.gain:g} must be 0 to 1")

    def measured_at(self, time: Array) -> Array:
        """(m,) N m at other times, NaN where nothing was measured: outside the samples, and where some were lost."""
        known = np.interp(time, self.time, self.torque, left=np.nan, right=np.nan)
        return np.where(in_gap(self.time, time), np.nan, known)
