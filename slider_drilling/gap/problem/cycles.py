"""Cycles of the excitation, and the length of the blocks that are resampled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.model import Array, LoggedRun

# A turning point counts if the excitation comes back by more than this share of its range. Noise and ripple do not.
_TURN_SHARE = 0.05


def cycle_period(time: Array, excitation: Array) -> float | None:
    """Median period of the excitation, s; None with fewer than three turning points.

    Args:
        time: (m,) s.
        excitation: (m,).
    """
    turns = turning_points(excitation)
    if turns.size < 3:
        return None
    return 2.0 * float(np.median(np.diff(time[turns])))


def turning_points(excitation: Array) -> NDArray[np.int_]:
    """Indices of the turning points of the excitation (m,)."""
    threshold = _TURN_SHARE * float(np.ptp(excitation))
    if threshold == 0.0:
        return np.empty(0, dtype=int)
    turns: list[int] = []
    direction, extreme = 0, 0
    for index, value in enumerate(excitation):
        change = value - excitation[extreme]
        if direction == 0 and abs(change) > threshold:
            direction, extreme = int(np.sign(change)), index
        elif direction * change > 0.0:
            extreme = index
        elif direction * change < -threshold:
            turns.append(extreme)
            direction, extreme = -direction, index
    return np.array(turns, dtype=int)


def block_length(run: LoggedRun) -> float:
    """Length of a resampled block, s: two cycles of the excitation, between a twentieth and a sixth of the run."""
    period = cycle_period(run.time, run.excitation)
    wanted = run.duration / 20.0 if period is None else max(2.0 * period, run.duration / 20.0)
    return float(min(wanted, run.duration / 6.0))
