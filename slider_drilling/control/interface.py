"""The interface between a rig and its controller: measurements one way, commands the other.

Both sides import this module and neither imports the other, so a controller can be tested on
any rig and a rig with any controller. SI units, rad; times are rig (or simulation) seconds.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MwdSample:
    """A toolface as decoded at surface.

    measured_at: s, when the tool was read downhole; arrived_at: s, when surface had it;
    tool_face: rad, in (-pi, pi].
    """

    measured_at: float
    arrived_at: float
    tool_face: float


@dataclass(frozen=True)
class Measurements:
    """One sample of the surface channels; a channel that is missing is NaN.

    time: s; top_drive_angle: rad; top_drive_speed: rad/s; surface_torque: N m, what the top drive feels;
    block_position: m lowered since start; block_speed: m/s, positive lowers; hook_load: N;
    standpipe_pressure: Pa; pump_speed: rad/s of the crank; mwd: the toolfaces that arrived since
    the last sample, oldest first.
    """

    time: float
    top_drive_angle: float
    top_drive_speed: float
    surface_torque: float
    block_position: float
    block_speed: float
    hook_load: float
    standpipe_pressure: float
    pump_speed: float
    mwd: tuple[MwdSample, ...] = ()


@dataclass(frozen=True)
class RigCommand:
    """What a controller asks of the rig until its next command.

    top_drive_angle: rad and top_drive_speed: rad/s, the trajectory's point for now and its slope;
    block_speed: m/s, positive lowers; pump_speed: rad/s of the crank.
    """

    top_drive_angle: float
    top_drive_speed: float
    block_speed: float
    pump_speed: float
