"""What happened in one run, as it is scored and drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SlideTrace:
    """At the sensors' rate: time s; target, tool_face rad (unwrapped truth); top_drive_angle rad; surface_torque N m
    without noise; weight_on_bit N; rate_of_penetration m/s; bit_depth m; events: (s, level, name, message) of each
    change of an interlock."""

    time: Array
    target: Array
    tool_face: Array
    top_drive_angle: Array
    surface_torque: Array
    weight_on_bit: Array
    rate_of_penetration: Array
    bit_depth: Array
    events: tuple[tuple[float, str, str, str], ...]
