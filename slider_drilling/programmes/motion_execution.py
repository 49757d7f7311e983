"""Follows the motion of a step, and the motion that ends an aborted one."""

from __future__ import annotations

from dataclasses import replace

from slider_drilling.control.interface import RigCommand
from slider_drilling.programmes.motion import DriveStates, SpeedProfile, StepMotion
from slider_drilling.programmes.plan_motion import BLOCK_ACCELERATION

_STOPPING_SPEED = 0.25  # m/s2, of a block that is stopped by an abort
_LIFTING_SPEED = 0.1  # m/s
_FLOW_RAMP = 5.0  # s


class MotionExecution:
    """Plays a motion against the controller's clock.

    Args:
        motion: Of the drives.
        interval: Between samples, s.
    """

    def __init__(self, motion: StepMotion, interval: float) -> None:
        self.motion = motion
        self._interval = interval
        self.elapsed = 0.0  # s

    @property
    def done(self) -> bool:
        """Whether the motion is over."""
        return self.elapsed >= self.motion.duration

    def advance(self, step: float) -> None:
        """Go on by some time, s."""
        self.elapsed += step

    def command(self) -> RigCommand:
        """Setpoints for now; block and pump reach theirs at the next sample."""
        angle, speed = self.motion.top_drive.at(min(self.elapsed, self.motion.duration))
        coming = min(self.elapsed + self._interval, self.motion.duration)
        return RigCommand(angle, speed, self.motion.block.at(coming)[1], self.motion.pump.at(coming)[1])

    def turning_at(self, later: float) -> float:
        """Speed of the top drive so much later, s."""
        return self.motion.top_drive.at(min(self.elapsed + later, self.motion.duration))[1]

    def drives(self) -> DriveStates:
        """Where the drives are now, by the motion."""
        time = min(self.elapsed, self.motion.duration)
        angle, turning = self.motion.top_drive.at(time)
        block, lowering = self.motion.block.at(time)
        return replace(self.motion.end, angle=angle, turning=turning, block=block, lowering=lowering,
                       pump=self.motion.pump.at(time)[1])  # fmt: skip


def stopping_motion(drives: DriveStates, braking: float, lift: float, pump: float | None = None) -> StepMotion:
    """The motion that ends an aborted step: block and top drive stop, then the bit is lifted.

    Args:
        drives: Where they are.
        braking: Of the top drive, rad/s2.
        lift: Distance, m; 0 leaves the block where it stops.
        pump: Crank speed to go to, rad/s; None: as it is.
    """
    drive, block = SpeedProfile(drives.angle, drives.turning), SpeedProfile(drives.block, drives.lowering)
    flow = SpeedProfile(0.0, drives.pump)
    drive.ramp(0.0, abs(drives.turning) / braking)
    block.ramp(0.0, abs(drives.lowering) / _STOPPING_SPEED)
    block.travel(-lift, _LIFTING_SPEED, BLOCK_ACCELERATION)
    if pump is not None:
        flow.ramp(pump, _FLOW_RAMP)
    duration = max(drive.duration, block.duration, flow.duration)
    for profile in (drive, block, flow):
        profile.hold_until(duration)
    end = replace(drives, angle=drive.position, turning=0.0, block=block.position, lowering=0.0, block_speed=0.0,
                  pump=flow.speed)  # fmt: skip
    return StepMotion(duration, drive, block, flow, end)
