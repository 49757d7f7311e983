"""The excitation's cycles, and the stretches of a run that are held out and resampled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.model import Array, LoggedRun

# A turn counts where the excitation comes back by more than this share of its range: noise and ripple do not.
_TURN_SHARE = 0.05


def cycle_period(time: Array, excitation: Array) -> float | None:
    """Median time s from one low turning point to the next, None when there are fewer than three turns."""
    turns = turning_points(excitation)
    if turns.size < 3:
        return None
    return 2.0 * float(np.median(np.diff(time[turns])))


def turning_points(excitation: Array) -> NDArray[np.int_]:
    """Indices where the excitation turns for good."""
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
    """Length s of what is resampled: two cycles of the excitation, within a sixth and a twentieth of the run."""
    period = cycle_period(run.time, run.excitation)
    wanted = run.duration / 20.0 if period is None else max(2.0 * period, run.duration / 20.0)
    return float(min(wanted, run.duration / 6.0))
