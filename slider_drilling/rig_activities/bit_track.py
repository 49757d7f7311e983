"""Where the bit is: slips from the hook load, bit depth from the block while the string hangs on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from slider_drilling.log.series import Array
from slider_drilling.rig_activities.surface_channels import Mask, SurfaceChannels

WEIGHT_WINDOW = 3601
"""Samples of the rolling median of the string's weight: two connections of a slow well lie within an hour."""
BLOCK_LIFT = 1.0
"""m that the block rises without load in at least one connection. A hanging string that rises shows pick-up weight."""
PICK_UP = 0.05
"""m that the block rises before the bit counts as picked up; less is the resolution of its sensor."""
MAX_RATE = 0.1
"""m/s, 360 m/h: no bit drills faster. Lowering that is faster is washing or tripping."""
DEPTH_TOLERANCE = 1.5
"""m by which a tracked depth may miss the bottom: slips slide and the string stretches at each connection."""
STAND_TIME = 90.0
"""s that the block may stand while the bit drills off its weight, before the rig counts as circulating."""
MIN_HOLE = 0.3
"""m of new hole below which lowering is no drilling: the block only stops gently above bottom."""
MIN_TIME = 60
"""s, likewise."""


@dataclass(frozen=True)
class BitTrack:
    """The bit over time. All arrays have shape (n,).

    Attributes:
        depth: Of the bit, m; relative to the start unless the log or the user gives it.
        hole: Depth of the hole, m, likewise.
        in_slips: Whether the string hangs in the slips.
        drilling: Whether the bit is on bottom and makes hole, short stands included.
        block_weight: Hook load of the block alone, N; NaN where the log holds no connection.
    """

    depth: Array
    hole: Array
    in_slips: Mask
    drilling: Mask
    block_weight: float


def track_bit(channels: SurfaceChannels, start_depth: float = 0.0, measured_depth: Array | None = None) -> BitTrack:
    """Follow the bit through a log.

    Args:
        channels: Of the log.
        start_depth: Depth of the bit at the start, m.
        measured_depth: Depth of the bit from the log, m, (n,), used instead of the block.
    """
    in_slips, block_weight = find_slips(channels)
    hanging = ~(in_slips[1:] | in_slips[:-1])
    moved = np.where(hanging, np.diff(channels.block), 0.0)
    depth = start_depth + np.concatenate([[0.0], np.cumsum(moved)])
    if measured_depth is not None:
        depth = measured_depth
    lowering = _lowering_on_bottom(channels, in_slips)
    hole, drilling = _hole_made(depth, lowering)
    return BitTrack(depth, hole, in_slips, drilling, block_weight)


def find_slips(channels: SurfaceChannels) -> tuple[Mask, float]:
    """Where the string hangs in the slips, and the hook load of the block alone, N.

    In slips the pumps are off and the hook carries the block, perhaps with a stand: less than halfway from the block
    to the string. Hook loads are accepted as those of the block only if the block rises under them.
    """
    load, idle = channels.hook_load, ~channels.pumping & channels.recorded
    none = np.zeros(len(load), dtype=bool)
    running = np.flatnonzero(channels.pumping & channels.recorded)
    if not np.isfinite(load).all() or not idle.any() or not running.size:
        return none, float("nan")
    weight = median_filter(load[running], min(WEIGHT_WINDOW, 2 * (len(running) // 2) + 1), mode="nearest")
    string = np.interp(channels.time, channels.time[running], weight)
    block = float(np.percentile(load[idle], 5.0))
    low = none
    for _ in range(5):  # converges in two or three
        low = idle & (load < 0.5 * (block + string))
        if not low.any():
            return none, float("nan")
        block = float(np.median(load[low]))
    low = without_short(low, 5)
    lifted = max((_largest_rise(channels.block[first:last]) for first, last in runs(low)), default=0.0)
    return (low, block) if lifted >= BLOCK_LIFT else (none, float("nan"))


def _largest_rise(block: Array) -> float:
    """How far the block rises from its lowest place so far, m."""
    return float(np.max(np.maximum.accumulate(block) - block))


def _lowering_on_bottom(channels: SurfaceChannels, in_slips: Mask) -> Mask:
    """Whether the pumps run and the block stands or is lowered slowly, at its lowest place since the pumps started."""
    half = 10  # s to either side; block sensors resolve 3 mm, a slow bit makes 10 mm in the time
    block = np.pad(channels.block, half, mode="edge")
    speed = (block[2 * half :] - block[: -2 * half]) / (2.0 * half)
    bottom = np.empty(len(channels.block))
    deepest = -np.inf
    # A string that is set down without pumps makes no hole: the bottom is counted from where they start.
    starts_again = in_slips | ~channels.pumping
    for index, (place, again) in enumerate(zip(channels.block, starts_again, strict=True)):
        deepest = place if again else max(deepest, place)
        bottom[index] = deepest
    at_bottom = channels.block >= bottom - PICK_UP
    return np.asarray(channels.pumping & channels.recorded & ~in_slips & at_bottom & (speed <= MAX_RATE))


def _hole_made(depth: Array, candidate: Mask) -> tuple[Array, Mask]:
    """Depth of the hole, and the samples at which it deepens or the bit drills off.

    Args:
        depth: Of the bit, m, (n,).
        candidate: Where the bit may be drilling, (n,).
    """
    episodes = [(first, last) for first, last in runs(candidate) if depth[first:last].max() - depth[first] >= MIN_HOLE]
    drilling = np.zeros(len(depth), dtype=bool)
    # Before the first new hole the bottom is where that begins.
    hole = depth[episodes[0][0]] if episodes else float(depth.max())
    bottoms = np.full(len(depth), hole)
    for first, last in episodes:
        reached = np.maximum.accumulate(depth[first:last])
        deep = reached >= hole - DEPTH_TOLERANCE
        at_bottom = int(np.argmax(deep))
        if not deep.any() or reached[-1] - reached[at_bottom] < MIN_HOLE or last - first - at_bottom < MIN_TIME:
            continue
        drilling[first:last] = deep & _without_long_stands(reached)
        hole = max(hole, float(reached[-1]))
        bottoms[last - 1] = hole
    return np.maximum.accumulate(np.maximum(bottoms, np.where(drilling, depth, -np.inf))), drilling


def _without_long_stands(reached: Array) -> Mask:
    """False before the bit first moves, and wherever it has stood for more than STAND_TIME."""
    moving = np.diff(reached, prepend=reached[0]) > 0.0
    index = np.arange(len(reached))
    last_move = np.maximum.accumulate(np.where(moving, index, -1))
    return (last_move >= 0) & (index - last_move <= STAND_TIME)


def runs(mask: Mask) -> list[tuple[int, int]]:
    """First and past-the-last index of each stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [(int(first), int(last)) for first, last in edges.reshape(-1, 2)]


def without_short(mask: Mask, least: int) -> Mask:
    """The mask without stretches of fewer samples."""
    kept = mask.copy()
    for first, last in runs(mask):
        kept[first:last] = last - first >= least
    return kept
