"""How far the channels of a rig wander that does not change: what is left within that is no gap."""

from __future__ import annotations

import math

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.gap.model import Channel
from slider_drilling.log_inputs.off_bottom_pressure import off_bottom_factor, pump_runs
from slider_drilling.log_inputs.steady_rotation import rotates_steadily
from slider_drilling.rig import Rig
from slider_drilling.wellbore.static_loads import static_loads

# Shares by which numbers of a rig wander that does not change, with the rock, the cuttings and the depth of cut:
# friction, and the bit's torque per weight, which nothing but the motor's pressure shows.
FRICTION_WANDER, BIT_TORQUE_WANDER = 0.01, 0.02
# Noise levels of the motor's pressure above which the bit carries weight: the lowest of a log is two below its mean.
DRILLS = 5.0


def channel_wander(channel: Channel, rig: Rig, commands: Commands) -> float:
    """RMS by which a channel wanders, in its unit, because friction and the bit's torque do.

    Args:
        channel: What was measured.
        rig: The rig file.
        commands: What drove the rig.
    """
    if channel.time.size == 0 or channel.name not in ("surface_torque", "standpipe_pressure"):
        return 0.0
    if channel.name == "surface_torque":
        return FRICTION_WANDER * float(np.sqrt(np.mean(channel.measured**2)))
    circulation = rig.circulation_at(np.interp(channel.time, commands.time, commands.pump_speed))
    running = pump_runs(circulation)
    if not running.any():
        return 0.0
    pressure, circulation = channel.measured[running], circulation[running]
    # A bit that is never off bottom shows more than circulation needs.
    of_motor = np.maximum(pressure - min(off_bottom_factor(pressure, circulation), 1.0) * circulation, 0.0)
    drills = of_motor > DRILLS * (channel.declared_noise or 0.0)
    of_weight = FRICTION_WANDER * _friction_along_string(rig, commands) * rig.bit.lever / rig.motor.torque_per_pressure
    return math.hypot(
        BIT_TORQUE_WANDER * float(np.sqrt(np.mean(of_motor**2))), of_weight * math.sqrt(float(np.mean(drills)))
    )


def _friction_along_string(rig: Rig, commands: Commands) -> float:
    """RMS, N, of the friction that keeps weight from the bit: that of a lowered string, none while it rotates."""
    drag = static_loads(rig, rotation_speed=1.0).hook_load - static_loads(rig, axial_speed=1.0).hook_load
    slides = ~rotates_steadily(commands.time, commands.top_drive_speed)
    return drag * math.sqrt(float(np.mean(slides)))
