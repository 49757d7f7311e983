"""Time series of one closed-loop run, for the score and the page."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


# Statuses whose errors stop lowering.
STOPPING = ("off_bottom_pressure", "load_channels", "weight_on_bit", "block_following", "circulation", "top_drive",
            "lock_up", "motor_stall", "draw_works", "surface_torque", "hook_load", "standpipe_pressure",
            "mwd_tool_face")


@dataclass(frozen=True)
class SlideTrace:
    """Time series at the rate of the sensors, all of shape (n,).

    Attributes:
        time: s.
        target: Toolface target, rad.
        tool_face: True toolface, unwrapped, rad.
        top_drive_angle: Measured, rad.
        surface_torque: True, N m.
        weight_on_bit: True, N.
        rate_of_penetration: True, m/s.
        bit_depth: True measured depth of the bit, m.
        differential_pressure: True, of the motor, Pa; empty where it was not kept.
        events: (s, level, name, message) of each change of level in the controller's status.
    """

    time: Array
    target: Array
    tool_face: Array
    top_drive_angle: Array
    surface_torque: Array
    weight_on_bit: Array
    rate_of_penetration: Array
    bit_depth: Array
    events: tuple[tuple[float, str, str, str], ...]
    differential_pressure: Array = field(default_factory=lambda: np.empty(0))

    @property
    def stops(self) -> tuple[str, ...]:
        """Names of the statuses that stopped lowering with an error, in the order of their first one."""
        return tuple(dict.fromkeys(name for _, level, name, _ in self.events if level == "ERROR" and name in STOPPING))
