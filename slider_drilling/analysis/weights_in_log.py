"""Pick-up, slack-off and rotating weights and free torque that a log holds, from stretches in which the rig did that.

Only stretches off bottom count: the bit hangs clearly above the deepest point it has reached in the log, or the string
rotates with the block at rest and a steady hook load, after which no weight is left on the bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.analysis.driller_weights import MOTIONS, DrillerWeights
from slider_drilling.log import RigLog
from slider_drilling.log.series import Array, JointSeries
from slider_drilling.rig import Rig

_WINDOW = 20.0  # s of a stretch
_MIN_SAMPLES = 5
_MIN_SPEED, _AT_REST = 5e-3, 2e-4  # m/s of the block, in a stretch that moves and in one that rests
_STEADY_SPEED = 0.5  # of the mean speed: largest departure within a stretch
_CLEAR = 1.5  # m above the deepest point; stretch and weight on bit are taken up within it
_ROTATING, _NOT_ROTATING = 0.5, 0.05  # rad/s
_ONE_WAY = 0.9  # of the mean speed's magnitude: more is rotation, less is rocking
_STEADY_LOAD = 0.01  # of the hook load: largest change over a stretch of rotation at rest
_IN_SLIPS = 0.5  # of the median hook load; less is no hanging string
_SAME_DEPTH = 15.0  # m: readings within it are one
_BELOW_STRING = 30.0  # m that a log may go deeper than the rig file's string


@dataclass(frozen=True)
class _Stretch:
    depth: float
    motion: str
    hook_load: float
    torque: float  # NaN unless rotating


def find_weights(log: RigLog, rig: Rig) -> tuple[DrillerWeights, ...]:
    """The readings in a log, by depth; hook loads as logged, block and all. Empty where it holds none.

    Args:
        log: The log.
        rig: Gives the bit's depth at the start of a log without that channel.
    """
    block = log.draw_works
    if block is None or not np.isfinite(block.position).any() or not np.isfinite(block.effort).any():
        return ()
    keep = np.isfinite(block.position) & np.isfinite(block.effort)
    block = replace(block, **{name: getattr(block, name)[keep]
                              for name in ("time", "arrival", "position", "velocity", "effort")})  # fmt: skip
    depth = _bit_depth(log, rig, block)
    deepest = np.maximum.accumulate(depth)
    hanging = _IN_SLIPS * float(np.median(block.effort))
    found = []
    for start in np.arange(block.time[0], block.time[-1] - 0.5 * _WINDOW, _WINDOW):
        inside = (block.time >= start) & (block.time < start + _WINDOW)
        if np.count_nonzero(inside) >= _MIN_SAMPLES and block.effort[inside].min() > hanging:
            clear = float(np.min(deepest[inside] - depth[inside])) > _CLEAR
            stretch = _stretch(block, log.top_drive, inside, depth, clear)
            if stretch is not None and stretch.depth <= rig.string.length + _BELOW_STRING:
                found.append(replace(stretch, depth=min(stretch.depth, rig.string.length)))
    return _by_depth(found)


def _bit_depth(log: RigLog, rig: Rig, block: JointSeries) -> Array:
    if log.bit_depth is not None and np.isfinite(log.bit_depth.position).any():
        known = np.isfinite(log.bit_depth.position)
        return np.interp(block.time, log.bit_depth.time[known], log.bit_depth.position[known])
    return np.asarray(rig.string.length + block.position - block.position[0], dtype=np.float64)


def _stretch(
    block: JointSeries, drive: JointSeries | None, inside: np.ndarray, depth: Array, clear: bool
) -> _Stretch | None:
    """What one stretch shows, or None."""
    time, position, load = block.time[inside], block.position[inside], block.effort[inside]
    span = float(time[-1] - time[0])
    if span < 0.5 * _WINDOW:
        return None
    speed = float(position[-1] - position[0]) / span
    mean, magnitude, torque = _rotation(drive, float(time[0]), float(time[-1]))
    if math.isnan(magnitude):
        return None
    hook_load, here = float(np.median(load)), float(np.mean(depth[inside]))
    if magnitude > _ROTATING and abs(mean) > _ONE_WAY * magnitude and abs(speed) < _AT_REST:
        trend = abs(float(np.polyfit(time - time[0], load, 1)[0])) * span
        steady = trend < _STEADY_LOAD * hook_load
        return _Stretch(here, "rotating", hook_load, abs(torque)) if clear or steady else None
    if not clear or magnitude > _NOT_ROTATING or abs(speed) < _MIN_SPEED:
        return None
    straight = position[0] + speed * (time - time[0])
    if float(np.max(np.abs(position - straight))) > 0.5 * _STEADY_SPEED * abs(speed) * span:
        return None
    return _Stretch(here, "slack_off" if speed > 0.0 else "pick_up", hook_load, math.nan)


def _rotation(drive: JointSeries | None, start: float, end: float) -> tuple[float, float, float]:
    """Mean speed, mean of its magnitude (rad/s) and mean torque (N m) of the top drive; NaN where unknown."""
    if drive is None:
        return math.nan, math.nan, math.nan
    inside = (drive.time >= start) & (drive.time <= end)
    speed = drive.velocity[inside]
    if not np.isfinite(speed).any() and np.isfinite(drive.position[inside]).sum() > 1:
        speed = np.gradient(drive.position[inside], drive.time[inside])
    speed, torque = speed[np.isfinite(speed)], drive.effort[inside]
    torque = torque[np.isfinite(torque)]
    if not speed.size:
        return math.nan, math.nan, math.nan
    return float(speed.mean()), float(np.abs(speed).mean()), float(torque.mean()) if torque.size else math.nan


def _by_depth(stretches: Sequence[_Stretch]) -> tuple[DrillerWeights, ...]:
    """One row for each group of neighbouring depths: the median of each motion."""
    rows: list[list[_Stretch]] = []
    for stretch in sorted(stretches, key=lambda one: one.depth):
        if rows and stretch.depth - rows[-1][0].depth <= _SAME_DEPTH:
            rows[-1].append(stretch)
        else:
            rows.append([stretch])
    return tuple(_row(group) for group in rows)


def _row(group: Sequence[_Stretch]) -> DrillerWeights:
    loads = {motion: [one.hook_load for one in group if one.motion == motion] for motion in MOTIONS}
    medians = {motion: float(np.median(values)) for motion, values in loads.items() if values}
    torques = [one.torque for one in group if math.isfinite(one.torque)]
    return DrillerWeights(float(np.mean([one.depth for one in group])), **medians,
                          torque=float(np.median(torques)) if torques else None)  # fmt: skip
