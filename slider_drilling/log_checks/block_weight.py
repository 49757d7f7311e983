"""Check whether the hook load holds the weight of the block: more than the string weighs while it rotates freely."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array, JointSeries
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_inputs.steady_rotation import rotates_steadily
from slider_drilling.rig import Rig
from slider_drilling.units import Quantity, sentence
from slider_drilling.wellbore.static_loads import static_loads

_STILL = 0.01  # m/s of the block
_MIN_EXCESS, _MIN_SHARE = 80e3, 0.12  # N, and of the string's weight: less may be the rig file's


def check_block_weight(log: RigLog, rig: Rig) -> tuple[list[LogIssue], bool]:
    """A note where the hook load of a string that rotates with the block at rest is above its weight.

    Returns:
        The note, if any; and whether there was such a time, without which nothing can be said.
    """
    drive, works = log.top_drive, log.draw_works
    if drive is None or works is None or not np.isfinite(works.effort).any():
        return [], False
    steady = rotates_steadily(drive.time, drive.velocity)
    if not steady.any():
        return [], False
    rotates = np.interp(works.time, drive.time, steady.astype(float)) > 0.99
    chosen = works.effort[rotates & _still(works) & np.isfinite(works.effort)]
    if chosen.size < 5:
        return [], False
    measured, weight = float(np.median(chosen)), static_loads(rig, elements=100).hook_load
    excess = measured - weight
    if excess < max(_MIN_EXCESS, _MIN_SHARE * weight):
        return [], True
    text = sentence(
        "the hook load while rotating is ", Quantity(measured / 1e3, "kN"), ", the string weighs ",
        Quantity(weight / 1e3, "kN"), ": the ", Quantity(excess / 1e3, "kN"), " above it look like the block; import "
        "the table with that as tare of hook_load, or correct the rig file",
    )  # fmt: skip
    return [LogIssue("note", "hook_load", text, "block weight")], True


def _still(works: JointSeries) -> NDArray[np.bool_]:
    speed: Array = works.velocity
    if not np.isfinite(speed).any():
        if not np.isfinite(works.position).any() or works.time.size < 3:
            return np.ones(works.time.shape, dtype=np.bool_)
        speed = np.gradient(works.position, works.time)
    return np.abs(np.where(np.isfinite(speed), speed, 0.0)) < _STILL
