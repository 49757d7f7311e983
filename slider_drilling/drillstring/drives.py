"""How top drive, drawworks and pump follow what they are told, within their limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.control.interface import RigCommand
from slider_drilling.rig import TopDrive

_SETTLING = 0.3  # s, over which the top drive closes what it lags behind its trajectory


@dataclass(frozen=True)
class DriveState:
    """Where the drives are: rad, rad/s; m, m/s; rad/s of the pump's crank."""

    top_drive_angle: float = 0.0
    top_drive_speed: float = 0.0
    block_position: float = 0.0
    block_speed: float = 0.0
    pump_speed: float = 0.0


def follow(
    state: DriveState, command: RigCommand, surface_torque: float, limits: TopDrive, interval: float
) -> DriveState:
    """The drives one interval (s) later.

    The top drive keeps to the trajectory (angle, speed) of the command at constant acceleration within its limits of
    speed and acceleration; against its torque limit (surface_torque, N m) it does not turn further. Block and pump
    reach their commanded speeds within the interval.
    """
    speed = _top_drive_speed(state, command, surface_torque, limits, interval)
    return DriveState(
        top_drive_angle=state.top_drive_angle + 0.5 * (state.top_drive_speed + speed) * interval,
        top_drive_speed=speed,
        block_position=state.block_position + 0.5 * (state.block_speed + command.block_speed) * interval,
        block_speed=command.block_speed,
        pump_speed=command.pump_speed,
    )


def _top_drive_speed(
    state: DriveState, command: RigCommand, surface_torque: float, limits: TopDrive, interval: float
) -> float:
    behind = command.top_drive_angle - state.top_drive_angle
    brakeable = math.sqrt(2.0 * limits.max_acceleration * abs(behind))
    wanted = command.top_drive_speed + math.copysign(min(abs(behind) / _SETTLING, brakeable), behind)
    wanted = min(max(wanted, -limits.max_speed), limits.max_speed)
    if abs(surface_torque) >= limits.max_torque and wanted * surface_torque > 0.0:
        wanted = 0.0
    change = limits.max_acceleration * interval
    return min(max(wanted, state.top_drive_speed - change), state.top_drive_speed + change)
