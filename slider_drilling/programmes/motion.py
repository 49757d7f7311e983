"""Motion of the drives during a step: speeds that are linear in time, and the positions that they integrate to."""

from __future__ import annotations

import bisect
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DriveStates:
    """Where the drives are at the start of a step.

    Attributes:
        angle: Of the top drive, rad.
        turning: Speed of the top drive, rad/s.
        block: Position of the block, m lowered.
        lowering: Speed of the block now, m/s.
        block_speed: Of the last block-speed step, to which the block returns, m/s.
        pump: Crank speed of the pump, rad/s.
        deepest: Lowest position of the block so far, or that at which the bit touches bottom at the start, m.
        touching: Position of the block at which the bit touches bottom without weight, m.
    """

    angle: float
    turning: float
    block: float
    lowering: float
    block_speed: float
    pump: float
    deepest: float
    touching: float


class SpeedProfile:
    """A speed that is linear between points in time, and its integral.

    Args:
        position: At time 0.
        speed: At time 0.
    """

    def __init__(self, position: float, speed: float) -> None:
        self._times, self._speeds, self._positions = [0.0], [speed], [position]

    @property
    def duration(self) -> float:
        """s; afterwards the speed stays."""
        return self._times[-1]

    @property
    def position(self) -> float:
        """At the end."""
        return self._positions[-1]

    @property
    def speed(self) -> float:
        """At the end."""
        return self._speeds[-1]

    @property
    def highest(self) -> float:
        """Largest position at any of its points; where a speed changes sign there is one."""
        return max(self._positions)

    def ramp(self, speed: float, time: float) -> None:
        """Change the speed linearly within a time, s; nothing where it is that speed already."""
        if speed != self.speed and time > 0.0:
            self._add(speed, time)

    def hold(self, time: float) -> None:
        """Keep the speed for a time, s."""
        if time > 0.0:
            self._add(self.speed, time)

    def hold_until(self, time: float) -> None:
        """Keep the speed until a time, s."""
        self.hold(time - self.duration)

    def travel(self, distance: float, speed: float, acceleration: float) -> None:
        """Go so far from rest to rest, at a speed (positive) where the distance allows it.

        Args:
            distance: With its sign.
            speed: Largest magnitude.
            acceleration: Of both ends.
        """
        if distance == 0.0:
            return
        direction, length = (1.0, distance) if distance > 0.0 else (-1.0, -distance)
        peak = min(speed, (length * acceleration) ** 0.5)
        self.ramp(direction * peak, peak / acceleration)
        self.hold(length / peak - peak / acceleration)
        self.ramp(0.0, peak / acceleration)

    def at(self, time: float) -> tuple[float, float]:
        """Position and speed at a time, s, not below 0."""
        cell = bisect.bisect_right(self._times, time) - 1
        since, speed = time - self._times[cell], self._speeds[cell]
        if cell < len(self._times) - 1:
            slope = (self._speeds[cell + 1] - speed) / (self._times[cell + 1] - self._times[cell])
        else:
            slope = 0.0
        return self._positions[cell] + (speed + 0.5 * slope * since) * since, speed + slope * since

    def sample(self, time: Array) -> tuple[Array, Array]:
        """Positions and speeds (n,) at times (n,), s, not below 0."""
        times, speeds = np.array(self._times), np.array(self._speeds)
        cell = np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 1)
        since, speed = time - times[cell], np.interp(time, times, speeds)
        return np.array(self._positions)[cell] + 0.5 * (speeds[cell] + speed) * since, speed

    def _add(self, speed: float, time: float) -> None:
        self._positions.append(self.position + 0.5 * (self.speed + speed) * time)
        self._times.append(self.duration + time)
        self._speeds.append(speed)


@dataclass(frozen=True)
class StepMotion:
    """Motion of all three drives during one step.

    Attributes:
        duration: s.
        top_drive: Angle rad and speed rad/s.
        block: m lowered and m/s.
        pump: Crank speed, rad/s, is the profile's speed.
        end: Where the drives are at its end.
    """

    duration: float
    top_drive: SpeedProfile
    block: SpeedProfile
    pump: SpeedProfile
    end: DriveStates
