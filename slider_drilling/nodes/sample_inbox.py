"""Collects the surface channels of one sample from their topics."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.control.interface import Measurements, MwdSample

NAN = float("nan")


@dataclass(frozen=True)
class JointReading:
    """One reading: stamp, ns; position, rad or m (or Pa); velocity, rad/s or m/s; effort, N m or N."""

    stamp_ns: int
    position: float
    velocity: float
    effort: float


class SampleInbox:
    """Combines readings into samples, one for every reading of the top drive.

    A reading of the top drive waits until the other channels have reached its stamp. It does not wait beyond the top
    drive's next reading, nor for a stale channel. Stale channels are NaN in the sample.

    Args:
        stale_after: Age at which a channel counts as lost, s.

    Attributes:
        last_reading: The reading of the top drive that gave the last sample.
    """

    CHANNELS = ("draw_works", "standpipe_pressure", "mud_pump")

    def __init__(self, stale_after: float) -> None:
        self.stale_after = stale_after
        self.last_reading: JointReading | None = None
        self.clear()

    def clear(self) -> None:
        """Forget the readings that wait for others, as before the first one."""
        self._last: dict[str, JointReading] = {}
        self._first_ns: int | None = None
        self._waiting: JointReading | None = None
        self._mwd: list[tuple[int, float]] = []

    def put(self, channel: str, reading: JointReading) -> list[Measurements]:
        """Take a reading of any channel and return the samples that it completes."""
        complete = []
        if channel == "top_drive":
            if self._first_ns is None:
                self._first_ns = reading.stamp_ns
            if self._waiting is not None:
                complete.append(self._take(self._waiting))
            self._waiting = reading
        else:
            self._last[channel] = reading
        if self._waiting is not None and all(self._is_settled(name, self._waiting) for name in self.CHANNELS):
            complete.append(self._take(self._waiting))
        return complete

    def put_mwd(self, measured_ns: int, tool_face: float) -> None:
        """Take a decoded toolface; it goes with the next sample."""
        self._mwd.append((measured_ns, tool_face))

    def stale_channels(self, stamp_ns: int) -> list[str]:
        """Channels without a reading within `stale_after` of a stamp."""
        return [name for name in self.CHANNELS if not self._is_fresh(name, stamp_ns)]

    def empty_sample(self, stamp_ns: int) -> Measurements:
        """A sample without readings, for a silent rig."""
        return Measurements(stamp_ns / 1e9, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN)

    def _is_fresh(self, channel: str, stamp_ns: int) -> bool:
        last = self._last.get(channel)
        return last is not None and abs(last.stamp_ns - stamp_ns) <= self.stale_after * 1e9

    def _is_settled(self, channel: str, waiting: JointReading) -> bool:
        """Whether a sample need not wait for the channel."""
        last = self._last.get(channel)
        if last is None:
            silent_since = waiting.stamp_ns if self._first_ns is None else self._first_ns
            return waiting.stamp_ns - silent_since > self.stale_after * 1e9
        return last.stamp_ns >= waiting.stamp_ns or not self._is_fresh(channel, waiting.stamp_ns)

    def _take(self, top_drive: JointReading) -> Measurements:
        self._waiting = None
        self.last_reading = top_drive
        now = top_drive.stamp_ns
        lost = JointReading(now, NAN, NAN, NAN)
        block, standpipe, pump = (self._last[name] if self._is_fresh(name, now) else lost for name in self.CHANNELS)
        mwd = tuple(
            MwdSample(measured / 1e9, now / 1e9, math.remainder(tool_face, 2.0 * math.pi))
            for measured, tool_face in self._mwd
        )
        self._mwd.clear()
        return Measurements(
            time=now / 1e9,
            top_drive_angle=top_drive.position,
            top_drive_speed=top_drive.velocity,
            surface_torque=top_drive.effort,
            block_position=block.position,
            block_speed=block.velocity,
            hook_load=block.effort,
            standpipe_pressure=standpipe.position,
            pump_speed=pump.velocity,
            mwd=mwd,
        )
