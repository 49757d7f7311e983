"""What drives the plant: measured motion of top drive, block and pump, on an even grid, as far as it has arrived."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.log_inputs.fill_drive_gaps import fill_drive_gaps
from slider_drilling.rig import FLOW_EXPONENT, Rig
from slider_drilling.twin.channels import COMPARED, DRIVING
from slider_drilling.twin.samples import Array, SampleBuffer

_BEFORE_S = 10.0  # of samples before the first grid point, so that a motion is joined smoothly
_MISSING_S = 5.0  # between samples of the top drive, beyond which its motion is not known
_MIN_PUMP = 0.3  # of the reference flow, that a pump which nobody logs is taken to give at least while it runs


class DriveMotion:
    """Reads the driving channels from their buffers.

    Args:
        rig: The rig, for what is not logged.
        buffers: Samples by channel.
        patience: s to wait for late samples of a channel while others go on.
    """

    def __init__(self, rig: Rig, buffers: Mapping[str, SampleBuffer], patience: float) -> None:
        self._rig, self._buffers, self._patience = rig, buffers, patience

    @property
    def started(self) -> float:
        """Time of the first sample of the top drive, s; infinity without any."""
        firsts = [buffer.time[0] for buffer in self._drive() if len(buffer)]
        return float(min(firsts, default=math.inf))

    @property
    def newest(self) -> float:
        """Time of the newest sample of any channel at surface, s."""
        return max(b.last for name, b in self._buffers.items() if name != "tool_face")

    def known_until(self) -> float:
        """Time up to which all motion has arrived, or is not waited for any more, s."""
        late = self.newest - self._patience
        drive = max(buffer.last for buffer in self._drive())
        others = [self._buffers[name].last for name in ("block_position", "block_speed", "pump_speed")]
        return max(late, min([drive, *(last for last in others if math.isfinite(last))]))

    def commands(self, grid: Array) -> Commands:
        """Motion at the times of an even grid (n,), s; beyond the last sample the drives stand still."""
        angle, speed = self._joint("top_drive_angle", "top_drive_speed", grid, self._rig.top_drive.max_acceleration)
        block, block_speed = self._joint("block_position", "block_speed", grid, None)
        return Commands(grid, angle, speed, block, block_speed, self._pump(grid))

    def missing(self, grid: Array) -> bool:
        """Whether samples of the top drive are missing for long at these times (n,), s."""
        time = max(self._drive(), key=len).time
        around = time[max(int(np.searchsorted(time, grid[0])) - 1, 0) : int(np.searchsorted(time, grid[-1])) + 1]
        return bool(np.max(np.diff(around), initial=0.0) > _MISSING_S or around.size == 0 or time[-1] < grid[0])

    def _drive(self) -> list[SampleBuffer]:
        return [self._buffers["top_drive_angle"], self._buffers["top_drive_speed"]]

    def _joint(self, position: str, speed: str, grid: Array, max_acceleration: float | None) -> tuple[Array, Array]:
        """Position and speed on the grid, a cubic through both; zero where nothing is logged."""
        begin, end = grid[0] - _BEFORE_S, grid[-1] + 2.0 * self._patience + 1.0
        time, value = _with_neighbours(self._buffers[position], begin, end)
        if not time.size:
            return np.zeros_like(grid), np.zeros_like(grid)
        slope_time, slopes = _with_neighbours(self._buffers[speed], begin, end)
        if slope_time.size:
            slope = np.interp(time, slope_time, slopes)
        else:
            slope = np.gradient(value, time) if time.size > 1 else np.zeros_like(time)
        if max_acceleration is not None and slope_time.size and time.size > 2:
            time, value, slope = fill_drive_gaps(time, value, slope, max_acceleration)
        still = np.zeros_like(time)
        motion = Commands(time, value, slope, still, still, still).resampled(grid)
        return motion.top_drive_angle, motion.top_drive_speed

    def _pump(self, grid: Array) -> Array:
        """Crank speed on the grid, rad/s; the reference flow where it is not logged."""
        time, speed = _with_neighbours(self._buffers["pump_speed"], grid[0] - _BEFORE_S, grid[-1] + 1.0)
        if time.size:
            return np.interp(grid, time, speed)
        reference = self._rig.reference_pump_speed
        time, pressure = _with_neighbours(self._buffers["standpipe_pressure"], grid[0] - _BEFORE_S, grid[-1] + 1.0)
        if not time.size:
            return np.full_like(grid, reference)
        share = np.interp(grid, time, pressure) / self._rig.circulating_pressure
        flow = np.clip(share, 0.0, 1.0) ** (1.0 / FLOW_EXPONENT)
        return reference * np.where(share > _MIN_PUMP, np.where(flow > 0.8, 1.0, flow), 0.0)


class SpeedIntegrals:
    """Positions of drives that send speeds alone.

    Args:
        buffers: Samples by channel.
    """

    def __init__(self, buffers: Mapping[str, SampleBuffer]) -> None:
        self._buffers = buffers
        self._integrated: set[str] = set()

    def update(self) -> None:
        """Add the positions of what has come in."""
        for position, speed in (("top_drive_angle", "top_drive_speed"), ("block_position", "block_speed")):
            if position in self._integrated or len(self._buffers[speed]) > len(self._buffers[position]) == 0:
                _add_speed_integral(self._buffers, position, speed)
                self._integrated.add(position)


def _add_speed_integral(buffers: Mapping[str, SampleBuffer], position: str, speed: str) -> None:
    """Give a channel that only has speeds its positions: the integral since its first sample."""
    speeds, positions = buffers[speed], buffers[position]
    time, value = speeds.window(positions.last, math.inf) if len(positions) else (speeds.time, speeds.value)
    if time.size < 2:
        if time.size and not len(positions):
            positions.add(time[:1], np.zeros(1))
        return
    start = float(positions.value[-1]) if len(positions) else 0.0
    moved = np.concatenate([[0.0], np.cumsum(0.5 * (value[1:] + value[:-1]) * np.diff(time))])
    positions.add(time, start + moved)


def new_buffers(kept: float) -> dict[str, SampleBuffer]:
    """An empty buffer for each channel."""
    return {name: SampleBuffer(kept) for name in (*DRIVING, *COMPARED)}


def _with_neighbours(buffer: SampleBuffer, begin: float, end: float) -> tuple[Array, Array]:
    """Samples from the last one before `begin` to the first one after `end`."""
    first = max(int(np.searchsorted(buffer.time, begin)) - 1, 0)
    last = int(np.searchsorted(buffer.time, end)) + 1
    return buffer.time[first:last].copy(), buffer.value[first:last].copy()
