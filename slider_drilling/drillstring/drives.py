"""Top drive, drawworks and pump: how they follow a command within their limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.control.interface import RigCommand
from slider_drilling.rig import TopDrive

_SETTLING = 0.3  # s, in which the top drive makes up what it is behind its trajectory


@dataclass(frozen=True)
class DriveState:
    """Positions and speeds of the drives: rad, rad/s; m lowered, m/s; rad/s of the pump's crank."""

    top_drive_angle: float = 0.0
    top_drive_speed: float = 0.0
    block_position: float = 0.0
    block_speed: float = 0.0
    pump_speed: float = 0.0


def follow_command(
    state: DriveState, command: RigCommand, surface_torque: float, limits: TopDrive, interval: float
) -> DriveState:
    """The drives one interval later.

    The top drive follows the command's trajectory (angle and speed) at constant acceleration within its limits. At its
    torque limit it does not turn further. Block and pump reach their commanded speeds within the interval.

    Args:
        surface_torque: N m.
        interval: s.
    """
    speed = next_top_drive_speed(
        state.top_drive_angle, state.top_drive_speed, command.top_drive_angle, command.top_drive_speed, surface_torque,
        limits.max_acceleration, limits.max_speed, limits.max_torque, interval,
    )  # fmt: skip
    return DriveState(
        top_drive_angle=state.top_drive_angle + 0.5 * (state.top_drive_speed + speed) * interval,
        top_drive_speed=speed,
        block_position=state.block_position + 0.5 * (state.block_speed + command.block_speed) * interval,
        block_speed=command.block_speed,
        pump_speed=command.pump_speed,
    )


def next_top_drive_speed(
    angle: float, speed: float, commanded_angle: float, commanded_speed: float, surface_torque: float,
    max_acceleration: float, max_speed: float, max_torque: float, interval: float,
) -> float:  # fmt: skip
    """Speed of the top drive one interval later, rad/s; plain arithmetic, which `training` compiles.

    Args:
        angle, speed: Of the drive now, rad and rad/s.
        commanded_angle, commanded_speed: Of the trajectory, rad and rad/s.
        surface_torque: N m.
        max_acceleration, max_speed, max_torque: Limits of the drive, rad/s2, rad/s and N m.
        interval: s.
    """
    behind = commanded_angle - angle
    braking_speed = math.sqrt(2.0 * max_acceleration * abs(behind))
    wanted = commanded_speed + math.copysign(min(abs(behind) / _SETTLING, braking_speed), behind)
    wanted = min(max(wanted, -max_speed), max_speed)
    if abs(surface_torque) >= max_torque and wanted * surface_torque > 0.0:
        wanted = 0.0
    change = max_acceleration * interval
    return min(max(wanted, speed - change), speed + change)
